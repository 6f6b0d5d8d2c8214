#include "step/deformable_kernels.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/deformable_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/lanes3-inl.h"
#include "model/stiffness-inl.h"
#include "model/tiles-inl.h"
#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

constexpr Vector kNothing[2] = {};  // read where there is no gridpoint

// Where a column of each lane begins. Lanes without a block repeat the last one.
template <class Number>
struct Begins {
  Number* of[kLanes];
  template <class Field>
  HWY_INLINE Begins(std::span<const LaneBlock> blocks, const Field& field) {
    for (std::size_t l = 0; l < kLanes; ++l) of[l] = field(blocks[std::min(l, blocks.size() - 1)]);
  }
};

struct Begin {
  Begins<const double> x, v, force, viscous;
  int node_count[kLanes];
  Lanes3 acceleration[kParts], moment[kParts];
  HWY_INLINE explicit Begin(std::span<const LaneBlock> blocks)
      : x(blocks, [](const LaneBlock& b) { return &b.x->x; }),
        v(blocks, [](const LaneBlock& b) { return &b.v->x; }),
        force(blocks, [](const LaneBlock& b) { return b.force; }),
        viscous(blocks, [](const LaneBlock& b) { return b.viscous; }) {
    const auto block = [&](int l) -> const LaneBlock& {
      return blocks[std::min(static_cast<std::size_t>(l), blocks.size() - 1)];
    };
    for (int l = 0; l < kLanes; ++l) node_count[l] = block(l).node_count;
    for (int p = 0; p < kParts; ++p) {
      acceleration[p] = load_vectors([&](int l) { return &block(p * kWidth + l).acceleration.x; });
      moment[p] = load_vectors([&](int l) { return &block(p * kWidth + l).moment.x; });
    }
  }
};

// Loads gridpoint n of the lanes from `first` on. A block without it repeats its first one, without velocity and force.
struct GridpointLoad {
  const Begin& begin;
  const LaneColumns& to;
  int first;

  template <bool kAllHaveIt>
  HWY_INLINE Lanes3 vectors(const Begins<const double>& from, int stride, int n) const {
    return load_vectors([&](int l) {
      return kAllHaveIt || n < begin.node_count[first + l] ? from.of[first + l] + stride * n : &kNothing[0].x;
    });
  }
  HWY_INLINE Lanes3 rows_of_four(const Begins<const double>& from, int n) const {
    V column[kFour];
    load_rows([&](int l) { return from.of[first + l] + kFour * n; }, column);
    return {column[0], column[1], column[2]};
  }
  HWY_INLINE void motion(int n) const {
    constexpr int kVector = 3;
    const auto place = [&](int l) {
      return begin.x.of[first + l] + (n < begin.node_count[first + l] ? kVector * n : 0);
    };
    store_line(load_vectors(place), to.x + n * kLine + first);
    store_line(vectors<false>(begin.v, kVector, n), to.v + n * kLine + first);
  }
  template <bool kAllHaveIt>
  HWY_INLINE void forces(int n) const {
    const int line = n * kLine + first;
    const V mass = hn::Load(D(), to.mass + n * kLanes + first);
    const Lanes3 force = kAllHaveIt ? rows_of_four(begin.force, n) : vectors<false>(begin.force, kFour, n);
    store_line(plus_scaled(force, mass, begin.acceleration[first / kWidth]), to.force + line);
    if (to.viscous) store_line(vectors<kAllHaveIt>(begin.viscous, kFour, n), to.viscous_force + line);
  }
};

void LoadBlocks(std::span<const LaneBlock> blocks, LaneColumns* columns) {
  const Begin begin(blocks);
  for (int first = 0; first < static_cast<int>(blocks.size()); first += kWidth) {
    store_line(begin.moment[first / kWidth], columns->moment + first);
    const GridpointLoad load{begin, *columns, first};
    if (columns->fewest == columns->node_count) {
      rows_to_lanes(begin.x.of + first, 3 * columns->node_count, columns->x + first);
      rows_to_lanes(begin.v.of + first, 3 * columns->node_count, columns->v + first);
    } else {
      for (int n = 0; n < columns->node_count; ++n) load.motion(n);
    }
    for (int n = 0; n < columns->fewest; ++n) load.forces<true>(n);
    for (int n = columns->fewest; n < columns->node_count; ++n) load.forces<false>(n);
  }
}

