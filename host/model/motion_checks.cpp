// Whether blocks have moved enough for contact detection. A pair has an allowed motion since its last narrow
// phase, and a block since the last broad phase. The speed gives the earliest step at which that motion can be reached;
// there is no check before it. The check assumes that a rigid block keeps its motion (AssumedMotion), up to a small
// tolerated deviation of speed. A block that exceeds the tolerance deviates (rigid_kernels.cpp); it and its pairs are
// checked in that very step. So no rigid block exceeds its allowed motion unchecked, whatever hits it, and a step
// checks only what is due.
//
// Deformable blocks have no such guarantee. Their checks assume that none accelerates by more than 10 g.
#include "model/motion_checks.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "model/block_layout.h"
#include "model/fixed_frames.h"
#include "model/world.h"
#include "model/world_parts.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Lever of a rotation of b in the frame of a, m. It is the larger of both radii, of which a's is at most the distance
// of b.
double lever_of(const World& w, const Contact& c, double distance) {
  return std::max(w.blocks[c.pair.b].radius, std::min(w.blocks[c.pair.a].radius, distance));
}

}  // namespace

double pair_motion(const World& w, const Contact& c, const PairPlace& place, const Pose& a, const Pose& b) {
  const Vector shift = transposed_times(a.r, b.x - a.x) - place.relative_x;
  const double angle = angle_between(transposed(a.r) * b.r, place.relative_r);
  return norm(shift) + angle * lever_of(w, c, norm(b.x - a.x));
}

double motion_since_broad_phase(const World& w, int block, const Pose& now) {
  const Pose& broad = w.poses.broad[size_t(block)];
  return norm(now.x - broad.x) + angle_between(now.r, broad.r) * w.blocks[size_t(block)].radius;
}

double detection_fraction(const World& w) {
  return w.assembly.contact.small_displacement > 0 ? w.assembly.contact.small_displacement : 0.005;
}

double allowed_motion(const World& w, const Contact& c, const PairPlace& place) {
  const double extent = std::min(w.blocks[c.pair.a].least_extent, w.blocks[c.pair.b].least_extent);
  const double fraction = detection_fraction(w);
  const double distance = place.separation.distance;
  if (c.count == 0 || distance > w.detection.skin) return std::max(fraction * extent, 0.5 * distance);
  return (c.initial ? std::max(fraction, w.assembly.contact.joint_motion) : fraction) * extent;
}

namespace {

// Number of steps in which the tolerated deviation of speed uses up the allowed motion of the smallest blocks. The
// first number is for the first check, the second for blocks that deviate all the time.
constexpr double kCalmSteps = 1000.0, kBusySteps = 50.0;
// Steps since the last check. Blocks that deviate before kSoon get twice the tolerance, blocks that do not until kLate
// get half of it.
constexpr long kSoon = 30, kLate = 300;
constexpr long kMostSteps = 1000;  // largest interval between two checks of a block or pair, in steps
constexpr long kClose = 3;         // steps to kMostlyUsed of the allowed motion at which a pair of rigid blocks has it
// Acceleration that checks of deformable blocks assume; share of the allowed motion that each block of a pair may use
// up between checks. A larger acceleration or a smaller share means more checks.
constexpr double kAcceleration = 100.0;  // m/s2, 10 g
constexpr double kOfWay = 0.25;
// Blocks turned by more than this (rad) end the small-displacement mode: frozen normals would be wrong by as much.
constexpr double kSmallRotation = 1e-3;

void assume_motion(World& w, int i) {
  const ModelBlock& b = w.blocks[size_t(i)];
  const Body& body = w.bodies[size_t(b.body)];
  AssumedMotion& assumed = w.checks.assumed[size_t(b.body)];
  const double way_a_step = detection_fraction(w) * w.detection.size / w.stepping.dt;
  double tolerated = assumed.tolerated;
  const long since = w.stepping.count - assumed.step;
  if (w.step_sums.of_block[size_t(i)].deviates && since < kSoon) tolerated *= 2.0;
  if (since > kLate) tolerated *= 0.5;
  tolerated = std::clamp(tolerated, way_a_step / kCalmSteps, way_a_step / kBusySteps);
  assumed = {body.v, b.radius, body.omega, tolerated, w.stepping.count};
}

// Earliest step at which a motion of this speed, m/s, and acceleration, m/s2, reaches `way`, m. Distant steps are
// rounded down, so that many checks share a step.
long step_after(const World& w, double way, double speed, double acceleration = 0.0) {
  // speed t + acceleration t^2/2 = way
  const double steps = 2 * way / ((speed + std::sqrt(speed * speed + 2 * acceleration * way)) * w.stepping.dt);
  if (!(steps >= 2.0)) return w.stepping.count + 1;
  const long last = w.stepping.count + long(std::min(steps, double(kMostSteps)));
  const long round = long(std::bit_floor(std::uint64_t(last - w.stepping.count) / 4 + 1));
  return std::max(w.stepping.count + 1, last - last % round);
}

// Step well before a deformable block of this speed, m/s, can have moved by `left`, m, or by the tolerance where that
// is more. A block at rest is checked as if only the tolerance was left, as something may hit it.
long step_of_gridpoints(const World& w, double left, double speed) {
  const double tolerance = detection_fraction(w) * w.detection.size;
  return std::min(step_after(w, kOfWay * tolerance, 0.0, kAcceleration),
                  step_after(w, kOfWay * std::max(left, tolerance), speed, kAcceleration));
}

// Checks a block's motion since the last broad phase; sets the step of its next check. In small displacements the
// motion since the start is limited. So no block comes near others that are not its neighbours, and constant frames
// still have the right direction.
bool check_block_motion(const World& w, int i, const CheckedMotion& now, long& step) {
  const ModelBlock& b = w.blocks[size_t(i)];
  const Pose& start = w.poses.start[size_t(i)];
  const bool is_fixed = w.frames.fixed[size_t(i)] != 0;
  const double moved = w.is_small ? norm(now.pose.x - start.x) : motion_since_broad_phase(w, i, now.pose);
  const double turned = w.is_small || is_fixed ? angle_between(now.pose.r, start.r) : 0.0;
  const double way = kOfSkin * w.detection.skin;
  if (b.body < 0) {
    const double rest = is_fixed ? (largest_fixed_rotation(w) - turned) * b.radius : way - moved;
    step = step_of_gridpoints(w, std::min(way - moved, rest), now.speed);
  } else {
    const AssumedMotion& assumed = w.checks.assumed[size_t(b.body)];
    const double spin = norm(assumed.omega) + assumed.tolerated / b.radius;
    step = step_after(w, way - moved, norm(assumed.v) + assumed.tolerated + norm(assumed.omega) * b.radius);
    if (w.is_small) step = std::min(step, step_after(w, kSmallRotation - turned, spin));
  }
  return moved > way || (w.is_small && turned > kSmallRotation);
}

// Result of checks: whether a motion was past its bound, and the step of the next check.
struct NextCheck {
  bool moved = false;
  long step;
  NextCheck& operator+=(const NextCheck& other) {
    moved |= other.moved, step = std::min(step, other.step);
    return *this;
  }
};

// Own blocks and pairs whose check is due, and the motion of their blocks. Each block is in several pairs, and its
// motion costs more than the rest of a check, so it is computed once.
struct DueChecks {
  std::vector<int32_t> blocks;
  std::vector<uint32_t> pairs;
  std::vector<int32_t> moving;     // blocks of either list
  std::vector<uint8_t> is_moving;  // by block
  LaneVector<CheckedMotion> motion;
  long next_of_others;  // earliest step of the checks that are not due

