#include "step/rigid_kernels.h"

#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/rigid_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

// ---- Contact points ------------------------------------------------------------------------------------------------

// Four points of a pair, or the four columns of a pose: pairs have few points, so longer vectors would be half empty.
constexpr int kFourParts = kFour / kPart;

struct Row {
  F part[kFourParts];
};

HWY_INLINE Row row_of(const double* from) {
  Row row;
  for (int p = 0; p < kFourParts; ++p) row.part[p] = hn::LoadU(Four(), from + p * kPart);
  return row;
}

HWY_INLINE Row with_last(Row row, double last) {
  F& end = row.part[kFourParts - 1];
  end = hn::IfThenElse(hn::FirstN(Four(), kPart - 1), end, hn::Set(Four(), last));
  return row;
}

HWY_INLINE void add(double factor, const Row& row, Row& to) {
  const F f = hn::Set(Four(), factor);
  for (int p = 0; p < kFourParts; ++p) to.part[p] = hn::MulAdd(f, row.part[p], to.part[p]);
}

HWY_INLINE Row zero_row() {
  Row row;
  for (F& part : row.part) part = hn::Zero(Four());
  return row;
}

HWY_INLINE void store(const Row& row, double* to) {
  for (int p = 0; p < kFourParts; ++p) hn::StoreU(row.part[p], Four(), to + p * kPart);
}

// Computes the axes of the plane in space, and of each axis col in b's body frame, then base.
HWY_INLINE void pose_of(RigidPair& pair, const Body* bodies, double (&pose)[3][kFour]) {
  const Body &a = bodies[pair.a], &b = bodies[pair.b];
  const Row columns_of_a[3] = {row_of(&a.transposed_r.row[0].x), row_of(&a.transposed_r.row[1].x),
                               row_of(&a.transposed_r.row[2].x)};
  const Row rows_of_b[3] = {with_last(row_of(&b.r.row[0].x), b.x.x - a.x.x),
                            with_last(row_of(&b.r.row[1].x), b.x.y - a.x.y),
                            with_last(row_of(&b.r.row[2].x), b.x.z - a.x.z)};
  for (int k = 0; k < 3; ++k) {
    Row axis = zero_row();
    for (int j = 0; j < 3; ++j) add((&pair.axis[k].x)[j], columns_of_a[j], axis);
    store(axis, pair.in_space[k]);
    Row row = zero_row();
    for (int j = 0; j < 3; ++j) add(pair.in_space[k][j], rows_of_b[j], row);
    store(row, pose[k]);
  }
}

void RigidJumps(std::span<RigidPair> pairs, const Body* bodies, const PointColumns& c) {
  const Four d;
  for (RigidPair& pair : pairs) {
    double pose[3][kFour];
    pose_of(pair, bodies, pose);
    for_each_vector(d, pair.first, pair.first + pair.count, [&](std::size_t, auto load, auto store) HWY_ATTR {
      const F x = load(c.arm[0]), y = load(c.arm[1]), z = load(c.arm[2]);
      const auto place = [&](const double(&row)[kFour]) HWY_ATTR {
        return hn::MulAdd(hn::Set(d, row[0]), x,
                          hn::MulAdd(hn::Set(d, row[1]), y, hn::MulAdd(hn::Set(d, row[2]), z, hn::Set(d, row[3]))));
      };
      store(hn::Sub(place(pose[0]), load(c.offset)), c.normal_jump);
      for (int k = 0; k < 2; ++k) {
        const F now = place(pose[k + 1]);
        store(hn::Sub(now, load(c.slid[k])), c.slip[k]);
        store(now, c.slid[k]);
      }
    });
  }
}