// R of a matrix near a rotation, by Newton's iteration R <- (R + R^-T)/2, which turns an error e into e^2/2. Four
// iterations reduce kLargestDeformation to rounding.
HWY_INLINE Lanes33 rotation_in(const Lanes33& f) {
  const V half = hn::Set(D(), 0.5);
  Lanes33 r = f;
  for (int iteration = 0; iteration < 4; ++iteration) {
    const Lanes33 cofactor = cofactors_of(r);
    const V over = hn::Div(half, dot_of(r.row[0], cofactor.row[0]));
    for (int i = 0; i < 3; ++i) r.row[i] = plus_scaled(scaled(half, r.row[i]), over, cofactor.row[i]);
  }
  return r;
}

// Adds x b^T to the sum.
HWY_INLINE void add_outer(const Lanes3& x, const Lanes3& b, Lanes33& sum) {
  for (int i = 0; i < 3; ++i) sum.row[i] = plus_scaled(sum.row[i], x[i], b);
}

HWY_INLINE Lanes33 zero_matrix() { return {{zeros(), zeros(), zeros()}}; }

// The shape of congruent blocks, equal in all lanes. place, anchor: of gridpoint n, in the lanes from `first` on.
struct SharedFrame {
  const CongruentBlocks& congruent;
  HWY_INLINE Lanes3 place(int n, int) const { return broadcast(&congruent.place[static_cast<std::size_t>(n)].x); }
  HWY_INLINE Lanes3 anchor(int n, int) const { return broadcast(&congruent.anchor[static_cast<std::size_t>(n)].x); }
  void times_stiffness(const double* w, int node_count, double* product) const;
};

// Shapes of blocks that differ, lane by lane.
struct OwnFrames {
  std::span<const LaneBlock> blocks;
  const LaneColumns& columns;
  HWY_INLINE Lanes3 place(int n, int first) const { return load_line(columns.place + n * kLine + first); }
  HWY_INLINE Lanes3 anchor(int n, int first) const { return load_line(columns.anchor + n * kLine + first); }
  void times_stiffness(const double* w, int node_count, double* product) const;
};

// Current frames of a vector of blocks.
struct Pose {
  Lanes3 centre;
  Lanes33 f, r, previous_r;  // previous_r: R of the step before; with viscosity
};

// Doubles of a BlockFrame: those of R^T, then those of F.
constexpr int kFrameNumbers = 18;
static_assert(sizeof(BlockFrame) == kFrameNumbers * sizeof(double));

template <class Frame>
HWY_INLINE Pose pose_of(const Frame& frame, const Begins<const double>& frames, const LaneColumns& columns, int first,
                        const ZoneStep& step) {
  Pose pose;
  pose.centre = load_line(columns.x + first);  // position of gridpoint 0: a translation changes neither K u nor F
  alignas(64) double number[kFrameNumbers][kLanes];
  rows_to_lanes(frames.of + first, kFrameNumbers, number[0]);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      pose.r.row[j][i] = hn::Load(D(), number[3 * i + j]);
      pose.f.row[i][j] = hn::Load(D(), number[9 + 3 * i + j]);
    }
  }
  if (step.beta > 0.0) {
    Lanes33 rate = zero_matrix();
    for (int n = 0; n < columns.node_count; ++n)
      add_outer(load_line(columns.v + n * kLine + first), frame.anchor(n, first), rate);
    const V back = hn::Set(D(), -step.dt);
    Lanes33 previous;
    for (int i = 0; i < 3; ++i) previous.row[i] = plus_scaled(pose.f.row[i], back, rate.row[i]);
    pose.previous_r = rotation_in(previous);
  }
  return pose;
}

