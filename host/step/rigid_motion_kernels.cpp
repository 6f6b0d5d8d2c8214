#include "step/rigid_motion_kernels.h"

#include <algorithm>

#include "step/deformable_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/rigid_motion_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

using M = hn::Mask<D>;

HWY_INLINE Lanes3 load3(const ByLane (&from)[3], int lane) {
  return {hn::Load(D(), from[0].of + lane), hn::Load(D(), from[1].of + lane), hn::Load(D(), from[2].of + lane)};
}
HWY_INLINE void store3(const Lanes3& a, ByLane (&to)[3], int lane) {
  for (int k = 0; k < 3; ++k) hn::Store(a[k], D(), to[k].of + lane);
}

// ---- Sums over gridpoints ------------------------------------------------------------------------------------------

struct Sums {
  InertiaLanes inertia;
  ByLane momentum[2][3], force[2][3];  // linear and about the centre
};

// Sums of mass, momentum and moments in one pass about the first gridpoint, then shifted to the mass centre.
HWY_INLINE void add_up(const LaneColumns& c, int first, Sums* sums) {
  const D d;
  const Lanes3 origin = load_line(c.x + first);
  V mass = hn::Zero(d);
  Lanes3 weighted = zeros(), momentum = zeros(), spin = zeros(), force = zeros(), moment = zeros();
  M held[3] = {hn::FirstN(d, 0), hn::FirstN(d, 0), hn::FirstN(d, 0)};
  Lanes3 square[2] = {zeros(), zeros()};  // xx, yy, zz and xy, yz, zx
  for (int n = 0; n < c.node_count; ++n) {
    const int at = n * kLine + first;
    const Lanes3 r = difference_of(load_line(c.x + at), origin), f = load_line(c.force + at);
    const V m = hn::Load(d, c.mass + n * kLanes + first);
    const Lanes3 m_r = scaled(m, r), m_v = scaled(m, load_line(c.v + at));
    mass = hn::Add(mass, m);
    weighted = sum_of(weighted, m_r);
    momentum = sum_of(momentum, m_v);
    spin = sum_of(spin, cross_of(r, m_v));
    force = sum_of(force, f);
    moment = sum_of(moment, cross_of(r, f));
    square[0] = {hn::MulAdd(m_r.x, r.x, square[0].x), hn::MulAdd(m_r.y, r.y, square[0].y),
                 hn::MulAdd(m_r.z, r.z, square[0].z)};
    square[1] = {hn::MulAdd(m_r.x, r.y, square[1].x), hn::MulAdd(m_r.y, r.z, square[1].y),
                 hn::MulAdd(m_r.z, r.x, square[1].z)};
    if (!c.held_v) continue;
    const Lanes3 v = load_line(c.held_v + at);
    for (int k = 0; k < 3; ++k) held[k] = hn::Or(held[k], hn::Eq(v[k], v[k]));  // not NaN
  }
  const V is_some = hn::IfThenElse(hn::Eq(mass, hn::Zero(d)), hn::Set(d, 1.0), mass);
  const Lanes3 r = scaled(hn::Div(hn::Set(d, 1.0), is_some), weighted), m_r = scaled(mass, r);
  store3(sum_of(origin, r), sums->inertia.centre, first);
  hn::Store(mass, d, sums->inertia.mass.of + first);
  store3(momentum, sums->momentum[0], first);
  store3(difference_of(spin, cross_of(r, momentum)), sums->momentum[1], first);
  store3(force, sums->force[0], first);
  store3(difference_of(moment, cross_of(r, force)), sums->force[1], first);
  const V one = hn::Set(d, 1.0);
  store3({hn::IfThenElseZero(held[0], one), hn::IfThenElseZero(held[1], one), hn::IfThenElseZero(held[2], one)},
         sums->inertia.held, first);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const V about_origin = i == j ? square[0][i] : square[1][i + j == 1 ? 0 : (i + j == 3 ? 1 : 2)];
      hn::Store(hn::NegMulAdd(m_r[i], r[j], about_origin), d, sums->inertia.second[i][j].of + first);
    }
  }
}

