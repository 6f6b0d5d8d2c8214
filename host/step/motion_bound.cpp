#include "step/motion_bound.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/brick_overlap.h"

namespace quoin {
namespace {

constexpr std::size_t kNext[3] = {1, 2, 0}, kLast[3] = {2, 0, 1};

std::string describe(const Assembly& assembly, int block) {
  const Brick& brick = assembly.bricks[static_cast<std::size_t>(block)];
  const Vec3 at = centre_of(brick);
  return fmt::format("block {}{} at ({:.3f}, {:.3f}, {:.3f}) m", block,
                     brick.body.empty() ? "" : fmt::format(" '{}'", brick.body), at[0], at[1], at[2]);
}

}  // namespace

Vec3 at_arm(const WholeMotion& m, const Vec3& arm) { return m.translation + cross(m.rotation, arm); }

namespace {

// Sides of the box around the bricks that count, m; -infinity without any.
template <class Counts>
Vec3 extent_of(const std::vector<Brick>& bricks, const Counts& counts) {
  Vec3 extent;
  for (std::size_t c = 0; c < 3; ++c) {
    double from = std::numeric_limits<double>::infinity(), to = -from;
    for (const Brick& b : bricks)
      if (counts(b)) from = std::min(from, b.origin[c]), to = std::max(to, b.origin[c] + b.size[c]);
    extent[c] = to - from;
  }
  return extent;
}

}  // namespace

double diagonal_of(const std::vector<Brick>& bricks) {
  return norm_of(extent_of(bricks, [](const Brick&) { return true; }));
}

Vec3 centre_of(const Brick& brick) { return brick.origin + 0.5 * brick.size; }

WholeMotion whole_motion(const Vec3& size, const std::array<Vec3, 8>& corner) {
  WholeMotion m;
  double gradient[3][3];  // derivative of component c along axis k
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 3; ++k) {
      double difference = 0.0;
      for (std::size_t i = 0; i < 8; ++i) difference += (i >> k & 1 ? 0.25 : -0.25) * corner[i][c];
      gradient[c][k] = difference / size[k];
    }
  }
  for (const Vec3& u : corner) m.translation += 0.125 * u;
  for (std::size_t c = 0; c < 3; ++c)
    m.rotation[c] = 0.5 * (gradient[kLast[c]][kNext[c]] - gradient[kNext[c]][kLast[c]]);
  return m;
}

JointSliding::JointSliding(const Assembly& assembly, Places places)
    : assembly_(&assembly),
      diagonal_(diagonal_of(assembly.bricks)),
      extent_(extent_of(assembly.bricks, [](const Brick& b) { return !b.fixed && !b.beam; })) {
  if (places == Places::recomputed) return;
  for (const Joint& joint : assembly.joints) kept_.push_back(place_of(joint));
}

JointSliding::Place JointSliding::place_of(const Joint& joint) const {
  Place place{};
  place.a = joint.block_a, place.b = joint.block_b;
  const Brick& a = assembly_->bricks[static_cast<std::size_t>(joint.block_a)];
  const Brick& b = assembly_->bricks[static_cast<std::size_t>(joint.block_b)];
  const auto normal = static_cast<std::size_t>(joint.face_a / 2);
  place.normal = static_cast<int>(normal), place.towards_b = joint.face_a % 2 == 1 ? 1.0 : -1.0;
  place.centre[normal] = a.origin[normal] + (joint.face_a % 2 == 1 ? a.size[normal] : 0.0);
  int i = 0;
  const Overlap shared = overlap_of(a, b);
  for (const std::size_t c : {kNext[normal], kLast[normal]}) {
    place.centre[c] = 0.5 * (shared.from[c] + shared.to[c]);
    place.along[static_cast<std::size_t>(i)] = static_cast<int>(c);
    place.length[static_cast<std::size_t>(i++)] = -shared.gap(c);
  }
  place.arm_a = place.centre - centre_of(a), place.arm_b = place.centre - centre_of(b);
  return place;
}