// Stores displacements u in the frame of the shape, up to a translation, and u + beta du/dt (`weighted`). Returns the
// largest |u| by lane, m.
template <class Frame>
HWY_INLINE V displacements(const Frame& frame, const LaneColumns& columns, int first, const ZoneStep& step,
                           const Pose& pose) {
  const D d;
  const V back = hn::Set(d, -step.dt), ratio = hn::Set(d, step.beta / step.dt);
  V largest = hn::Zero(d);
  const Lanes3 origin = frame.place(0, first);
  for (int n = 0; n < columns.node_count; ++n) {
    const int at = n * kLine + first;
    const Lanes3 shape = difference_of(frame.place(n, first), origin);
    const Lanes3 y = difference_of(load_line(columns.x + at), pose.centre);
    const Lanes3 u = difference_of(transposed_times_of(pose.r, y), shape);
    store_line(u, columns.u + at);
    largest = hn::Max(largest, dot_of(u, u));
    if (step.beta > 0.0) {
      const Lanes3 before = plus_scaled(y, back, load_line(columns.v + at));
      const Lanes3 previous = difference_of(transposed_times_of(pose.previous_r, before), shape);
      store_line(plus_scaled(u, ratio, difference_of(u, previous)), columns.weighted + at);
    }
  }
  return hn::Sqrt(largest);
}

// Computes K w for all lanes.
void SharedFrame::times_stiffness(const double* w, int node_count, double* product) const {
  StiffnessRows<1> rows(congruent.stiffness);
  const double* const of[1] = {w};
  for (int n = 0; n < node_count; ++n) {
    V f[1][3][kParts];
    rows.next(of, f);
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) hn::Store(f[0][c][p], D(), product + n * kLine + c * kLanes + p * kWidth);
    }
  }
}

// Computes K w block by block, with rows of its gridpoints.
void OwnFrames::times_stiffness(const double* w, int node_count, double* product) const {
  double* const of = columns.rows;
  double* const times = of + kFour * node_count;
  for (std::size_t lane = 0; lane < blocks.size(); ++lane) {
    const LaneBlock& block = blocks[lane];
    const int count = block.node_count;
    for (int n = 0; n < count; ++n) {
      for (int c = 0; c < 3; ++c) of[kFour * n + c] = w[static_cast<std::size_t>(n * kLine + c * kLanes) + lane];
      of[kFour * n + 3] = 0.0;
    }
    stiffness_times(block.zones, {of, static_cast<std::size_t>(kFour * count)}, times);
    std::fill(times + kFour * count, times + kFour * node_count, 0.0);
    for (int n = 0; n < node_count; ++n) {
      for (int c = 0; c < 3; ++c)
        product[static_cast<std::size_t>(n * kLine + c * kLanes) + lane] = times[kFour * n + c];
    }
  }
}

// Adds -R (g - q x b), g = K w, to the forces of the blocks. on_frame: additional moment on the frame, in space, N m.
template <class Frame>
HWY_INLINE void add_to_forces(const Frame& frame, const LaneColumns& columns, int first, const Pose& pose,
                              const Lanes3& on_frame, double* force) {
  const D d;
  Lanes3 moment = transposed_times_of(pose.r, on_frame);
  for (int n = 0; n < columns.node_count; ++n) {
    const int at = n * kLine + first;
    const Lanes3 place = sum_of(frame.place(n, first), load_line(columns.u + at));
    moment = sum_of(moment, cross_of(place, load_line(columns.product + at)));
  }
  Lanes33 u = zero_matrix();  // R^T F
  for (int i = 0; i < 3; ++i) add_outer(pose.r.row[i], pose.f.row[i], u);
  const V trace = hn::Add(u.row[0].x, hn::Add(u.row[1].y, u.row[2].z));
  Lanes33 g;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const V mean = hn::Mul(hn::Set(d, -0.5), hn::Add(u.row[i][j], u.row[j][i]));
      g.row[i][j] = i == j ? hn::Add(trace, mean) : mean;
    }
  }
  const Lanes33 cofactor = cofactors_of(g);  // symmetric, as g is
  const Lanes3 q = scaled(hn::Div(hn::Set(d, 1.0), dot_of(g.row[0], cofactor.row[0])), times(cofactor, moment));
  for (int n = 0; n < columns.node_count; ++n) {
    const int at = n * kLine + first;
    const Lanes3 b = frame.anchor(n, first);
    const Lanes3 f = times(pose.r, difference_of(load_line(columns.product + at), cross_of(q, b)));
    store_line(difference_of(load_line(force + at), f), force + at);
  }
}