void RigidForces(std::span<RigidPair> pairs, const Body* bodies, const PointColumns& c) {
  const Four d;
  for (RigidPair& pair : pairs) {
    F force[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)}, moment[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for_each_vector(d, pair.first, pair.first + pair.count, [&](std::size_t, auto load, auto) HWY_ATTR {
      const F area = load(c.area);
      F f[3];
      for (int k = 0; k < 3; ++k) {
        F t = load(c.traction[k]);
        if (c.viscous[0]) t = hn::Add(t, load(c.viscous[k]));
        f[k] = hn::Mul(area, t);
        force[k] = hn::Add(force[k], f[k]);
      }
      const F n = hn::Add(load(c.normal_jump), load(c.offset)), s = load(c.slid[0]), t = load(c.slid[1]);
      moment[0] = hn::NegMulAdd(t, f[1], hn::MulAdd(s, f[2], moment[0]));
      moment[1] = hn::NegMulAdd(n, f[2], hn::MulAdd(t, f[0], moment[1]));
      moment[2] = hn::NegMulAdd(s, f[0], hn::MulAdd(n, f[1], moment[2]));
    });
    const Body &a = bodies[pair.a], &b = bodies[pair.b];
    const auto in_space = [&](const F(&of)[3]) HWY_ATTR {
      Row row = zero_row();
      for (int k = 0; k < 3; ++k) {
        const F sum = hn::SumOfLanes(d, of[k]);  // in every lane
        for (int p = 0; p < kFourParts; ++p)
          row.part[p] = hn::MulAdd(sum, hn::LoadU(d, pair.in_space[k] + p * kPart), row.part[p]);
      }
      alignas(32) double lane[kFour];
      store(row, lane);
      return Vector{lane[0], lane[1], lane[2]};
    };
    pair.force = in_space(force);
    pair.moment_a = in_space(moment);
    pair.moment_b = cross(b.x - a.x, pair.force) - pair.moment_a;
  }
}

// ---- Bodies --------------------------------------------------------------------------------------------------------

static_assert(kBodies == kLanes);
// The order of members that advance_vector loads and stores.
static_assert(offsetof(Body, torque) == 19 * sizeof(double) && offsetof(Body, inertia) == 24 * sizeof(double) &&
              offsetof(Body, transposed_r) == offsetof(Body, r) + 9 * sizeof(double));

constexpr double kRounding = 0x1p-56;  // relative; an eighth of the last bit, so that errors of steps do not accumulate

struct Lanes4 {
  V w;
  Lanes3 v;
};
HWY_INLINE Lanes4 product(const Lanes4& a, const Lanes4& b) {
  return {hn::NegMulAdd(a.v.x, b.v.x, hn::NegMulAdd(a.v.y, b.v.y, hn::NegMulAdd(a.v.z, b.v.z, hn::Mul(a.w, b.w)))),
          sum_of(sum_of(scaled(a.w, b.v), scaled(b.w, a.v)), cross_of(a.v, b.v))};
}
HWY_INLINE Lanes4 unit(const Lanes4& q) {
  const V one = hn::Set(D(), 1.0);
  const V f = hn::Div(one, hn::Sqrt(hn::MulAdd(q.w, q.w, dot_of(q.v, q.v))));
  return {hn::Mul(f, q.w), scaled(f, q.v)};
}
HWY_INLINE Lanes33 matrix_of(const Lanes4& q) {
  const V one = hn::Set(D(), 1.0);
  const V x = q.v.x, y = q.v.y, z = q.v.z, w = q.w;
  const auto diagonal = [&](V a, V b) HWY_ATTR { return hn::Sub(one, twice(hn::MulAdd(a, a, hn::Mul(b, b)))); };
  const auto less = [&](V a, V b, V c) HWY_ATTR { return twice(hn::NegMulAdd(w, c, hn::Mul(a, b))); };
  const auto more = [&](V a, V b, V c) HWY_ATTR { return twice(hn::MulAdd(w, c, hn::Mul(a, b))); };
  return {{{diagonal(y, z), less(x, y, z), more(x, z, y)},
           {more(x, y, z), diagonal(x, z), less(y, z, x)},
           {less(x, z, y), more(y, z, x), diagonal(x, y)}}};
}

// geometry::rotation by lane, with a series for small angles, as those of steps are.
HWY_INLINE Lanes4 rotation_of(const Lanes3& angle) {
  const D d;
  const V one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
  const V square = hn::Mul(hn::Set(d, 0.25), dot_of(angle, angle));  // square of half the angle
  const auto term = [&](double over, V next)
                        HWY_ATTR { return hn::NegMulAdd(hn::Mul(square, hn::Set(d, 1.0 / over)), next, one); };
  V cosine = term(2.0, term(12.0, term(30.0, one)));
  V half_sinc = hn::Mul(half, term(6.0, term(20.0, term(42.0, one))));
  const auto is_small = hn::Lt(square, hn::Set(d, 1e-4));
  if (HWY_UNLIKELY(!hn::AllTrue(d, is_small))) {
    alignas(64) double h2[kLanes], w[kLanes], f[kLanes];
    hn::Store(square, d, h2);
    for (int i = 0; i < kWidth; ++i) {
      const double h = std::sqrt(h2[i]);
      w[i] = std::cos(h), f[i] = 0.5 * std::sin(h) / h;
    }
    cosine = hn::IfThenElse(is_small, cosine, hn::Load(d, w));
    half_sinc = hn::IfThenElse(is_small, half_sinc, hn::Load(d, f));
  }
  return {cosine, scaled(half_sinc, angle)};
}

