// When blocks have moved enough for contact detection. A pair, and a block since the last broad phase, may move
// by some way. From how fast it moves follows the step before which it cannot have, and until then nobody looks at it.
// What is reckoned with is the motion that a block was seen in. A block that leaves it by more than a small speed,
// which is allowed for, deviates (rigid_kernels.cpp). All that it belongs to is checked in that very step. So no rigid
// block comes further than it may unseen, whatever hits it, and a look costs only those that are due.
//
// Deformable blocks are not seen so closely. Theirs is a rule of thumb: none gains speed faster than at 10 g.
#include <algorithm>
#include <bit>

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// The speed that a block may gain unnoticed uses up the way of a pair of the smallest ones in so many steps. One number
// is for the first check, one for blocks that deviate all the time.
constexpr double kCalmSteps = 1000.0, kBusySteps = 50.0;
// Blocks that deviate sooner than this may gain twice as much from then on, those later than that half of it,
// steps.
constexpr long kSoon = 30, kLate = 300;
constexpr long kMostSteps = 1000;  // between two looks at the same
// Acceleration that looks at deformable blocks reckon with, and the share of their way that each of two may use up
// until then. More of either: more looks.
constexpr double kAcceleration = 100.0;  // m/s2, 10 g
constexpr double kOfWay = 0.25;
// Of the way of a pair, from where on it is looked at closely together with others that have moved by all of it.
constexpr double kRipe = 0.8;
// Of the skin, that a block may move by before the broad phase is looked at.
constexpr double kOfSkin = 0.25;
// Blocks turned by more than this (rad) end the small-displacement mode: frozen normals would be wrong by as much.
constexpr double kSmallRotation = 1e-3;

}  // namespace

bool World::moved_enough() {
  const bool all = dt_ != check_dt_;
  if (step_count_ < next_check_ && !any_deviates_ && !all) return false;
  if (all) check_dt_ = dt_;
  receive_neighbours();
  due_.assign(blocks_.size(), all);
  seen_.resize(bodies_.size());
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!laid_out_[i] || blocks_[i].body < 0 || !(all || block_sums_[i].deviates)) continue;
    see(int(i));
    due_[i] = 1, block_sums_[i].deviates = false;
  }
  any_deviates_ = false;

  bool moved = false;
  next_check_ = step_count_ + kMostSteps;
  block_check_.resize(blocks_.size(), 0);
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!owns(int(i))) continue;
    long& step = block_check_[i];
    if (due_[i] || step <= step_count_) moved |= check_block_motion(int(i), step);
    next_check_ = std::min(next_check_, step);
  }
  // Motion of a deformable block costs more than the rest of a check, and each block is in several pairs.
  thread_local LaneVector<CheckedMotion> motions;
  thread_local std::vector<uint8_t> known;
  motions.resize(blocks_.size()), known.assign(blocks_.size(), 0);
  const auto motion_now = [&](int block) -> const CheckedMotion& {
    if (!known[size_t(block)]) motions[size_t(block)] = checked_motion(block), known[size_t(block)] = 1;
    return motions[size_t(block)];
  };
  for (size_t i = 0; i < contacts_.size(); ++i) {
    if (!owns(contacts_[i])) continue;
    PairCheck& check = pair_check_[i];
    if (due_[size_t(check.a)] || due_[size_t(check.b)] || check.step <= step_count_) {
      const Contact& c = contacts_[i];
      moved |= check_pair_motion(c, pair_place_[i], motion_now(c.pair.a), motion_now(c.pair.b), check);
    }
    next_check_ = std::min(next_check_, check.step);
  }
  if (ranks_) {
    double of_all[] = {moved ? 1.0 : 0.0, double(-next_check_)};
    ranks_->largest(of_all);
    moved = of_all[0] > 0.0, next_check_ = long(-of_all[1]);
  }
  if (moved && small_) {
    small_ = false;  // for good: what has moved once will move again
    for (size_t i = 0; i < blocks_.size(); ++i) {
      if (blocks_[i].body < 0) continue;
      next_check_ = step_count_ + 1;  // its way is another one
      if (laid_out_[i]) block_check_[i] = next_check_;
    }
  }
  return moved;
}

World::CheckedMotion World::checked_motion(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  double squared = 0.0;
  if (b.body < 0) {  // its corners are its first gridpoints
    const size_t corners = b.shape->vertices.size();
    for (const Vector& v : std::span(node_v_).subspan(size_t(b.first_node), corners))
      squared = std::max(squared, dot(v, v));
  } else {
    const Body& body = bodies_[size_t(b.body)];
    squared = std::max(dot(body.v, body.v), dot(body.omega, body.omega) * b.radius * b.radius);
  }
  return {pose(block), 2 * std::sqrt(squared)};
}