template <class Frame>
HWY_INLINE void frame_forces(const Frame& frame, std::span<const LaneBlock> blocks, const ZoneStep& step,
                             LaneColumns* columns, FrameSums* sums) {
  const D d;
  const LaneColumns& c = *columns;
  const bool is_viscous = step.beta > 0.0;
  const Begins<const double> frames(blocks, [](const LaneBlock& b) { return &b.frame->transposed_r.row[0].x; });
  Pose pose[kParts];
  for (int p = 0; p < kParts; ++p) {
    pose[p] = pose_of(frame, frames, c, p * kWidth, step);
    hn::Store(displacements(frame, c, p * kWidth, step, pose[p]), d, sums->deformation + p * kWidth);
  }
  if (step.energies) {
    frame.times_stiffness(c.u, c.node_count, c.elastic);
    for (int p = 0; p < kParts; ++p) {
      V twice_energy = hn::Zero(d);
      for (int n = 0; n < c.node_count; ++n) {
        const int at = n * kLine + p * kWidth;
        twice_energy = hn::Add(twice_energy, dot_of(load_line(c.u + at), load_line(c.elastic + at)));
      }
      hn::Store(hn::Mul(hn::Set(d, 0.5), twice_energy), d, sums->strain + p * kWidth);
    }
  }
  // Forces are bitwise identical with and without energies.
  frame.times_stiffness(is_viscous ? c.weighted : c.u, c.node_count, c.product);
  for (int p = 0; p < kParts; ++p)
    add_to_forces(frame, c, p * kWidth, pose[p], load_line(c.moment + p * kWidth), c.force);
  if (!c.viscous) return;
  const int size = c.node_count * kLine;
  std::fill(c.viscous_force, c.viscous_force + size, 0.0);
  for (int i = 0; i < size; i += kWidth)
    hn::Store(hn::Sub(hn::Load(d, c.product + i), hn::Load(d, c.elastic + i)), d, c.product + i);
  for (int p = 0; p < kParts; ++p) add_to_forces(frame, c, p * kWidth, pose[p], zeros(), c.viscous_force);
}

void CongruentForces(std::span<const LaneBlock> blocks, const CongruentBlocks& congruent, const ZoneStep& step,
                     LaneColumns* columns, FrameSums* sums) {
  frame_forces(SharedFrame{congruent}, blocks, step, columns, sums);
}

void DistinctForces(std::span<const LaneBlock> blocks, const ZoneStep& step, LaneColumns* columns, FrameSums* sums) {
  frame_forces(OwnFrames{blocks, *columns}, blocks, step, columns, sums);
}

// ---- Gridpoints ----------------------------------------------------------------------------------------------------

// Sums of a step, by lane.
struct GridpointSums {
  alignas(64) double unbalanced[kLanes], net[3][kLanes], positions[kLanes];
  alignas(64) double kinetic[kLanes], damping[kLanes], external[kLanes];
};

HWY_INLINE void store_by_lane(const Lanes3& a, double (*to)[kLanes], int first) {
  for (int k = 0; k < 3; ++k) hn::Store(a[k], D(), to[k] + first);
}

// Writes three numbers a gridpoint of the lanes from `first` on back into the blocks.
HWY_INLINE void store_vectors(const double* lanes, std::span<const LaneBlock> blocks, Vector* LaneBlock::*field,
                              int first, const LaneColumns& columns) {
  constexpr int kVector = 3;
  const Begins<double> begin(blocks, [&](const LaneBlock& b) { return &(b.*field)->x; });
  const int row_count = std::min(kWidth, static_cast<int>(blocks.size()) - first);
  if (columns.fewest == columns.node_count)
    return lanes_to_rows(lanes + first, kVector * columns.node_count, begin.of + first, row_count);
  for (int l = first; l < first + row_count; ++l) {
    const int count = kVector * blocks[static_cast<std::size_t>(l)].node_count;
    for (int i = 0; i < count; ++i) begin.of[l][i] = lanes[i * kLanes + l];
  }
}