  void list(const World& w) {
    blocks.clear(), pairs.clear(), moving.clear();
    is_moving.assign(w.blocks.size(), 0), motion.resize(w.blocks.size());
    next_of_others = w.stepping.count + kMostSteps;
    const auto is_due = [&](bool of_block, long step) {
      const bool due = of_block || step <= w.stepping.count;
      if (!due) next_of_others = std::min(next_of_others, step);
      return due;
    };
    const auto move = [&](int32_t block) {
      if (!std::exchange(is_moving[size_t(block)], 1)) moving.push_back(block);
    };
    for (int32_t i = 0; i < w.block_count(); ++i) {
      if (w.part.owns(i) && is_due(w.checks.due[size_t(i)], w.checks.block[size_t(i)])) blocks.push_back(i), move(i);
    }
    for (uint32_t i = 0; i < w.checks.pair.size(); ++i) {
      const PairCheck& check = w.checks.pair[i];
      if (!w.part.owns(w.contacts.list[i].pair)) continue;
      if (is_due(w.checks.due[size_t(check.a)] || w.checks.due[size_t(check.b)], check.step))
        pairs.push_back(i), move(check.a), move(check.b);
    }
  }
};

constexpr size_t kChecksAPart = 128;  // of the work of one thread at a time

// Sums check(i) of each i in the list.
template <class Index, class Check>
NextCheck check_all(const World& w, std::span<const Index> list, const Check& check) {
  const NextCheck none{false, w.stepping.count + kMostSteps};
  std::vector<NextCheck> of_part(list.size() / kChecksAPart + 1, none);
  each_part(w.pool, list.size(), kChecksAPart, [&](size_t begin, size_t end) {
    for (const Index i : list.subspan(begin, end - begin)) of_part[begin / kChecksAPart] += check(size_t(i));
  });
  return std::accumulate(of_part.begin(), of_part.end(), none,
                         [](NextCheck sum, const NextCheck& x) { return sum += x; });
}

NextCheck check_due(World& w) {
  thread_local DueChecks kept;
  DueChecks& due = kept;  // as other threads have lists of their own
  due.list(w);
  each_part(w.pool, due.moving.size(), kChecksAPart, [&](size_t begin, size_t end) {
    for (const int32_t i : std::span(due.moving).subspan(begin, end - begin))
      due.motion[size_t(i)] = checked_motion(w, i);
  });
  NextCheck found{false, due.next_of_others};
  found += check_all(w, std::span<const int32_t>(due.blocks), [&](size_t i) {
    long& step = w.checks.block[i];
    const bool moved = check_block_motion(w, int(i), due.motion[i], step);
    return NextCheck{moved, step};
  });
  found += check_all(w, std::span<const uint32_t>(due.pairs), [&](size_t i) {
    const Contact& c = w.contacts.list[i];
    PairCheck& check = w.checks.pair[i];
    const bool moved =
        check_pair_motion(w, c, w.contacts.place[i], due.motion[size_t(c.pair.a)], due.motion[size_t(c.pair.b)], check);
    return NextCheck{moved, check.step};
  });
  return found;
}

}  // namespace