// Sums of momentum, force and their moments of blocks in fixed frames, with constant arms.
HWY_INLINE void add_up_with_fixed_arms(const LaneColumns& c, int first, Sums* sums) {
  const D d;
  Lanes3 momentum = zeros(), spin = zeros(), force = zeros(), moment = zeros();
  for (int n = 0; n < c.node_count; ++n) {
    const int at = n * kLine + first;
    const Lanes3 r = load_line(c.arm + at), f = load_line(c.force + at);
    const Lanes3 m_v = scaled(hn::Load(d, c.mass + n * kLanes + first), load_line(c.v + at));
    momentum = sum_of(momentum, m_v), spin = sum_of(spin, cross_of(r, m_v));
    force = sum_of(force, f), moment = sum_of(moment, cross_of(r, f));
  }
  store3(momentum, sums->momentum[0], first), store3(spin, sums->momentum[1], first);
  store3(force, sums->force[0], first), store3(moment, sums->force[1], first);
}

// ---- Inertia -------------------------------------------------------------------------------------------------------

// Rigid of model/block_inertia.h, by lane.
struct Motion {
  Lanes3 linear, angular;
};
HWY_INLINE Motion sum_of(const Motion& a, const Motion& b) {
  return {sum_of(a.linear, b.linear), sum_of(a.angular, b.angular)};
}
HWY_INLINE Motion difference_of(const Motion& a, const Motion& b) {
  return {difference_of(a.linear, b.linear), difference_of(a.angular, b.angular)};
}
HWY_INLINE Motion scaled(V f, const Motion& a) { return {scaled(f, a.linear), scaled(f, a.angular)}; }
HWY_INLINE Motion load_motion(const ByLane (&from)[2][3], int lane) {
  return {load3(from[0], lane), load3(from[1], lane)};
}
HWY_INLINE void store_motion(const Motion& a, ByLane (&to)[2][3], int lane) {
  store3(a.linear, to[0], lane), store3(a.angular, to[1], lane);
}

// RigidInertia of model/block_inertia.h, by lane.
struct Inertia {
  Lanes3 centre;
  V mass;
  Lanes33 tensor, inverse;
  bool some_held;  // false: no component is held
  M held[3];
};

HWY_INLINE void invert(Inertia& a) {
  const D d;
  const V one = hn::Set(d, 1.0);
  const Lanes33 cofactor = cofactors_of(a.tensor);  // symmetric, as the tensor is
  const V over = hn::Div(one, dot_of(a.tensor.row[0], cofactor.row[0]));
  for (int k = 0; k < 3; ++k) a.inverse.row[k] = scaled(over, cofactor.row[k]);
  if (!a.some_held) return;
  const M any = hn::Or(a.held[0], hn::Or(a.held[1], a.held[2]));
  for (int k = 0; k < 3; ++k) {
    const M is_fixed = hn::Or(a.held[(k + 1) % 3], a.held[(k + 2) % 3]);
    const V alone = hn::IfThenZeroElse(is_fixed, hn::Div(one, a.tensor.row[k][k]));
    for (int j = 0; j < 3; ++j)
      a.inverse.row[k][j] = hn::IfThenElse(any, j == k ? alone : hn::Zero(d), a.inverse.row[k][j]);
  }
}

// Adds mass (|arm|^2 1 - arm arm^T).
HWY_INLINE void add_at_arm(V mass, const Lanes3& arm, Lanes33& tensor) {
  const V square = dot_of(arm, arm);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const V off = hn::Mul(arm[i], arm[j]);
      tensor.row[i][j] = hn::MulAdd(mass, i == j ? hn::Sub(square, off) : hn::Neg(off), tensor.row[i][j]);
    }
  }
}