// The bodies of a vector. Four consecutive members of all of them are loaded or stored at a time.
struct Members {
  Body* lane[kLanes];  // lanes beyond `count` repeat the last body
  int count;           // number of lanes that are written

  HWY_INLINE void load(std::size_t offset, V (&member)[kFour]) const {
    load_rows([&](int l) { return at(l, offset); }, member);
  }
  HWY_INLINE void store(const V (&member)[kFour], std::size_t offset) const {
    for_rows(member, count,
             [&](int l, int column, F part) HWY_ATTR { hn::StoreU(part, Four(), at(l, offset) + column); });
  }
  HWY_INLINE V one(std::size_t offset) const {
    V member[kFour];
    load(offset, member);
    return member[0];
  }

 private:
  HWY_INLINE double* at(int l, std::size_t offset) const {
    return reinterpret_cast<double*>(reinterpret_cast<char*>(lane[l]) + offset);
  }
};

// Sums of a step, by lane.
struct SumLanes {
  alignas(64) double unbalanced[kLanes], net[3][kLanes], positions[kLanes];
  alignas(64) double kinetic[kLanes], damping[2][kLanes], external[2][kLanes], beyond[kLanes];
};

// Positive where some point of a body may deviate from its motion at the last check by more than the tolerance.
// (a + b)^2 is at most 2 (a^2 + b^2), which needs no roots.
HWY_INLINE V beyond_assumed(const AssumedMotion* const (&assumed)[kLanes], const Lanes3& v, const Lanes3& omega) {
  V linear[kFour], angular[kFour];
  load_rows([&](int l) { return &assumed[l]->v.x; }, linear);
  load_rows([&](int l) { return &assumed[l]->omega.x; }, angular);
  const Lanes3 dv = difference_of(v, {linear[0], linear[1], linear[2]});
  const Lanes3 dw = difference_of(omega, {angular[0], angular[1], angular[2]});
  const V radius = linear[3], tolerated = angular[3];
  const V squares = hn::MulAdd(hn::Mul(radius, radius), dot_of(dw, dw), dot_of(dv, dv));
  return hn::NegMulAdd(tolerated, tolerated, twice(squares));
}

// Held translations and rotations of the bodies of a vector.
struct HeldLanes {
  const double (&held)[6][kLanes];
  int first;
  HWY_INLINE hn::Mask<D> operator()(int k) const { return hn::Ne(hn::Load(D(), held[k] + first), hn::Zero(D())); }
  HWY_INLINE bool none() const {
    const auto is_free = [this](int k) HWY_ATTR { return hn::AllFalse(D(), (*this)(k)); };
    return is_free(0) && is_free(1) && is_free(2) && is_free(3) && is_free(4) && is_free(5);
  }
};

// Viscous damping: v' = -alpha v, with the mean of both velocities.
HWY_INLINE double half_alpha_dt(const BodyStep& step) { return 0.5 * step.alpha * step.time_step; }

// Work of forces in the half steps before and after their time.
struct WorkLanes {
  V before, after;
  HWY_INLINE void add(V force, V way_before, V way_after) {
    before = hn::MulAdd(force, way_before, before), after = hn::MulAdd(force, way_after, after);
  }
  HWY_INLINE void store(double (&to)[2][kLanes], int first) const {
    hn::Store(before, D(), to[0] + first), hn::Store(after, D(), to[1] + first);
  }
};
struct EnergyLanes {
  WorkLanes damping, external;
  V kinetic;
};

