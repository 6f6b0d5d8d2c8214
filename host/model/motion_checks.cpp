// When blocks have moved enough for contact detection. A pair, and a block since the last broad phase, may move
// by some way. From how fast it moves follows the step before which it cannot have, and until then nobody looks at it.
// What is reckoned with is the motion that a block was seen in. A block that leaves it by more than a small speed,
// which is allowed for, deviates (rigid_kernels.cpp). All that it belongs to is checked in that very step. So no rigid
// block comes further than it may unseen, whatever hits it, and a look costs only those that are due.
//
// Deformable blocks are not seen so closely: theirs is a rule of thumb, by the fastest of all blocks.
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
// Of the way of a pair, from where on it is looked at closely together with others that have moved by all of it.
constexpr double kRipe = 0.8;
// Of the skin, that a block may move by before the broad phase is looked at.
constexpr double kOfSkin = 0.25;
// Blocks turned by more than this (rad) end the small-displacement mode: frozen normals would be wrong by as much.
constexpr double kSmallRotation = 1e-3;

}  // namespace

bool World::moved_enough() {
  const bool all = stepping_.dt != checks_.dt && !bodies_.empty();
  if (stepping_.count < checks_.next && !checks_.any_deviates && !all) return false;
  if (all) checks_.dt = stepping_.dt;
  receive_neighbours();
  checks_.due.assign(blocks_.size(), all);
  checks_.seen.resize(bodies_.size());
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!part_.laid_out[i] || blocks_[i].body < 0 || !(all || step_sums_.of_block[i].deviates)) continue;
    see(int(i));
    checks_.due[i] = 1, step_sums_.of_block[i].deviates = false;
  }
  checks_.any_deviates = false;
  checks_.calm_steps = nodes_.x.empty() ? 0 : steps_of_gridpoints();

  bool moved = false;
  checks_.next = stepping_.count + kMostSteps;
  checks_.block.resize(blocks_.size(), 0);
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!owns(int(i))) continue;
    long& step = checks_.block[i];
    if (checks_.due[i] || step <= stepping_.count) moved |= check_block_motion(int(i), step);
    checks_.next = std::min(checks_.next, step);
  }
  // A pose of a deformable block costs more than the rest of a check, and each block is in several pairs.
  thread_local LaneVector<Pose> poses;
  thread_local std::vector<uint8_t> known;
  poses.resize(blocks_.size()), known.assign(blocks_.size(), 0);
  const auto pose_now = [&](int block) -> const Pose& {
    if (!known[size_t(block)]) poses[size_t(block)] = pose(block), known[size_t(block)] = 1;
    return poses[size_t(block)];
  };
  for (size_t i = 0; i < contacts_.list.size(); ++i) {
    if (!owns(contacts_.list[i])) continue;
    PairCheck& check = checks_.pair[i];
    if (checks_.due[size_t(check.a)] || checks_.due[size_t(check.b)] || check.step <= stepping_.count) {
      const Contact& c = contacts_.list[i];
      moved |= check_pair_motion(c, contacts_.place[i], pose_now(c.pair.a), pose_now(c.pair.b), check);
    }
    checks_.next = std::min(checks_.next, check.step);
  }
  if (part_.ranks) {
    double of_all[] = {moved ? 1.0 : 0.0, double(-checks_.next)};
    part_.ranks->largest(of_all);
    moved = of_all[0] > 0.0, checks_.next = long(-of_all[1]);
  }
  if (moved && small_) {
    small_ = false;  // for good: what has moved once will move again
    for (size_t i = 0; i < blocks_.size(); ++i) {
      if (blocks_[i].body < 0) continue;
      checks_.next = stepping_.count + 1;  // its way is another one
      if (part_.laid_out[i]) checks_.block[i] = checks_.next;
    }
  }
  return moved;
}

bool World::is_ripe(const Contact& c, const PairPlace& place, const PairCheck& check) const {
  const bool seen = blocks_[size_t(c.pair.a)].body >= 0 && blocks_[size_t(c.pair.b)].body >= 0;
  return seen ? check.ripe : pair_motion(c, place, pose(c.pair.a), pose(c.pair.b)) > kRipe * allowed_motion(c, place);
}