// No frame: forces zone by zone.
struct NoFrame {};

// Stores F and R from the positions in the columns, lane by lane.
template <class Frame>
HWY_INLINE void store_frames(std::span<const LaneBlock> blocks, const LaneColumns& columns, int first,
                             const Frame& frame) {
  const Lanes3 origin = load_line(columns.x + first);
  Lanes33 f = zero_matrix();
  for (int n = 1; n < columns.node_count; ++n)
    add_outer(difference_of(load_line(columns.x + n * kLine + first), origin), frame.anchor(n, first), f);
  const Lanes33 r = rotation_in(f);
  alignas(64) double number[kFrameNumbers][kLanes];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      hn::Store(r.row[j][i], D(), number[3 * i + j]);
      hn::Store(f.row[i][j], D(), number[9 + 3 * i + j]);
    }
  }
  const Begins<double> begin(blocks, [](const LaneBlock& b) { return &b.frame->transposed_r.row[0].x; });
  lanes_to_rows(number[0], kFrameNumbers, begin.of + first, std::min(kWidth, static_cast<int>(blocks.size()) - first));
}

// Optional parts of the motion of gridpoints.
struct Needs {
  bool brakes;    // held gridpoints, damping by eq. 1 or by mass
  bool measured;  // net forces and kinetic energy
  bool energies;  // work
};

// The three components, unrolled: lanes indexed at run time would go through memory.
template <class Visit>
HWY_INLINE void each_component(const Visit& visit) {
  visit(std::integral_constant<int, 0>()), visit(std::integral_constant<int, 1>());
  visit(std::integral_constant<int, 2>());
}