// Velocities of the next half step. Also stores the unbalanced forces.
HWY_INLINE Lanes3 accelerate(const HeldLanes& is_held, int first, const BodyStep& step, const Lanes3& v,
                             const Lanes3& held_v, const Lanes3& force, V weight_mass, V mass, SumLanes* sums,
                             EnergyLanes* energies) {
  const D d;
  const V zero = hn::Zero(d), half = hn::Set(d, 0.5), dt = hn::Set(d, step.time_step), gamma = hn::Set(d, step.gamma);
  const double a = half_alpha_dt(step);
  const V keep = hn::Set(d, 1.0 - a), over = hn::Set(d, 1.0 / (1.0 + a));
  const V dt_over_mass = hn::Div(dt, mass);
  Lanes3 next;
  V free = zero;
  for (int k = 0; k < 3; ++k) {
    const auto hold = is_held(k);
    const V ground = hn::Set(d, step.ground[k]);
    const V brake = hn::Neg(local_damping(gamma, force[k], hn::Sub(v[k], ground)));
    V driven = hn::MulAdd(dt_over_mass, hn::Add(force[k], brake), hn::Mul(keep, v[k]));
    if (a > 0.0 && step.ground[k] != 0.0) driven = hn::MulAdd(hn::Set(d, 2.0 * a), ground, driven);
    next[k] = hn::IfThenElse(hold, held_v[k], hn::Mul(over, driven));
    const V net = hn::IfThenZeroElse(hold, force[k]);
    hn::Store(net, d, sums->net[k] + first);
    free = hn::MulAdd(net, net, free);
    if (!step.energies) continue;
    const V way_before = hn::Mul(hn::Mul(half, dt), v[k]), way_after = hn::Mul(hn::Mul(half, dt), next[k]);
    const V mean = hn::Mul(half, hn::Add(v[k], next[k]));
    const V viscous = hn::Mul(hn::Set(d, step.alpha), hn::Mul(mass, hn::Sub(mean, ground)));
    energies->damping.add(hn::IfThenZeroElse(hold, hn::Sub(viscous, brake)), way_before, way_after);
    const V weight = hn::Mul(weight_mass, hn::Set(d, step.gravity[k]));
    energies->external.add(hn::IfThenElse(hold, hn::Sub(weight, force[k]), weight), way_before, way_after);
    energies->kinetic =
        hn::Add(energies->kinetic, hn::IfThenZeroElse(hold, hn::Mul(hn::Mul(half, mass), hn::Mul(v[k], next[k]))));
  }
  hn::Store(hn::Sqrt(free), d, sums->unbalanced + first);
  return next;
}

// Implicit midpoint for the orientation at constant angular momentum L: omega = R_mid I^-1 R_mid^T L. An iteration
// multiplies the error by dt |L| (1/I_least - 1/I_largest) at most, which gives the number of iterations to rounding.
HWY_INLINE Lanes3 spin_at_midpoint(const Lanes4& q, const Lanes33& r, const Lanes3& momentum, const Lanes3& inertia,
                                   hn::Mask<D> all_held, V dt) {
  const D d;
  const V one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
  const Lanes3 inverse = {hn::Div(one, inertia.x), hn::Div(one, inertia.y), hn::Div(one, inertia.z)};
  const auto spin_at = [&](const Lanes33& at) HWY_ATTR {
    const Lanes3 l = transposed_times_of(at, momentum);
    return times(at, {hn::Mul(l.x, inverse.x), hn::Mul(l.y, inverse.y), hn::Mul(l.z, inverse.z)});
  };
  const V spread =
      hn::Sub(hn::Max(inverse.x, hn::Max(inverse.y, inverse.z)), hn::Min(inverse.x, hn::Min(inverse.y, inverse.z)));
  const V nearer = hn::Mul(hn::Mul(dt, spread), hn::Sqrt(dot_of(momentum, momentum)));
  V error = hn::IfThenZeroElse(all_held, nearer);  // relative
  Lanes3 omega = spin_at(r);
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto settled = hn::Le(error, hn::Set(d, kRounding));
    if (hn::AllTrue(d, settled)) break;
    const Lanes3 better = spin_at(matrix_of(product(rotation_of(scaled(hn::Mul(half, dt), omega)), q)));
    for (int k = 0; k < 3; ++k) omega[k] = hn::IfThenElse(settled, omega[k], better[k]);
    error = hn::Mul(error, nearer);
  }
  return omega;
}

// Turns by the spin of a step; at zero spin the bits stay.
HWY_INLINE void turn(const Lanes3& omega, V dt, Lanes4* q, Lanes33* r) {
  const D d;
  const auto at_rest = hn::Eq(dot_of(omega, omega), hn::Zero(d));
  if (hn::AllTrue(d, at_rest)) return;
  const Lanes4 on = unit(product(rotation_of(scaled(dt, omega)), *q));
  const Lanes33 matrix = matrix_of(on);
  q->w = hn::IfThenElse(at_rest, q->w, on.w);
  for (int k = 0; k < 3; ++k) {
    q->v[k] = hn::IfThenElse(at_rest, q->v[k], on.v[k]);
    for (int j = 0; j < 3; ++j) r->row[k][j] = hn::IfThenElse(at_rest, r->row[k][j], matrix.row[k][j]);
  }
}