void JointSliding::look(const std::vector<WholeMotion>& motion, MotionSeen* seen, int upright) const {
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const double angle = norm_of(motion[i].rotation), moved = norm_of(motion[i].translation) / diagonal_;
    if (exceeds(angle, seen->rotation)) seen->rotation = angle, seen->turned_block = static_cast<int>(i);
    if (exceeds(moved, seen->translation)) seen->translation = moved, seen->moved_block = static_cast<int>(i);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (static_cast<int>(c) == upright) continue;
    const auto [least, most] =
        std::ranges::minmax_element(motion, {}, [c](const WholeMotion& m) { return m.translation[c]; });
    if (least == motion.end() || !(extent_[c] > 0.0)) continue;
    const double sway = (most->translation[c] - least->translation[c]) / extent_[c];
    const auto farthest = std::abs(most->translation[c]) > std::abs(least->translation[c]) ? most : least;
    if (exceeds(sway, seen->sway)) seen->sway = sway, seen->swaying_block = farthest - motion.begin();
  }
  for (std::size_t j = 0; assembly_ && j < assembly_->joints.size(); ++j) {
    Place found;
    if (kept_.empty()) found = place_of(assembly_->joints[j]);
    const Place& p = kept_.empty() ? found : kept_[j];
    const Vec3 a = at_arm(motion[static_cast<std::size_t>(p.a)], p.arm_a);
    const Vec3 b = at_arm(motion[static_cast<std::size_t>(p.b)], p.arm_b);
    for (std::size_t k = 0; k < 2; ++k) {
      const auto c = static_cast<std::size_t>(p.along[k]);
      const double sliding = std::abs(b[c] - a[c]) / p.length[k];
      if (exceeds(sliding, seen->sliding)) seen->sliding = sliding, seen->slid_joint = static_cast<int>(j);
    }
    const auto n = static_cast<std::size_t>(p.normal);
    const double opening = p.towards_b * (b[n] - a[n]) / std::min(p.length[0], p.length[1]);
    if (exceeds(opening, seen->opening)) seen->opening = opening, seen->opened_joint = static_cast<int>(j);
  }
}

std::string past_bound(const MotionSeen& seen, const MotionBound& bound, const Assembly& assembly) {
  if (exceeds(seen.rotation, bound.rotation)) {
    return fmt::format(
        "{} has turned by {:.3g} rad, more than solver.rotation_bound = {:g}: displacements are no "
        "longer small",
        describe(assembly, seen.turned_block), seen.rotation, bound.rotation);
  }
  if (const double allowed = kSwayOverRotation * bound.rotation; exceeds(seen.sway, allowed)) {
    return fmt::format(
        "{} has moved sideways by {:.3g} of the extent of the units along its way, more than {:.3g} (1.5 "
        "solver.rotation_bound): lever arms of vertical loads are no longer those of the start",
        describe(assembly, static_cast<int>(seen.swaying_block)), seen.sway, allowed);
  }
  if (exceeds(seen.sliding, bound.sliding)) {
    const Joint& joint = assembly.joints[static_cast<std::size_t>(seen.slid_joint)];
    return fmt::format(
        "{} and {} have slid on each other by {:.3g} of the length of their joint, more than "
        "solver.sliding_bound = {:g}: displacements are no longer small",
        describe(assembly, joint.block_a), describe(assembly, joint.block_b), seen.sliding, bound.sliding);
  }
  if (exceeds(seen.opening, kOpeningBound)) {
    const Joint& joint = assembly.joints[static_cast<std::size_t>(seen.opened_joint)];
    return fmt::format(
        "{} and {} have parted by {:.3g} of the shorter side of their joint, more than {:g}: displacements are no "
        "longer "
        "small",
        describe(assembly, joint.block_a), describe(assembly, joint.block_b), seen.opening, kOpeningBound);
  }
  if (exceeds(seen.nearness, kNearnessBound)) {
    return fmt::format("{} and {}, which no joint joins, {}: small displacements have no contact between them",
                       describe(assembly, seen.near_block[0]), describe(assembly, seen.near_block[1]),
                       seen.gap > 0.0 ? fmt::format("have come as near to each other as {:.3g} m", seen.gap)
                                      : fmt::format("overlap by {:.3g} m", -seen.gap));
  }
  if (exceeds(seen.translation, kTranslationBound)) {
    return fmt::format(
        "{} has moved by {:.3g} times the diagonal of the model, more than {:g}: displacements are no "
        "longer small",
        describe(assembly, seen.moved_block), seen.translation, kTranslationBound);
  }
  return "";
}

}  // namespace quoin