HWY_INLINE Inertia inertia_of(const InertiaLanes& sums, int lane, bool some_held) {
  const D d;
  Inertia a;
  a.centre = load3(sums.centre, lane);
  a.mass = hn::Load(d, sums.mass.of + lane);
  Lanes33 second;
  for (int k = 0; k < 3; ++k) second.row[k] = load3(sums.second[k], lane);
  const V trace = hn::Add(second.row[0].x, hn::Add(second.row[1].y, second.row[2].z));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      a.tensor.row[i][j] = i == j ? hn::Sub(trace, second.row[i][j]) : hn::Neg(second.row[i][j]);
  }
  a.some_held = some_held;
  for (int k = 0; k < 3; ++k) a.held[k] = hn::Ne(hn::Load(d, sums.held[k].of + lane), hn::Zero(d));
  invert(a);
  return a;
}

HWY_INLINE Inertia together(const Inertia& a, const Inertia& b) {
  Inertia both;
  both.mass = hn::Add(a.mass, b.mass);
  both.centre = plus_scaled(a.centre, hn::Div(b.mass, both.mass), difference_of(b.centre, a.centre));
  both.some_held = a.some_held;
  for (int k = 0; k < 3; ++k) {
    both.tensor.row[k] = sum_of(a.tensor.row[k], b.tensor.row[k]);
    both.held[k] = hn::Or(a.held[k], b.held[k]);
  }
  for (const Inertia* part : {&a, &b}) add_at_arm(part->mass, difference_of(part->centre, both.centre), both.tensor);
  invert(both);
  return both;
}

HWY_INLINE Motion acceleration(const Inertia& a, const Motion& force) {
  Motion motion{scaled(hn::Div(hn::Set(D(), 1.0), a.mass), force.linear), times(a.inverse, force.angular)};
  for (int k = 0; a.some_held && k < 3; ++k) motion.linear[k] = hn::IfThenZeroElse(a.held[k], motion.linear[k]);
  return motion;
}
HWY_INLINE Motion force_of(const Inertia& a, const Motion& motion) {
  return {scaled(a.mass, motion.linear), times(a.tensor, motion.angular)};
}
HWY_INLINE Lanes3 gyration(const Inertia& a, const Lanes3& spin) {
  return times(a.inverse, cross_of(spin, times(a.tensor, spin)));
}

// UnitInertia of kCount blocks, by lane.
template <int kCount>
struct Unit {
  Inertia block[kCount], whole;  // whole: for two blocks alone
};
template <int kCount>
HWY_INLINE Motion motion_of(const Unit<kCount>& unit, const Motion (&force)[kCount]) {
  Motion sum{zeros(), zeros()};
  for (int b = 0; b < kCount; ++b) {
    const Lanes3 arm = difference_of(unit.block[b].centre, unit.whole.centre);
    sum = sum_of(sum, Motion{force[b].linear, sum_of(force[b].angular, cross_of(arm, force[b].linear))});
  }
  return acceleration(unit.whole, sum);
}
template <int kCount>
HWY_INLINE Motion at_block(const Unit<kCount>& unit, int b, const Motion& whole) {
  const Lanes3 arm = difference_of(unit.block[b].centre, unit.whole.centre);
  return {sum_of(whole.linear, cross_of(whole.angular, arm)), whole.angular};
}

// ---- A step --------------------------------------------------------------------------------------------------------

// c^2 with c = 2 sin(theta/2) / sin(theta), sin(theta) = |w| dt.
HWY_INLINE V chord_factor(const Lanes3& spin, double dt) {
  const D d;
  const V one = hn::Set(d, 1.0), two = hn::Set(d, 2.0);
  const V left = hn::Max(hn::Zero(d), hn::NegMulAdd(dot_of(spin, spin), hn::Set(d, dt * dt), one));
  return hn::Div(two, hn::Add(one, hn::Sqrt(left)));
}