// Stores R by rows, then by columns. The last store overlaps the one before, as members of another kind follow.
HWY_INLINE void store_turned(const Members& of, const Lanes33& r) {
  const auto& m = r.row;
  const V turned_to[5][kFour] = {{m[0].x, m[0].y, m[0].z, m[1].x},
                                 {m[1].y, m[1].z, m[2].x, m[2].y},
                                 {m[2].z, m[0].x, m[1].x, m[2].x},
                                 {m[0].y, m[1].y, m[2].y, m[0].z},
                                 {m[2].y, m[0].z, m[1].z, m[2].z}};
  for (int i = 0; i < 4; ++i) of.store(turned_to[i], offsetof(Body, r) + i * kFour * sizeof(double));
  of.store(turned_to[4], offsetof(Body, r) + 14 * sizeof(double));
}

HWY_INLINE void advance_vector(const Members& of, const AssumedMotion* const (&assumed)[kLanes],
                               const double (&held)[6][kLanes], int first, const BodyStep& step, SumLanes* sums) {
  const D d;
  const V zero = hn::Zero(d), dt = hn::Set(d, step.time_step), gamma = hn::Set(d, step.gamma);
  const double a = half_alpha_dt(step);
  const V keep = hn::Set(d, 1.0 - a), over = hn::Set(d, 1.0 / (1.0 + a));
  const HeldLanes is_held{held, first};

  // x q v momentum omega; force torque weight_mass mass inertia.
  V moved[4][kFour], load[3][kFour];
  for (int i = 0; i < 4; ++i) of.load(offsetof(Body, x) + i * kFour * sizeof(double), moved[i]);
  for (int i = 0; i < 3; ++i) of.load(offsetof(Body, force) + i * kFour * sizeof(double), load[i]);
  const Lanes3 place = {moved[0][0], moved[0][1], moved[0][2]}, v = {moved[1][3], moved[2][0], moved[2][1]};
  Lanes4 q = {moved[0][3], {moved[1][0], moved[1][1], moved[1][2]}};
  const Lanes3 momentum = {moved[2][2], moved[2][3], moved[3][0]}, spin = {moved[3][1], moved[3][2], moved[3][3]};
  const Lanes3 force = {load[0][0], load[0][1], load[0][2]}, torque = {load[0][3], load[1][0], load[1][1]};
  const V weight_mass = load[1][2], mass = load[1][3];
  const Lanes3 inertia = {load[2][0], load[2][1], load[2][2]};
  Lanes3 held_v = {zero, zero, zero}, held_spin = held_v;
  for (int k = 0; k < 3 && !is_held.none(); ++k) {
    held_v[k] = of.one(offsetof(Body, held_v) + k * sizeof(double));
    held_spin[k] = of.one(offsetof(Body, held_omega) + k * sizeof(double));
  }

  EnergyLanes energies = {{zero, zero}, {zero, zero}, zero};
  const Lanes3 next = accelerate(is_held, first, step, v, held_v, force, weight_mass, mass, sums, &energies);
  const Lanes3 x = sum_of(place, scaled(dt, next));

  // Rotation: the unknown is the angular momentum.
  Lanes33 r = matrix_of(q);
  const auto all_held = hn::And(is_held(3), hn::And(is_held(4), is_held(5)));
  const auto some_held = hn::Or(is_held(3), hn::Or(is_held(4), is_held(5)));
  Lanes3 turned, brake;
  for (int k = 0; k < 3; ++k) {
    brake[k] = hn::IfThenZeroElse(is_held(3 + k), hn::Neg(local_damping(gamma, torque[k], spin[k])));
    turned[k] = hn::Mul(over, hn::MulAdd(keep, momentum[k], hn::Mul(dt, hn::Add(torque[k], brake[k]))));
  }
  Lanes3 omega = spin_at_midpoint(q, r, turned, inertia, all_held, dt);
  Lanes3 carried = turned;
  if (!hn::AllFalse(d, some_held)) {
    for (int k = 0; k < 3; ++k) omega[k] = hn::IfThenElse(is_held(3 + k), held_spin[k], omega[k]);
    const Lanes3 w = transposed_times_of(r, omega);
    const Lanes3 of_held = times(r, {hn::Mul(inertia.x, w.x), hn::Mul(inertia.y, w.y), hn::Mul(inertia.z, w.z)});
    for (int k = 0; k < 3; ++k) carried[k] = hn::IfThenElse(some_held, of_held[k], turned[k]);
  }
  turn(omega, dt, &q, &r);
  if (step.energies) {
    const V half_dt = hn::Mul(hn::Set(d, 0.5), dt), half_alpha = hn::Set(d, 0.5 * step.alpha);
    const Lanes3 viscous = scaled(half_alpha, sum_of(momentum, carried));
    for (int k = 0; k < 3; ++k) {
      const V way_before = hn::Mul(half_dt, spin[k]), way_after = hn::Mul(half_dt, omega[k]);
      energies.external.add(hn::IfThenElseZero(all_held, hn::Neg(torque[k])), way_before, way_after);
      energies.damping.add(hn::IfThenZeroElse(all_held, hn::Sub(viscous[k], brake[k])), way_before, way_after);
    }
    const V swing = hn::Mul(hn::Set(d, 0.25), hn::Add(dot_of(momentum, omega), dot_of(carried, spin)));
    energies.kinetic = hn::Add(energies.kinetic, hn::IfThenZeroElse(all_held, swing));
  }

  const V now[4][kFour] = {{x.x, x.y, x.z, q.w},
                           {q.v.x, q.v.y, q.v.z, next.x},
                           {next.y, next.z, carried.x, carried.y},
                           {carried.z, omega.x, omega.y, omega.z}};
  for (int i = 0; i < 4; ++i) of.store(now[i], offsetof(Body, x) + i * kFour * sizeof(double));
  store_turned(of, r);
  hn::Store(hn::Add(hn::Add(x.x, x.y), hn::Add(x.z, q.w)), d, sums->positions + first);
  hn::Store(energies.kinetic, d, sums->kinetic + first);
  energies.damping.store(sums->damping, first), energies.external.store(sums->external, first);
  hn::Store(assumed[0] ? beyond_assumed(assumed, next, omega) : zero, d, sums->beyond + first);
}