template <Needs kNeeds, class Frame>
HWY_INLINE void advance_vector(std::span<const LaneBlock> blocks, const LaneColumns& columns, int first,
                               const RigidGains* gains, const GridpointStep& step, const Frame& frame,
                               GridpointSums* sums) {
  constexpr bool kFrame = !std::is_same_v<Frame, NoFrame>;
  const D d;
  const V zero = hn::Zero(d), half = hn::Set(d, 0.5), dt = hn::Set(d, step.time_step);
  const V gamma = hn::Set(d, step.gamma), alpha = hn::Set(d, step.alpha);
  const double a = 0.5 * step.alpha * step.time_step;  // v' = -alpha v, with the mean of both velocities
  const V keep = hn::Set(d, 1.0 - a), over = hn::Set(d, 1.0 / (1.0 + a));
  const V factor = hn::Set(d, step.inertia_factor), over_factor = hn::Set(d, 1.0 / step.inertia_factor);
  Lanes3 centre, linear;
  Lanes33 turning;
  for (int k = 0; gains && k < 3; ++k) {
    centre[k] = hn::Load(d, gains->centre[k].of + first);
    linear[k] = hn::Load(d, gains->linear[k].of + first);
    for (int j = 0; j < 3; ++j) turning.row[k][j] = hn::Load(d, gains->turning[k][j].of + first);
  }
  V unbalanced = zero, positions = zero, kinetic = zero, damping = zero, external = zero;  // `unbalanced` is a square
  Lanes3 net = zeros();
  for (int n = 0; n < columns.node_count; ++n) {
    const int at = n * kLine + first;
    const Lanes3 x = load_line(columns.x + at), v = load_line(columns.v + at), force = load_line(columns.force + at);
    const V mass = hn::Load(d, columns.mass + n * kLanes + first);
    const V dt_over_mass = hn::Mul(dt, hn::Load(d, columns.over_mass + n * kLanes + first));
    Lanes3 driven = scaled(hn::Mul(dt_over_mass, over_factor), force);  // change of velocity
    if (gains) driven = sum_of(driven, sum_of(linear, times(turning, difference_of(x, centre))));
    Lanes3 next, held_v;
    if (kNeeds.brakes && columns.held) held_v = load_line(columns.held_v + at);
    V free = zero;
    each_component([&](auto k) HWY_ATTR {
      V change = driven[k], brake = zero;
      auto hold = hn::FirstN(d, 0);
      if constexpr (kNeeds.brakes) {
        if (columns.held) hold = hn::Ne(hn::Load(d, columns.held + n * kLine + k * kLanes + first), zero);
        if (step.gamma > 0.0) {
          const V relative = hn::Sub(v[k], hn::Set(d, step.ground[k]));
          const V amount = hn::CopySign(hn::Mul(gamma, hn::Abs(force[k])), relative);
          brake = hn::IfThenZeroElse(hn::Eq(relative, zero), hn::Neg(amount));
          change = hn::MulAdd(dt_over_mass, brake, change);
        }
        if (a > 0.0 && step.ground[k] != 0.0) change = hn::Add(change, hn::Set(d, 2.0 * a * step.ground[k]));
        next[k] = hn::Mul(over, hn::MulAdd(keep, v[k], change));
        if (columns.held) next[k] = hn::IfThenElse(hold, held_v[k], next[k]);
      } else {
        next[k] = hn::Add(v[k], change);
      }
      if constexpr (!kNeeds.measured) return;
      const auto unless_held = [&](V y) HWY_ATTR { return kNeeds.brakes ? hn::IfThenZeroElse(hold, y) : y; };
      const V free_force = unless_held(force[k]);
      free = hn::MulAdd(free_force, free_force, free);
      net[k] = hn::Add(net[k], free_force);
      const V twice_mean = hn::Add(v[k], next[k]);
      kinetic = hn::MulAdd(unless_held(hn::Mul(mass, twice_mean)), twice_mean, kinetic);
      if constexpr (!kNeeds.energies) return;
      const V mean = hn::Mul(half, twice_mean), way = hn::Mul(mean, dt);
      const V viscous = hn::Mul(factor, hn::Mul(alpha, hn::Mul(mass, hn::Sub(mean, hn::Set(d, step.ground[k])))));
      damping = hn::MulAdd(unless_held(hn::Sub(viscous, brake)), way, damping);
      const V weight = hn::Mul(mass, hn::Set(d, step.weight_per_mass * step.gravity[k]));
      external = hn::MulAdd(hn::IfThenElse(hold, hn::Sub(weight, force[k]), weight), way, external);
      if (columns.viscous) damping = hn::NegMulAdd(hn::Load(d, columns.viscous_force + at + k * kLanes), way, damping);
    });
    // Keeps NaN.
    if constexpr (kNeeds.measured) unbalanced = hn::IfThenElse(hn::Le(free, unbalanced), unbalanced, free);
    const Lanes3 place = plus_scaled(x, dt, next);
    positions = hn::Add(positions, hn::Add(place.x, hn::Add(place.y, place.z)));
    store_line(place, columns.x + at);
    store_line(next, columns.v + at);
  }
  store_vectors(columns.x, blocks, &LaneBlock::x, first, columns);
  store_vectors(columns.v, blocks, &LaneBlock::v, first, columns);
  if constexpr (kFrame) store_frames(blocks, columns, first, frame);
  hn::Store(hn::Sqrt(unbalanced), d, sums->unbalanced + first);
  store_by_lane(net, sums->net, first);
  hn::Store(positions, d, sums->positions + first);
  hn::Store(hn::Mul(hn::Mul(hn::Set(d, 0.125), factor), kinetic), d, sums->kinetic + first);
  hn::Store(damping, d, sums->damping + first);
  hn::Store(external, d, sums->external + first);
}