void World::see(int i) {
  const ModelBlock& b = blocks_[size_t(i)];
  const Body& body = bodies_[size_t(b.body)];
  SeenMotion& seen = seen_[size_t(b.body)];
  const double way_a_step = detection_fraction() * size_ / dt_;
  double unnoticed = seen.unnoticed;
  const long since = step_count_ - seen.step;
  if (block_sums_[size_t(i)].deviates && since < kSoon) unnoticed *= 2.0;
  if (since > kLate) unnoticed *= 0.5;
  unnoticed = std::clamp(unnoticed, way_a_step / kCalmSteps, way_a_step / kBusySteps);
  seen = {body.v, b.radius, body.omega, unnoticed, step_count_};
}

// A step before which nothing this fast can have gone all of the way. Distant ones are rounded down, so that many looks
// fall into one step.
long World::step_after(double way, double speed, double acceleration) const {
  // speed t + acceleration t^2/2 = way
  const double steps = 2 * way / ((speed + std::sqrt(speed * speed + 2 * acceleration * way)) * dt_);
  if (!(steps >= 2.0)) return step_count_ + 1;
  const long last = step_count_ + long(std::min(steps, double(kMostSteps)));
  const long round = long(std::bit_floor(std::uint64_t(last - step_count_) / 4 + 1));
  return std::max(step_count_ + 1, last - last % round);
}

// Long before a deformable block of this speed, m/s, can have moved by the tolerance.
long World::step_of_gridpoints(double speed) const {
  return step_after(kOfWay * detection_fraction() * size_, speed, kAcceleration);
}

// Small displacement also means that no block has come near others that are not its neighbours. And frozen frames on
// deformable blocks still point the right way.
bool World::check_block_motion(int i, long& step) const {
  const ModelBlock& b = blocks_[size_t(i)];
  double moved, turned = 0.0;
  if (small_) {
    Vector x;
    Matrix r;
    pose(i, x, r);
    const Pose& start = start_[size_t(i)];
    moved = norm(x - start.x), turned = angle_between(r, start.r);
  } else {
    moved = motion_since_broad_phase(i);
  }
  const double way = kOfSkin * skin_;
  if (b.body < 0) {
    step = step_of_gridpoints(checked_motion(i).speed);
  } else {
    const SeenMotion& seen = seen_[size_t(b.body)];
    const double spin = norm(seen.omega) + seen.unnoticed / b.radius;
    step = step_after(way - moved, norm(seen.v) + seen.unnoticed + norm(seen.omega) * b.radius);
    if (small_) step = std::min(step, step_after(kSmallRotation - turned, spin));
  }
  return moved > way || turned > kSmallRotation;
}

bool World::check_pair_motion(const Contact& c, const PairPlace& place, const CheckedMotion& now_a,
                              const CheckedMotion& now_b, PairCheck& check) const {
  const double moved = pair_motion(c, place, now_a.pose, now_b.pose), way = allowed_motion(c, place);
  check = {c.pair.a, c.pair.b, moved > kRipe * way, step_of_gridpoints(std::max(now_a.speed, now_b.speed))};
  const ModelBlock &a = blocks_[size_t(c.pair.a)], &b = blocks_[size_t(c.pair.b)];
  if (a.body >= 0 && b.body >= 0 && check_dt_ > 0.0) {
    // As pair_motion: of b as seen from a.
    const SeenMotion &of_a = seen_[size_t(a.body)], &of_b = seen_[size_t(b.body)];
    const Vector apart = bodies_[size_t(b.body)].x - bodies_[size_t(a.body)].x;
    const double distance = norm(apart), lever = lever_of(c, distance);
    const double seen = norm(of_b.v - of_a.v - cross(of_a.omega, apart)) + lever * norm(of_b.omega - of_a.omega);
    const double unnoticed = of_a.unnoticed * std::max(1.0, (distance + lever) / a.radius) +
                             of_b.unnoticed * std::max(1.0, lever / b.radius);
    // a turns away below b, which flies straight on: |R(omega t) - 1 - omega t x| <= (omega t)^2/2.
    const double spin = norm(of_a.omega) + of_a.unnoticed / a.radius;
    check.step = step_after((check.ripe ? 1.0 : kRipe) * way - moved, seen + unnoticed, spin * spin * distance);
  }
  return moved > way;
}

}  // namespace quoin::blocks