bool moved_enough(World& w) {
  const bool all = w.stepping.dt != w.checks.dt;
  if (w.stepping.count < w.checks.next && !w.checks.any_deviates && !all) return false;
  if (all) w.checks.dt = w.stepping.dt;
  receive_neighbours(w);
  w.checks.due.assign(w.blocks.size(), all);
  w.checks.assumed.resize(w.bodies.size());
  for (size_t i = 0; i < w.blocks.size(); ++i) {
    if (!w.part.laid_out[i] || w.blocks[i].body < 0 || !(all || w.step_sums.of_block[i].deviates)) continue;
    assume_motion(w, int(i));
    w.checks.due[i] = 1, w.step_sums.of_block[i].deviates = false;
  }
  w.checks.any_deviates = false;

  w.checks.block.resize(w.blocks.size(), 0);
  const NextCheck found = check_due(w);
  bool moved = found.moved;
  w.checks.next = found.step;
  if (w.part.ranks) {
    double of_all[] = {moved ? 1.0 : 0.0, double(-w.checks.next)};
    w.part.ranks->largest(of_all);
    moved = of_all[0] > 0.0, w.checks.next = long(-of_all[1]);
  }
  if (moved && w.is_small) {
    w.is_small = false;  // permanent, as blocks that have moved will move again
    find_block_frames(w);
    for (size_t i = 0; i < w.blocks.size(); ++i) {
      if (w.blocks[i].body < 0) continue;
      w.checks.next = w.stepping.count + 1;  // the allowed motion has changed
      if (w.part.laid_out[i]) w.checks.block[i] = w.checks.next;
    }
  }
  return moved;
}

CheckedMotion checked_motion(const World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  double squared = 0.0;
  if (b.body < 0) {  // its corners are its first gridpoints
    for (int n = 0; n < int(b.shape->vertices.size()); ++n) {
      const Vector v = gridpoint_velocity(w, block, n);
      squared = std::max(squared, dot(v, v));
    }
  } else {
    const Body& body = w.bodies[size_t(b.body)];
    squared = std::max(dot(body.v, body.v), dot(body.omega, body.omega) * b.radius * b.radius);
  }
  return {pose(w, block), 2 * std::sqrt(squared)};
}

bool check_pair_motion(const World& w, const Contact& c, const PairPlace& place, const CheckedMotion& now_a,
                       const CheckedMotion& now_b, PairCheck& check) {
  const double moved = pair_motion(w, c, place, now_a.pose, now_b.pose), way = allowed_motion(w, c, place);
  // Halves of a unit are checked by the tolerance, as part_units needs it.
  const double left = w.units.other_half[size_t(c.pair.a)] == c.pair.b ? 0.0 : way - moved;
  check = {c.pair.a, c.pair.b, moved > kMostlyUsed * way,
           step_of_gridpoints(w, left, std::max(now_a.speed, now_b.speed))};
  const ModelBlock &a = w.blocks[size_t(c.pair.a)], &b = w.blocks[size_t(c.pair.b)];
  if (a.body >= 0 && b.body >= 0 && w.checks.dt > 0.0) {
    // As in pair_motion: motion of b in the frame of a.
    const AssumedMotion &of_a = w.checks.assumed[size_t(a.body)], &of_b = w.checks.assumed[size_t(b.body)];
    const Vector apart = w.bodies[size_t(b.body)].x - w.bodies[size_t(a.body)].x;
    const double distance = norm(apart), lever = lever_of(w, c, distance);
    const double assumed = norm(of_b.v - of_a.v - cross(of_a.omega, apart)) + lever * norm(of_b.omega - of_a.omega);
    const double tolerated = of_a.tolerated * std::max(1.0, (distance + lever) / a.radius) +
                             of_b.tolerated * std::max(1.0, lever / b.radius);
    // a turns, while b moves straight on: |R(omega t) - 1 - omega t x| <= (omega t)^2/2.
    const double spin = norm(of_a.omega) + of_a.tolerated / a.radius;
    const auto step_of = [&](double share) {
      return step_after(w, share * way - moved, assumed + tolerated, spin * spin * distance);
    };
    check.step = step_of(check.mostly_used ? 1.0 : kMostlyUsed);
    if (check.mostly_used || check.step - w.stepping.count > kClose) return moved > way;
    // So near to kMostlyUsed that checks would follow each other step by step.
    check.mostly_used = true, check.step = step_of(1.0);
  }
  return moved > way;
}

}  // namespace quoin::blocks