void World::see(int i) {
  const ModelBlock& b = blocks_[size_t(i)];
  const Body& body = bodies_[size_t(b.body)];
  SeenMotion& seen = checks_.seen[size_t(b.body)];
  const double way_a_step = detection_fraction() * detection_.size / stepping_.dt;
  double unnoticed = seen.unnoticed;
  const long since = stepping_.count - seen.step;
  if (step_sums_.of_block[size_t(i)].deviates && since < kSoon) unnoticed *= 2.0;
  if (since > kLate) unnoticed *= 0.5;
  unnoticed = std::clamp(unnoticed, way_a_step / kCalmSteps, way_a_step / kBusySteps);
  seen = {body.v, b.radius, body.omega, unnoticed, stepping_.count};
}

// A step before which nothing this fast can have gone all of the way. Distant ones are rounded down, so that many looks
// fall into one step.
long World::step_after(double way, double speed, double acceleration) const {
  // speed t + acceleration t^2/2 = way
  const double steps = 2 * way / ((speed + std::sqrt(speed * speed + 2 * acceleration * way)) * stepping_.dt);
  if (!(steps >= 2.0)) return stepping_.count + 1;
  const long last = stepping_.count + long(std::min(steps, double(kMostSteps)));
  const long round = long(std::bit_floor(std::uint64_t(last - stepping_.count) / 4 + 1));
  return std::max(stepping_.count + 1, last - last % round);
}

// Long before anything can have moved by the tolerance, even if it speeds up at 10 g meanwhile.
long World::steps_of_gridpoints() const {
  double fastest = 0.0;
  for (int i = 0; i < block_count(); ++i) {
    if (!owns(i)) continue;
    const ModelBlock& b = blocks_[size_t(i)];
    if (b.body >= 0) {
      const Body& body = bodies_[size_t(b.body)];
      fastest = std::max({fastest, dot(body.v, body.v), dot(body.omega, body.omega) * b.radius * b.radius});
    } else {
      const Vector& v = nodes_.v[size_t(b.first_node)];
      fastest = std::max(fastest, dot(v, v));
    }
  }
  fastest = largest(fastest);
  const double speed = 2 * std::sqrt(fastest) + 100.0 * 100 * stepping_.dt;
  return std::clamp(long(0.25 * detection_fraction() * detection_.size / (speed * stepping_.dt)), 1l, 100l);
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
    const Pose& start = poses_.start[size_t(i)];
    moved = norm(x - start.x), turned = angle_between(r, start.r);
  } else {
    moved = motion_since_broad_phase(i);
  }
  const double way = kOfSkin * detection_.skin;
  if (b.body < 0) {
    step = stepping_.count + checks_.calm_steps;
  } else {
    const SeenMotion& seen = checks_.seen[size_t(b.body)];
    const double spin = norm(seen.omega) + seen.unnoticed / b.radius;
    step = step_after(way - moved, norm(seen.v) + seen.unnoticed + norm(seen.omega) * b.radius);
    if (small_) step = std::min(step, step_after(kSmallRotation - turned, spin));
  }
  return moved > way || turned > kSmallRotation;
}

bool World::check_pair_motion(const Contact& c, const PairPlace& place, const Pose& at_a, const Pose& at_b,
                              PairCheck& check) const {
  const double moved = pair_motion(c, place, at_a, at_b), way = allowed_motion(c, place);
  check = {c.pair.a, c.pair.b, moved > kRipe * way, stepping_.count + checks_.calm_steps};
  const ModelBlock &a = blocks_[size_t(c.pair.a)], &b = blocks_[size_t(c.pair.b)];
  if (a.body >= 0 && b.body >= 0 && checks_.dt > 0.0) {
    // As pair_motion: of b as seen from a.
    const SeenMotion &of_a = checks_.seen[size_t(a.body)], &of_b = checks_.seen[size_t(b.body)];
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