HWY_INLINE Motion damped(double gamma, const Motion& force, const Motion& velocity) {
  const auto against = [&](const Lanes3& f, const Lanes3& v) HWY_ATTR {
    Lanes3 damping;
    for (int k = 0; k < 3; ++k) damping[k] = local_damping(hn::Set(D(), gamma), f[k], v[k]);
    return damping;
  };
  return {against(force.linear, velocity.linear), against(force.angular, velocity.angular)};
}

HWY_INLINE Motion relative_to(const geometry::Vector& ground, const Motion& velocity) {
  Motion relative = velocity;
  for (int k = 0; k < 3; ++k) relative.linear[k] = hn::Sub(velocity.linear[k], hn::Set(D(), ground[k]));
  return relative;
}

// turning += weight (1 - P) w x (w x r) as a matrix on r.
HWY_INLINE void add_turning(const Inertia& block, const Lanes3& spin, double dt, double weight, Lanes33& turning) {
  const V f = hn::Mul(hn::Set(D(), weight), chord_factor(spin, dt));
  const Lanes3 g = gyration(block, spin);
  const V square = dot_of(spin, spin);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      V x = hn::Mul(spin[i], spin[j]);
      if (i == j) x = hn::Sub(x, square);
      if (i != j) x = (j - i + 3) % 3 == 1 ? hn::Add(x, g[3 - i - j]) : hn::Sub(x, g[3 - i - j]);
      turning.row[i][j] = hn::MulAdd(f, x, turning.row[i][j]);
    }
  }
}