template <class Frame>
HWY_INLINE void advance_all(std::span<const LaneBlock> blocks, const LaneColumns& columns, const RigidGains* gains,
                            const GridpointStep& step, const Frame& frame, GridpointSums* lanes) {
  const bool brakes = columns.held || step.gamma > 0.0 || step.alpha > 0.0;
  for (int first = 0; first < static_cast<int>(blocks.size()); first += kWidth) {
    if (step.energies)
      advance_vector<Needs{true, true, true}>(blocks, columns, first, gains, step, frame, lanes);
    else if (step.measured)
      advance_vector<Needs{true, true, false}>(blocks, columns, first, gains, step, frame, lanes);
    else if (brakes)
      advance_vector<Needs{true, false, false}>(blocks, columns, first, gains, step, frame, lanes);
    else
      advance_vector<Needs{false, false, false}>(blocks, columns, first, gains, step, frame, lanes);
  }
}

void AdvanceGridpoints(std::span<const LaneBlock> blocks, const LaneColumns& columns, const RigidGains* gains,
                       const GridpointStep& step, const CongruentBlocks* shared, BlockSums* const* sums) {
  GridpointSums lanes;
  if (!blocks.front().frame)
    advance_all(blocks, columns, gains, step, NoFrame{}, &lanes);
  else if (shared)
    advance_all(blocks, columns, gains, step, SharedFrame{*shared}, &lanes);
  else
    advance_all(blocks, columns, gains, step, OwnFrames{blocks, columns}, &lanes);
  for (std::size_t l = 0; l < blocks.size(); ++l) {
    BlockSums& s = *sums[l];
    s.unbalanced = lanes.unbalanced[l];
    s.net = {lanes.net[0][l], lanes.net[1][l], lanes.net[2][l]};
    s.positions = lanes.positions[l];
    s.kinetic += lanes.kinetic[l], s.damping += lanes.damping[l], s.external += lanes.external[l];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace quoin::blocks {

HWY_EXPORT(LoadBlocks);
HWY_EXPORT(CongruentForces);
HWY_EXPORT(DistinctForces);
HWY_EXPORT(AdvanceGridpoints);

void LaneColumns::resize(int nodes) {
  node_count = nodes;
  double** const columns[] = {&x, &v, &force, &viscous_force, &u, &weighted, &product, &elastic};
  const auto size = static_cast<std::size_t>(nodes) * kLine;
  memory_.resize(std::max(memory_.size(), std::size(columns) * size + kLine + size / 3));
  double* from = memory_.data();
  for (double** column : columns) *column = from, from += size;
  moment = from;
  rows = from + kLine;
}

void load_blocks(std::span<const LaneBlock> blocks, const FixedColumns<const double>& fixed, LaneColumns* columns) {
  int most = 0, fewest = std::numeric_limits<int>::max();
  for (const LaneBlock& b : blocks) most = std::max(most, b.node_count), fewest = std::min(fewest, b.node_count);
  columns->resize(most);
  columns->fewest = fewest;
  columns->mass = fixed.mass, columns->over_mass = fixed.over_mass;
  columns->place = fixed.place, columns->anchor = fixed.anchor;
  columns->held = fixed.held, columns->held_v = fixed.held_v;
  HWY_DYNAMIC_DISPATCH(LoadBlocks)(blocks, columns);
}

void congruent_forces(std::span<const LaneBlock> blocks, const CongruentBlocks& congruent, const ZoneStep& step,
                      LaneColumns* columns, FrameSums* sums) {
  HWY_DYNAMIC_DISPATCH(CongruentForces)(blocks, congruent, step, columns, sums);
}

void distinct_forces(std::span<const LaneBlock> blocks, const ZoneStep& step, LaneColumns* columns, FrameSums* sums) {
  HWY_DYNAMIC_DISPATCH(DistinctForces)(blocks, step, columns, sums);
}

void advance_gridpoints(std::span<const LaneBlock> blocks, const LaneColumns& columns, const RigidGains* gains,
                        const GridpointStep& step, const CongruentBlocks* shared, BlockSums* const* sums) {
  HWY_DYNAMIC_DISPATCH(AdvanceGridpoints)(blocks, columns, gains, step, shared, sums);
}

}  // namespace quoin::blocks

#endif  // HWY_ONCE
