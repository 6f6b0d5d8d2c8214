#include "step/unjoined_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.h"
#include "scene/brick_overlap.h"
#include "step/motion_bound.h"

namespace quoin {

using geometry::Pair;

namespace {

constexpr double kTouching = 1e-4;  // share of the least extent: blocks closer than this at the start touch

}  // namespace

UnjoinedBlocks::UnjoinedBlocks(const Assembly& assembly) : assembly_(&assembly) {
  double least = std::numeric_limits<double>::infinity();
  for (const Brick& brick : assembly.bricks) least = std::min(least, least_extent(brick));
  reach_ = 0.5 * least;
  for (const Joint& j : assembly.joints)
    joined_.push_back({std::min(j.block_a, j.block_b), std::max(j.block_a, j.block_b)});
  for (const auto& [a, b] : assembly.apart) joined_.push_back({std::min(a, b), std::max(a, b)});
  std::sort(joined_.begin(), joined_.end());
}

bool UnjoinedBlocks::has_moved(const std::vector<WholeMotion>& motion) const {
  if (there_.empty()) return true;
  for (std::size_t i = 0; i < motion.size(); ++i) {
    if (exceeds(norm_of(motion[i].translation - there_[i]), 0.125 * reach_)) return true;
  }
  return false;
}

void UnjoinedBlocks::find_pairs(const std::vector<WholeMotion>& motion) {
  std::vector<geometry::Box> boxes;
  there_.clear();
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const Brick& brick = assembly_->bricks[i];
    const double margin = 0.75 * reach_ + 0.5 * norm_of(motion[i].rotation) * norm_of(brick.size);
    geometry::Box box;
    for (std::size_t c = 0; c < 3; ++c) {
      box.lower[static_cast<int>(c)] = brick.origin[c] + motion[i].translation[c] - margin;
      box.upper[static_cast<int>(c)] = brick.origin[c] + brick.size[c] + motion[i].translation[c] + margin;
    }
    boxes.push_back(box);
    there_.push_back(motion[i].translation);
  }
  pairs_ = geometry::overlapping_pairs(boxes);
  std::erase_if(pairs_, [&](const Pair& pair) { return std::binary_search(joined_.begin(), joined_.end(), pair); });
}

// Uses the displacements of both blocks at the middle of the gap between them, or of their overlap along each axis.
UnjoinedBlocks::Near UnjoinedBlocks::nearness(const Pair& pair, const std::vector<WholeMotion>& motion,
                                              double sliding_bound) const {
  const Brick &a = assembly_->bricks[at(pair.a)], &b = assembly_->bricks[at(pair.b)];
  const WholeMotion &of_a = motion[at(pair.a)], &of_b = motion[at(pair.b)];
  const Overlap shared = overlap_of(a, b);
  const Vec3 middle = 0.5 * (shared.from + shared.to);
  const Vec3 u_a = at_arm(of_a, middle - centre_of(a)), u_b = at_arm(of_b, middle - centre_of(b));
  Near near{-std::numeric_limits<double>::infinity(), 0.0, 0};
  double at_start = near.gap;
  for (std::size_t c = 0; c < 3; ++c) {
    at_start = std::max(at_start, shared.gap(c));
    const double gap = std::max(a.origin[c] + u_a[c], b.origin[c] + u_b[c]) -
                       std::min(a.origin[c] + a.size[c] + u_a[c], b.origin[c] + b.size[c] + u_b[c]);
    if (exceeds(gap, near.gap)) near.gap = gap, near.axis = static_cast<int>(c);
  }
  const double least = std::min(least_extent(a), least_extent(b));
  if (at_start <= kTouching * least) {
    near.least_gap = -sliding_bound * least;
    return near;
  }
  // Corners of opposite faces come nearer than the middles of these where blocks rotate.
  double squares = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (static_cast<int>(c) != near.axis && shared.gap(c) < 0.0) squares += shared.gap(c) * shared.gap(c);
  }
  near.gap -= 0.5 * std::sqrt(squares) * (norm_of(of_a.rotation) + norm_of(of_b.rotation));
  near.least_gap = 0.5 * std::min(at_start, reach_);
  return near;
}

double UnjoinedBlocks::look(const std::vector<WholeMotion>& motion, double sliding_bound, double acceleration,
                            const HaveContact& have_contact, MotionSeen* seen) {
  if (has_moved(motion)) find_pairs(motion);
  double fastest = 0.0;
  for (const WholeMotion& m : motion) fastest = std::max(fastest, m.speed);
  double time = time_for(0.25 * reach_, 2.0 * fastest, acceleration);  // for pairs that are not near yet
  for (const Pair& pair : pairs_) {
    const Near near = nearness(pair, motion, sliding_bound);
    if (near.gap <= near.least_gap && !have_contact(pair.a, pair.b, near.axis)) continue;
    const double value = near.least_gap > 0.0 ? near.least_gap / std::max(near.gap, 1e-3 * near.least_gap)
                                              : std::max(0.0, near.gap / near.least_gap);
    if (exceeds(value, seen->nearness)) {
      seen->nearness = value, seen->gap = near.gap;
      seen->near_block[0] = pair.a, seen->near_block[1] = pair.b;
    }
    if (near.gap > near.least_gap && near.least_gap > 0.0)
      time = std::min(time, time_for(near.gap - 0.5 * near.least_gap,
                                     motion[at(pair.a)].speed + motion[at(pair.b)].speed, acceleration));
  }
  return time;
}

}  // namespace quoin