template <int kCount>
HWY_INLINE void step_of(const Sums* sums, const LaneColumns& columns, int lane, const RigidMotionStep& s,
                        RigidGains* gains, RigidLanes* lanes) {
  const D d;
  const double dt = s.time_step, s_b = s.factors.deformation, s_u = kCount == 1 ? 1.0 : s.factors.unit;
  const V time_step = hn::Set(d, dt);
  const bool turns = !columns.arm;  // whether frames follow their blocks
  Unit<kCount> unit;
  Motion momentum[kCount], force[kCount], velocity[kCount], driven[kCount], damping[kCount], change[kCount];
  for (int b = 0; b < kCount; ++b) {
    unit.block[b] = inertia_of(sums[b].inertia, lane, columns.held_v != nullptr);
    momentum[b] = load_motion(sums[b].momentum, lane), force[b] = load_motion(sums[b].force, lane);
    velocity[b] = acceleration(unit.block[b], momentum[b]);
    driven[b] = acceleration(unit.block[b], force[b]);  // without damping
  }
  Lanes3 unit_spin[2];  // before and after the step
  if constexpr (kCount == 1) {
    damping[0] = damped(s.gamma, force[0], relative_to(s.ground, velocity[0]));
    change[0] = scaled(time_step, difference_of(driven[0], acceleration(unit.block[0], damping[0])));
  } else {
    unit.whole = together(unit.block[0], unit.block[1]);
    const Motion of_unit = motion_of(unit, momentum), whole = motion_of(unit, force);
    const Motion whole_damping =
        acceleration(unit.whole, damped(s.gamma, force_of(unit.whole, whole), relative_to(s.ground, of_unit)));
    unit_spin[0] = of_unit.angular;
    unit_spin[1] = plus_scaled(of_unit.angular, time_step, difference_of(whole.angular, whole_damping.angular));
    Motion beside_damping[2];
    for (int b = 0; b < 2; ++b) {
      const Motion beside = force_of(unit.block[b], difference_of(driven[b], at_block(unit, b, whole)));
      beside_damping[b] = damped(s.gamma, beside, difference_of(velocity[b], at_block(unit, b, of_unit)));
    }
    // Damping of the relative motion of halves must have no resultant on the unit.
    const Motion leak = motion_of(unit, beside_damping);
    for (int b = 0; b < 2; ++b) {
      const Inertia& block = unit.block[b];
      const Motion along = at_block(unit, b, whole), along_damping = at_block(unit, b, whole_damping);
      const Motion beside = difference_of(acceleration(block, beside_damping[b]), at_block(unit, b, leak));
      damping[b] = force_of(block, sum_of(along_damping, beside));
      const Motion slowed = difference_of(difference_of(driven[b], along), beside);
      change[b] = scaled(time_step, sum_of(difference_of(along, along_damping), scaled(hn::Set(d, 1.0 / s_u), slowed)));
      const Lanes3 arm = difference_of(block.centre, unit.whole.centre);
      for (int k = 0; turns && k < 2; ++k) {
        const Lanes3& spin = unit_spin[k];
        const V weight = hn::Mul(hn::Set(d, 0.5 * dt * (1.0 - 1.0 / s_u)), chord_factor(spin, dt));
        const Lanes3 of_whole = gyration(unit.whole, spin);
        const Lanes3 towards = difference_of(cross_of(spin, cross_of(spin, arm)), cross_of(of_whole, arm));
        change[b].linear = plus_scaled(change[b].linear, weight, towards);
        change[b].angular = plus_scaled(change[b].angular, weight, difference_of(gyration(block, spin), of_whole));
      }
    }
  }
  for (int b = 0; b < kCount; ++b) {
    const Inertia& block = unit.block[b];
    const Motion gain = difference_of(change[b], scaled(hn::Set(d, dt / s_b), driven[b]));
    const Lanes3 &g = gain.angular, &before = velocity[b].angular;
    const V zero = hn::Zero(d);
    Lanes33 turning = {{{zero, hn::Neg(g.z), g.y}, {g.z, zero, hn::Neg(g.x)}, {hn::Neg(g.y), g.x, zero}}};
    if (turns) {
      for (const Lanes3& spin : {before, sum_of(before, change[b].angular)})
        add_turning(block, spin, dt, 0.5 * dt * (1.0 - s_u / s_b), turning);
      for (int k = 0; kCount == 2 && k < 2; ++k)
        add_turning(block, unit_spin[k], dt, 0.5 * dt * (s_u - 1.0) / s_b, turning);
    }
    store3(block.centre, gains[b].centre, lane);
    store3(gain.linear, gains[b].linear, lane);
    for (int k = 0; k < 3; ++k) store3(turning.row[k], gains[b].turning[k], lane);
    if (!lanes) continue;
    store_motion(velocity[b], lanes[b].velocity, lane);
    store_motion(change[b], lanes[b].change, lane);
    store_motion(damping[b], lanes[b].damping, lane);
  }
}

void SplitMotion(std::span<const LaneColumns> groups, int count, const RigidMotionStep& step, RigidGains* gains,
                 RigidLanes* lanes) {
  Sums sums[2];
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].arm) sums[g].inertia = groups[g].at_start->inertia;
    for (int first = 0; first < count; first += kWidth)
      groups[g].arm ? add_up_with_fixed_arms(groups[g], first, &sums[g]) : add_up(groups[g], first, &sums[g]);
  }
  for (int first = 0; first < count; first += kWidth) {
    if (groups.size() == 2)
      step_of<2>(sums, groups.front(), first, step, gains, lanes);
    else
      step_of<1>(sums, groups.front(), first, step, gains, lanes);
  }
  for (std::size_t g = 0; lanes && g < groups.size(); ++g) lanes[g].inertia = sums[g].inertia;
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace quoin::blocks {

HWY_EXPORT(SplitMotion);

void split_motion(std::span<const LaneColumns> groups, int count, const RigidMotionStep& step, RigidGains* gains,
                  RigidLanes* lanes) {
  HWY_DYNAMIC_DISPATCH(SplitMotion)(groups, count, step, gains, lanes);
}

}  // namespace quoin::blocks

#endif  // HWY_ONCE