void AdvanceRigid(Body* bodies, const AssumedMotion* all_assumed, const std::int32_t* index, int count,
                  const BodyStep& step, BlockSums* const* sums) {
  alignas(64) double held[6][kLanes];
  SumLanes lanes;
  for (int first = 0; first < count; first += kWidth) {
    Members of{{}, std::min(kWidth, count - first)};
    const AssumedMotion* assumed[kLanes];
    for (int i = 0; i < kWidth; ++i) {
      const std::int32_t body = index[std::min(first + i, count - 1)];
      of.lane[i] = bodies + body, assumed[i] = all_assumed ? all_assumed + body : nullptr;
      for (int k = 0; k < 6; ++k) held[k][first + i] = of.lane[i]->held >> k & 1;
    }
    advance_vector(of, assumed, held, first, step, &lanes);
  }
  for (int i = 0; i < count; ++i) {
    BlockSums& s = *sums[i];
    s.unbalanced = lanes.unbalanced[i];
    s.net = {lanes.net[0][i], lanes.net[1][i], lanes.net[2][i]};
    s.positions = lanes.positions[i];
    s.kinetic = lanes.kinetic[i];
    s.damping = {lanes.damping[0][i], lanes.damping[1][i]}, s.external = {lanes.external[0][i], lanes.external[1][i]};
    s.deviates = lanes.beyond[i] > 0.0;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace quoin::blocks {

HWY_EXPORT(RigidJumps);
HWY_EXPORT(RigidForces);
HWY_EXPORT(AdvanceRigid);

void rigid_jumps(std::span<RigidPair> pairs, const Body* bodies, const PointColumns& columns) {
  HWY_DYNAMIC_DISPATCH(RigidJumps)(pairs, bodies, columns);
}

void rigid_forces(std::span<RigidPair> pairs, const Body* bodies, const PointColumns& columns) {
  HWY_DYNAMIC_DISPATCH(RigidForces)(pairs, bodies, columns);
}

void advance_rigid(Body* bodies, const AssumedMotion* assumed, const std::int32_t* index, int count,
                   const BodyStep& step, BlockSums* const* sums) {
  HWY_DYNAMIC_DISPATCH(AdvanceRigid)(bodies, assumed, index, count, step, sums);
}

}  // namespace quoin::blocks

#endif  // HWY_ONCE
