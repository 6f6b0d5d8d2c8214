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

#include "model/stiffness-inl.h"
#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

constexpr Vector kNothing[2] = {};  // read where there is no gridpoint

// ---- Between rows of numbers, one a block, and lanes: a line of kLanes for each number ------------------------------

// Swaps lanes l, l + kPart of vector i with lanes i, i + kPart of vector l: its own inverse.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void transpose_tile(V (&)[kPart]) {}
#else
template <class Tag = D>
HWY_INLINE void transpose_tile(hn::Vec<Tag> (&a)[kPart]) {
  const Tag d;
  if constexpr (kPart == 2) {
    const auto upper = hn::InterleaveUpper(d, a[0], a[1]);
    a[0] = hn::InterleaveLower(d, a[0], a[1]), a[1] = upper;
  } else {
    const auto low01 = hn::InterleaveLower(d, a[0], a[1]), up01 = hn::InterleaveUpper(d, a[0], a[1]);
    const auto low23 = hn::InterleaveLower(d, a[2], a[3]), up23 = hn::InterleaveUpper(d, a[2], a[3]);
    a[0] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(low23), low01);
    a[1] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(up23), up01);
    a[2] = hn::OddEvenBlocks(low23, hn::SwapAdjacentBlocks(low01));
    a[3] = hn::OddEvenBlocks(up23, hn::SwapAdjacentBlocks(up01));
  }
}
#endif

// rows: kWidth pointers to `count` numbers each, at least kPart; lanes: address of number 0 of the first row.
HWY_INLINE void rows_to_lanes(const double* const* rows, int count, double* lanes) {
  for (int i = 0; i < count; i += kPart) {
    const int at = std::min(i, count - kPart);  // the last tile repeats some numbers
    V tile[kPart];
    for (int l = 0; l < kPart; ++l)
      tile[l] = join(hn::LoadU(Four(), rows[l] + at), hn::LoadU(Four(), rows[l + kWidth - kPart] + at));
    transpose_tile(tile);
    for (int l = 0; l < kPart; ++l) hn::Store(tile[l], D(), lanes + (at + l) * kLanes);
  }
}

// Inverse of rows_to_lanes, for the first `row_count` rows.
HWY_INLINE void lanes_to_rows(const double* lanes, int count, double* const* rows, int row_count) {
  for (int i = 0; i < count; i += kPart) {
    const int at = std::min(i, count - kPart);
    V tile[kPart];
    for (int l = 0; l < kPart; ++l) tile[l] = hn::Load(D(), lanes + (at + l) * kLanes);
    transpose_tile(tile);
    for (int first = 0; first < kWidth; first += kPart) {
      for (int l = 0; l < kPart && first + l < row_count; ++l)
        hn::StoreU(part_of(tile[l], first), Four(), rows[first + l] + at);
    }
  }
}

// ---- Blocks --------------------------------------------------------------------------------------------------------

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
  Lanes3 acceleration[kParts];
  HWY_INLINE explicit Begin(std::span<const LaneBlock> blocks)
      : x(blocks, [](const LaneBlock& b) { return &b.x->x; }),
        v(blocks, [](const LaneBlock& b) { return &b.v->x; }),
        force(blocks, [](const LaneBlock& b) { return b.force; }),
        viscous(blocks, [](const LaneBlock& b) { return b.viscous; }) {
    const auto block = [&](int l) -> const LaneBlock& {
      return blocks[std::min(static_cast<std::size_t>(l), blocks.size() - 1)];
    };
    for (int l = 0; l < kLanes; ++l) node_count[l] = block(l).node_count;
    for (int p = 0; p < kParts; ++p)
      acceleration[p] = load_vectors([&](int l) { return &block(p * kWidth + l).acceleration.x; });
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
  HWY_INLINE void weight(int n) const {
    const V mass = hn::Load(D(), to.mass + n * kLanes + first);
    store_line(scaled(mass, begin.acceleration[first / kWidth]), to.force + n * kLine + first);
    if (to.viscous) store_line(zeros(), to.viscous_force + n * kLine + first);
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

void LoadBlocks(std::span<const LaneBlock> blocks, bool motion, LaneColumns* columns) {
  const Begin begin(blocks);
  const bool no_force = !blocks.front().force;
  for (int first = 0; first < static_cast<int>(blocks.size()); first += kWidth) {
    const GridpointLoad load{begin, *columns, first};
    const bool in_tiles = columns->fewest == columns->node_count;
    if (motion && in_tiles) {
      rows_to_lanes(begin.x.of + first, 3 * columns->node_count, columns->x + first);
      rows_to_lanes(begin.v.of + first, 3 * columns->node_count, columns->v + first);
    }
    for (int n = 0; motion && !in_tiles && n < columns->node_count; ++n) load.motion(n);
    if (no_force) {
      for (int n = 0; n < columns->node_count; ++n) load.weight(n);
      continue;
    }
    for (int n = 0; n < columns->fewest; ++n) load.forces<true>(n);
    for (int n = columns->fewest; n < columns->node_count; ++n) load.forces<false>(n);
  }
}

// Three numbers of the rows of a line, in the lanes from `first` on.
HWY_INLINE Lanes3 rows_of(const RowLine& line, const FacetRow* rows, int first) {
  V column[kFour];
  load_rows([&](int l) { return rows[line[static_cast<std::size_t>(first + l)]].force; }, column);
  return {column[0], column[1], column[2]};
}

LaneSums AddGridpointLines(std::span<const GridpointLine> lines, std::span<const RowLine> moments, const FacetRow* rows,
                           std::size_t count, LaneColumns* columns) {
  LaneSums sums;
  for (int first = 0; first < static_cast<int>(count); first += kWidth) {
    Lanes3 moment = zeros(), sum = zeros();
    for (const RowLine& line : moments) moment = sum_of(moment, rows_of(line, rows, first));
    store_line(moment, columns->moment + first);
    for (const GridpointLine& line : lines) {
      Lanes3 force = rows_of(line.row, rows, first);
      if (!line.side_a) force = {hn::Neg(force.x), hn::Neg(force.y), hn::Neg(force.z)};
      double* const to = columns->force + line.node * kLine + first;
      store_line(sum_of(load_line(to), force), to);
      sum = sum_of(sum, force);
    }
    for (int k = 0; k < 3; ++k) hn::Store(sum[k], D(), sums.of[k] + first);
  }
  return sums;
}

// R of a matrix near a rotation, by Newton's iteration R <- (R + R^-T)/2, which turns an error e into e^2/2. Four
// iterations reduce kLargestDeformation to rounding. A lane whose last change leaves less than rounding is not changed
// again, so that it does not depend on the others.
HWY_INLINE Lanes33 rotation_in(const Lanes33& f) {
  const D d;
  constexpr double kSquareOfLastChange = 1e-17;
  const V half = hn::Set(d, 0.5);
  Lanes33 r = f;
  auto goes_on = hn::Eq(half, half);
  for (int iteration = 0; iteration < 4 && !hn::AllFalse(d, goes_on); ++iteration) {
    const Lanes33 cofactor = cofactors_of(r);
    const V over = hn::Div(half, dot_of(r.row[0], cofactor.row[0]));
    V square = hn::Zero(d);
    for (int i = 0; i < 3; ++i) {
      const Lanes3 next = plus_scaled(scaled(half, r.row[i]), over, cofactor.row[i]);
      const Lanes3 change = difference_of(next, r.row[i]);
      square = hn::Add(square, dot_of(change, change));
      for (int k = 0; k < 3; ++k) r.row[i][k] = hn::IfThenElse(goes_on, next[k], r.row[i][k]);
    }
    goes_on = hn::And(goes_on, hn::Gt(square, hn::Set(d, kSquareOfLastChange)));
  }
  return r;
}

// Adds x b^T to the sum.
HWY_INLINE void add_outer(const Lanes3& x, const Lanes3& b, Lanes33& sum) {
  for (int i = 0; i < 3; ++i) sum.row[i] = plus_scaled(sum.row[i], x[i], b);
}

HWY_INLINE Lanes33 zero_matrix() { return {{zeros(), zeros(), zeros()}}; }

// Torques of internal forces g = K w in the frame, sum (X + u) x g. K has no torque sum X x g.
struct Torques {
  Lanes3 sum[kParts];
  HWY_INLINE void add(const double* u, int n, int part, const Lanes3& g) {
    sum[part] = sum_of(sum[part], cross_of(load_line(u + n * kLine + part * kWidth), g));
  }
};

// The shape of congruent blocks, equal in all lanes. place, anchor: of gridpoint n, in the lanes from `first` on.
struct SharedFrame {
  const CongruentBlocks& congruent;
  HWY_INLINE Lanes3 place(int n, int) const { return broadcast(&congruent.place[static_cast<std::size_t>(n)].x); }
  HWY_INLINE Lanes3 anchor(int n, int) const { return broadcast(&congruent.anchor[static_cast<std::size_t>(n)].x); }
  HWY_INLINE int anchor_count(const LaneColumns&) const { return static_cast<int>(congruent.anchor.size()); }
};

// Shapes of blocks that differ, lane by lane.
struct OwnFrames {
  std::span<const LaneBlock> blocks;
  const LaneColumns& columns;
  HWY_INLINE Lanes3 place(int n, int first) const { return load_line(columns.place + n * kLine + first); }
  HWY_INLINE Lanes3 anchor(int n, int first) const { return load_line(columns.anchor + n * kLine + first); }
  HWY_INLINE int anchor_count(const LaneColumns& c) const { return c.node_count; }
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
    for (int n = 0; n < frame.anchor_count(columns); ++n)
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

// A group whose product with the stiffness is computed: w, K w, and where torques are needed u.
struct Product {
  const double *w, *u;
  double* result;
  Torques torques;
};

// Computes K w for all lanes of groups of congruent blocks, which share the loads of coefficients.
template <bool kTorques, int kCount>
HWY_INLINE void times_stiffness(const SharedFrame (&frames)[kCount], const LaneColumns* const (&columns)[kCount],
                                Product (&products)[kCount]) {
  StiffnessRows<kCount> rows(frames[0].congruent.stiffness);
  const double* w[kCount];
  Torques torques[kCount];  // in registers
  for (int b = 0; b < kCount; ++b) w[b] = products[b].w, torques[b] = products[b].torques;
  for (int n = 0; n < columns[0]->node_count; ++n) {
    V f[kCount][3][kParts];
    rows.next(w, f);
    for (int b = 0; b < kCount; ++b) {
      for (int p = 0; p < kParts; ++p) {
        const Lanes3 g{f[b][0][p], f[b][1][p], f[b][2][p]};
        store_line(g, products[b].result + n * kLine + p * kWidth);
        if constexpr (kTorques) torques[b].add(products[b].u, n, p, g);
      }
    }
  }
  for (int b = 0; b < kCount; ++b) products[b].torques = torques[b];
}

// Computes K w block by block, with rows of its gridpoints.
template <bool kTorques>
void times_stiffness(const OwnFrames (&frames)[1], const LaneColumns* const (&columns)[1], Product (&products)[1]) {
  Product& product = products[0];
  const int node_count = columns[0]->node_count;
  double* const of = columns[0]->rows;
  double* const times = of + kFour * node_count;
  for (std::size_t lane = 0; lane < frames[0].blocks.size(); ++lane) {
    const LaneBlock& block = frames[0].blocks[lane];
    const int count = block.node_count;
    for (int n = 0; n < count; ++n) {
      for (int c = 0; c < 3; ++c)
        of[kFour * n + c] = product.w[static_cast<std::size_t>(n * kLine + c * kLanes) + lane];
      of[kFour * n + 3] = 0.0;
    }
    stiffness_times(block.zones, {of, static_cast<std::size_t>(kFour * count)}, times);
    std::fill(times + kFour * count, times + kFour * node_count, 0.0);
    for (int n = 0; n < node_count; ++n) {
      for (int c = 0; c < 3; ++c)
        product.result[static_cast<std::size_t>(n * kLine + c * kLanes) + lane] = times[kFour * n + c];
    }
  }
  for (int n = 0; kTorques && n < node_count; ++n) {
    for (int p = 0; p < kParts; ++p)
      product.torques.add(product.u, n, p, load_line(product.result + n * kLine + p * kWidth));
  }
}

// Adds -R (g - q x b), g = K w, to the forces of the blocks. moment: of g and of point forces on the frame, in it, N m.
template <class Frame>
HWY_INLINE void add_to_forces(const Frame& frame, const LaneColumns& columns, int first, const Pose& pose,
                              const Lanes3& moment, double* force) {
  const D d;
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
  const int anchors = frame.anchor_count(columns);
  const Lanes3 q = scaled(hn::Div(hn::Set(d, 1.0), dot_of(g.row[0], cofactor.row[0])), times(cofactor, moment));
  for (int n = 0; n < columns.node_count; ++n) {
    const int at = n * kLine + first;
    Lanes3 internal = load_line(columns.product + at);
    if (n < anchors) internal = difference_of(internal, cross_of(q, frame.anchor(n, first)));
    const Lanes3 f = times(pose.r, internal);
    store_line(difference_of(load_line(force + at), f), force + at);
  }
}

HWY_INLINE void store_strain_energies(const LaneColumns& c, FrameSums* sums) {
  for (int p = 0; p < kParts; ++p) {
    V twice_energy = zeros().x;
    for (int n = 0; n < c.node_count; ++n) {
      const int at = n * kLine + p * kWidth;
      twice_energy = hn::Add(twice_energy, dot_of(load_line(c.u + at), load_line(c.elastic + at)));
    }
    hn::Store(hn::Mul(hn::Set(D(), 0.5), twice_energy), D(), sums->strain + p * kWidth);
  }
}

// Computes the viscous part of the forces, K (w - u).
template <class Frame>
HWY_INLINE void viscous_forces(const Frame& frame, const LaneColumns& c, const Pose (&pose)[kParts]) {
  std::fill(c.viscous_force, c.viscous_force + c.node_count * kLine, 0.0);
  for (int p = 0; p < kParts; ++p) {
    Torques torques;
    torques.sum[p] = zeros();
    for (int n = 0; n < c.node_count; ++n) {
      const int at = n * kLine + p * kWidth;
      const Lanes3 g = difference_of(load_line(c.product + at), load_line(c.elastic + at));
      store_line(g, c.product + at);
      torques.add(c.u, n, p, g);
    }
    add_to_forces(frame, c, p * kWidth, pose[p], torques.sum[p], c.viscous_force);
  }
}

template <class Frame, int kCount>
HWY_INLINE void frame_forces(const Frame (&frames)[kCount], const FramedGroup* groups, const ZoneStep& step) {
  const D d;
  const LaneColumns* columns[kCount];
  Pose pose[kCount][kParts];
  Product elastic[kCount], products[kCount];
  for (int b = 0; b < kCount; ++b) {
    const FramedGroup& group = groups[b];
    const LaneColumns& c = *(columns[b] = group.columns);
    const Begins<const double> begins(group.blocks,
                                      [](const LaneBlock& of) { return &of.frame->transposed_r.row[0].x; });
    elastic[b] = {c.u, nullptr, c.elastic, {}};
    products[b] = {step.beta > 0.0 ? c.weighted : c.u, c.u, c.product, {}};
    for (int p = 0; p < kParts; ++p) {
      pose[b][p] = pose_of(frames[b], begins, c, p * kWidth, step);
      hn::Store(displacements(frames[b], c, p * kWidth, step, pose[b][p]), d, group.sums->deformation + p * kWidth);
      elastic[b].torques.sum[p] = zeros();
      products[b].torques.sum[p] = transposed_times_of(pose[b][p].r, load_line(c.moment + p * kWidth));
    }
  }
  if (step.energies) times_stiffness<false>(frames, columns, elastic);
  // Forces are bitwise identical with and without energies.
  times_stiffness<true>(frames, columns, products);
  for (int b = 0; b < kCount; ++b) {
    const LaneColumns& c = *columns[b];
    if (step.energies) store_strain_energies(c, groups[b].sums);
    for (int p = 0; p < kParts; ++p)
      add_to_forces(frames[b], c, p * kWidth, pose[b][p], products[b].torques.sum[p], c.force);
    if (c.viscous) viscous_forces(frames[b], c, pose[b]);
  }
}

// Rotations of the fixed frames of a vector of blocks.
HWY_INLINE Lanes33 fixed_rotations(const FixedFrameLanes& at_start, int first) {
  Lanes33 r;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r.row[i][j] = hn::Load(D(), at_start.rotation[i][j].of + first);
  }
  return r;
}

// Stores displacements u in fixed frames, up to a translation, and u + beta v (`weighted`).
HWY_INLINE void fixed_displacements(const LaneColumns& c, int first, double beta, const Lanes33& r) {
  const V of_rate = hn::Set(D(), beta);
  const Lanes3 origin = difference_of(load_line(c.x + first), load_line(c.arm + first));
  for (int n = 0; n < c.node_count; ++n) {
    const int at = n * kLine + first;
    const Lanes3 moved = difference_of(difference_of(load_line(c.x + at), load_line(c.arm + at)), origin);
    const Lanes3 u = transposed_times_of(r, moved);
    store_line(u, c.u + at);
    if (beta > 0.0) store_line(plus_scaled(u, of_rate, transposed_times_of(r, load_line(c.v + at))), c.weighted + at);
  }
}

template <int kCount>
HWY_INLINE void fixed_forces(const FramedGroup* groups, const CongruentBlocks& congruent, const ZoneStep& step) {
  const LaneColumns* columns[kCount];
  Lanes33 r[kCount][kParts];
  Lanes3 q[kCount][kParts];  // in the frames: half of the moments on them, as U = 1
  StiffnessRows<kCount> rows(congruent.stiffness), elastic_rows(congruent.stiffness);
  const double *w[kCount], *u[kCount];
  for (int b = 0; b < kCount; ++b) {
    const LaneColumns& c = *(columns[b] = groups[b].columns);
    w[b] = step.beta > 0.0 ? c.weighted : c.u, u[b] = c.u;
    for (int p = 0; p < kParts; ++p) {
      r[b][p] = fixed_rotations(*c.at_start, p * kWidth);
      q[b][p] = scaled(hn::Set(D(), 0.5), transposed_times_of(r[b][p], load_line(c.moment + p * kWidth)));
      fixed_displacements(c, p * kWidth, step.beta, r[b][p]);
    }
    std::fill(groups[b].sums->deformation, std::end(groups[b].sums->deformation), 0.0);
  }
  const int anchors = static_cast<int>(congruent.anchor.size());
  for (int n = 0; n < columns[0]->node_count; ++n) {
    V f[kCount][3][kParts], elastic[kCount][3][kParts];
    rows.next(w, f);
    if (step.energies) elastic_rows.next(u, elastic);
    for (int b = 0; b < kCount; ++b) {
      const LaneColumns& c = *columns[b];
      for (int p = 0; p < kParts; ++p) {
        const int at = n * kLine + p * kWidth;
        const Lanes3 g{f[b][0][p], f[b][1][p], f[b][2][p]};
        Lanes3 internal = g;
        if (n < anchors)
          internal = difference_of(g, cross_of(q[b][p], broadcast(&congruent.anchor[static_cast<std::size_t>(n)].x)));
        store_line(difference_of(load_line(c.force + at), times(r[b][p], internal)), c.force + at);
        if (!step.energies) continue;
        const Lanes3 of_strain{elastic[b][0][p], elastic[b][1][p], elastic[b][2][p]};
        store_line(of_strain, c.elastic + at);
        if (c.viscous) store_line(times(r[b][p], difference_of(of_strain, g)), c.viscous_force + at);
      }
    }
  }
  for (int b = 0; step.energies && b < kCount; ++b) store_strain_energies(*columns[b], groups[b].sums);
}

void FixedFrameForces(std::span<const FramedGroup> groups, const CongruentBlocks& congruent, const ZoneStep& step) {
  groups.size() == 2 ? fixed_forces<2>(groups.data(), congruent, step)
                     : fixed_forces<1>(groups.data(), congruent, step);
}

void CongruentForces(std::span<const FramedGroup> groups, const CongruentBlocks& congruent, const ZoneStep& step) {
  const SharedFrame frame{congruent};
  if (groups.size() == 2)
    frame_forces<SharedFrame, 2>({frame, frame}, groups.data(), step);
  else
    frame_forces<SharedFrame, 1>({frame}, groups.data(), step);
}

void DistinctForces(const FramedGroup& group, const ZoneStep& step) {
  frame_forces<OwnFrames, 1>({OwnFrames{group.blocks, *group.columns}}, &group, step);
}

// ---- Gridpoints ----------------------------------------------------------------------------------------------------

// Sums of a step, by lane.
struct GridpointSums {
  alignas(64) double unbalanced[kLanes], net[3][kLanes], positions[kLanes];
  alignas(64) double kinetic[kLanes], damping[2][kLanes], external[2][kLanes];
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

// No frame that follows the block: small displacements, or forces zone by zone.
struct NoFrame {};

// Stores F, and its R, of the blocks in the lanes from `first` on.
HWY_INLINE void store_frames(std::span<const LaneBlock> blocks, int first, const Lanes33& f) {
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
  bool held;      // held gridpoints
  bool brakes;    // damping by eq. 1 or by mass
  bool measured;  // net forces and kinetic energy
  bool energies;  // work
};

// The three components, unrolled: lanes indexed at run time would go through memory.
template <class Visit>
HWY_INLINE void each_component(const Visit& visit) {
  visit(std::integral_constant<int, 0>()), visit(std::integral_constant<int, 1>());
  visit(std::integral_constant<int, 2>());
}

// GridpointSums of the blocks in one vector.
struct MotionSums {
  V unbalanced, positions, kinetic;  // square of the force; m; twice the energy
  V damping[2], external[2];         // J, in each half of a step
  Lanes3 net;                        // N

  HWY_INLINE MotionSums() {
    unbalanced = positions = kinetic = hn::Zero(D());
    for (int i = 0; i < 2; ++i) damping[i] = external[i] = hn::Zero(D());
    net = zeros();
  }

  // Adds work of a component in both halves of a step, with the velocities before and after it.
  HWY_INLINE void add_work(V damped, V given, V v, V next, V dt) {
    const V half_dt = hn::Mul(hn::Set(D(), 0.5), dt), way[2] = {hn::Mul(half_dt, v), hn::Mul(half_dt, next)};
    for (int i = 0; i < 2; ++i) {
      damping[i] = hn::MulAdd(damped, way[i], damping[i]);
      external[i] = hn::MulAdd(given, way[i], external[i]);
    }
  }

  HWY_INLINE void store(V inertia_factor, int first, GridpointSums* sums) const {
    const D d;
    hn::Store(hn::Sqrt(unbalanced), d, sums->unbalanced + first);
    store_by_lane(net, sums->net, first);
    hn::Store(positions, d, sums->positions + first);
    hn::Store(hn::Mul(hn::Mul(hn::Set(d, 0.5), inertia_factor), kinetic), d, sums->kinetic + first);
    for (int i = 0; i < 2; ++i) {
      hn::Store(damping[i], d, sums->damping[i] + first);
      hn::Store(external[i], d, sums->external[i] + first);
    }
  }
};

HWY_INLINE void load_gains(const RigidGains& gains, int first, Lanes3& centre, Lanes3& linear, Lanes33& turning) {
  for (int k = 0; k < 3; ++k) {
    centre[k] = hn::Load(D(), gains.centre[k].of + first);
    linear[k] = hn::Load(D(), gains.linear[k].of + first);
    for (int j = 0; j < 3; ++j) turning.row[k][j] = hn::Load(D(), gains.turning[k][j].of + first);
  }
}

template <Needs kNeeds, class Frame>
HWY_INLINE void advance_vector(std::span<const LaneBlock> blocks, const LaneColumns& columns, int first,
                               const RigidGains* gains, const GridpointStep& step, const Frame& frame,
                               GridpointSums* sums) {
  constexpr bool kFrame = !std::is_same_v<Frame, NoFrame>;
  const D d;
  const V dt = hn::Set(d, step.time_step), gamma = hn::Set(d, step.gamma), alpha = hn::Set(d, step.alpha);
  const double a = 0.5 * step.alpha * step.time_step;  // v' = -alpha v, with the mean of both velocities
  const V keep = hn::Set(d, 1.0 - a), over = hn::Set(d, 1.0 / (1.0 + a));
  const V factor = hn::Set(d, step.inertia_factor), over_factor = hn::Set(d, 1.0 / step.inertia_factor);
  Lanes3 centre, linear;
  Lanes33 turning;
  if (gains) load_gains(*gains, first, centre, linear, turning);
  MotionSums sum;
  Lanes3 origin = zeros();
  Lanes33 f = zero_matrix();
  int anchors = 0;
  if constexpr (kFrame) anchors = frame.anchor_count(columns);
  // After each store the compiler would load these pointers again, as the store might change them.
  double *const all_x = columns.x, *const all_v = columns.v;
  const double *const all_forces = columns.force, *const masses = columns.mass, *const over_masses = columns.over_mass;
  const double *const held_velocities = columns.held_v, *const arms = columns.arm;
  const int count = columns.node_count;
  for (int n = 0; n < count; ++n) {
    const int at = n * kLine + first;
    const Lanes3 x = load_line(all_x + at), v = load_line(all_v + at), force = load_line(all_forces + at);
    const V mass = hn::Load(d, masses + n * kLanes + first);
    const V dt_over_mass = hn::Mul(dt, hn::Load(d, over_masses + n * kLanes + first));
    Lanes3 driven = scaled(hn::Mul(dt_over_mass, over_factor), force);  // change of velocity
    if (gains) {
      const Lanes3 r = arms ? load_line(arms + at) : difference_of(x, centre);
      driven = sum_of(driven, sum_of(linear, times(turning, r)));
    }
    Lanes3 next, held_v;
    if constexpr (kNeeds.held) held_v = load_line(held_velocities + at);
    V free = hn::Zero(d);
    each_component([&](auto k) HWY_ATTR {
      V change = driven[k], brake = hn::Zero(d);
      auto hold = hn::FirstN(d, 0);
      if constexpr (kNeeds.held) hold = hn::Eq(held_v[k], held_v[k]);  // not NaN
      if constexpr (kNeeds.brakes) {
        if (step.gamma > 0.0) {
          const V relative = hn::Sub(v[k], hn::Set(d, step.ground[k]));
          brake = hn::Neg(local_damping(gamma, force[k], relative));
          change = hn::MulAdd(dt_over_mass, brake, change);
        }
        if (a > 0.0 && step.ground[k] != 0.0) change = hn::Add(change, hn::Set(d, 2.0 * a * step.ground[k]));
        next[k] = hn::Mul(over, hn::MulAdd(keep, v[k], change));
      } else {
        next[k] = hn::Add(v[k], change);
      }
      if constexpr (kNeeds.held) next[k] = hn::IfThenElse(hold, held_v[k], next[k]);
      if constexpr (kNeeds.measured) {
        const auto unless_held = [&](V y) HWY_ATTR { return kNeeds.held ? hn::IfThenZeroElse(hold, y) : y; };
        const V free_force = unless_held(force[k]);
        free = hn::MulAdd(free_force, free_force, free);
        sum.net[k] = hn::Add(sum.net[k], free_force);
        sum.kinetic = hn::MulAdd(unless_held(hn::Mul(mass, v[k])), next[k], sum.kinetic);
        if constexpr (kNeeds.energies) {
          const V mean = hn::Mul(hn::Set(d, 0.5), hn::Add(v[k], next[k]));
          const V viscous = hn::Mul(factor, hn::Mul(alpha, hn::Mul(mass, hn::Sub(mean, hn::Set(d, step.ground[k])))));
          V damped = unless_held(hn::Sub(viscous, brake));
          if (columns.viscous) damped = hn::Sub(damped, hn::Load(d, columns.viscous_force + at + k * kLanes));
          const V weight = hn::Mul(mass, hn::Set(d, step.weight_per_mass * step.gravity[k]));
          sum.add_work(damped, hn::IfThenElse(hold, hn::Sub(weight, force[k]), weight), v[k], next[k], dt);
        }
      }
    });
    if constexpr (kNeeds.measured) sum.unbalanced = larger_of(sum.unbalanced, free);
    const Lanes3 place = plus_scaled(x, dt, next);
    sum.positions = hn::Add(sum.positions, hn::Add(place.x, hn::Add(place.y, place.z)));
    store_line(place, all_x + at);
    store_line(next, all_v + at);
    if constexpr (kFrame) {
      if (n == 0) origin = place;
      if (n < anchors) add_outer(difference_of(place, origin), frame.anchor(n, first), f);
    }
  }
  store_vectors(columns.x, blocks, &LaneBlock::x, first, columns);
  if (step.velocities) store_vectors(columns.v, blocks, &LaneBlock::v, first, columns);
  if constexpr (kFrame) store_frames(blocks, first, f);
  sum.store(factor, first, sums);
}

template <class Frame>
HWY_INLINE void advance_all(std::span<const LaneBlock> blocks, const LaneColumns& columns, const RigidGains* gains,
                            const GridpointStep& step, const Frame& frame, GridpointSums* lanes) {
  const auto advance = [&](auto held, auto brakes) {
    for (int first = 0; first < static_cast<int>(blocks.size()); first += kWidth) {
      if (step.energies)
        advance_vector<Needs{held, true, true, true}>(blocks, columns, first, gains, step, frame, lanes);
      else if (step.measured)
        advance_vector<Needs{held, true, true, false}>(blocks, columns, first, gains, step, frame, lanes);
      else
        advance_vector<Needs{held, brakes, false, false}>(blocks, columns, first, gains, step, frame, lanes);
    }
  };
  const bool brakes = step.gamma > 0.0 || step.alpha > 0.0;
  if (columns.held_v)
    brakes ? advance(std::true_type(), std::true_type()) : advance(std::true_type(), std::false_type());
  else
    brakes ? advance(std::false_type(), std::true_type()) : advance(std::false_type(), std::false_type());
}

void AdvanceGridpoints(std::span<const LaneBlock> blocks, const LaneColumns& columns, const RigidGains* gains,
                       const GridpointStep& step, const CongruentBlocks* shared, BlockSums* sums) {
  GridpointSums lanes;
  if (!blocks.front().frame)
    advance_all(blocks, columns, gains, step, NoFrame{}, &lanes);
  else if (shared)
    advance_all(blocks, columns, gains, step, SharedFrame{*shared}, &lanes);
  else
    advance_all(blocks, columns, gains, step, OwnFrames{blocks, columns}, &lanes);
  for (std::size_t l = 0; l < blocks.size(); ++l) {
    BlockSums& s = sums[l];
    s.unbalanced = lanes.unbalanced[l];
    s.net = {lanes.net[0][l], lanes.net[1][l], lanes.net[2][l]};
    s.positions = lanes.positions[l];
    s.kinetic += lanes.kinetic[l];
    s.damping.before += lanes.damping[0][l], s.damping.after += lanes.damping[1][l];
    s.external.before += lanes.external[0][l], s.external.after += lanes.external[1][l];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace quoin::blocks {

HWY_EXPORT(LoadBlocks);
HWY_EXPORT(AddGridpointLines);
HWY_EXPORT(FixedFrameForces);
HWY_EXPORT(CongruentForces);
HWY_EXPORT(DistinctForces);
HWY_EXPORT(AdvanceGridpoints);

void LaneColumns::resize(int nodes, double* motion) {
  node_count = nodes;
  double** const columns[] = {&x, &v, &force, &viscous_force, &u, &weighted, &product, &elastic};
  const auto size = static_cast<std::size_t>(nodes) * kLine;
  memory_.resize(std::max(memory_.size(), std::size(columns) * size + kLine + size / 3));
  double* from = memory_.data();
  for (double** column : columns) *column = from, from += size;
  moment = from;
  rows = from + kLine;
  if (motion) x = motion, v = motion + size;
}

void load_blocks(std::span<const LaneBlock> blocks, const FixedColumns<const double>& fixed, const KeptMotion& kept,
                 LaneColumns* columns) {
  int most = 0, fewest = std::numeric_limits<int>::max();
  for (const LaneBlock& b : blocks) most = std::max(most, b.node_count), fewest = std::min(fewest, b.node_count);
  columns->resize(most, kept.memory);
  columns->fewest = fewest;
  columns->mass = fixed.mass, columns->over_mass = fixed.over_mass;
  columns->place = fixed.place, columns->anchor = fixed.anchor;
  columns->held_v = fixed.held_v;
  columns->arm = fixed.arm;
  HWY_DYNAMIC_DISPATCH(LoadBlocks)(blocks, !kept.is_current, columns);
}

LaneSums add_gridpoint_lines(std::span<const GridpointLine> lines, std::span<const RowLine> moments,
                             const FacetRow* rows, std::size_t count, LaneColumns* columns) {
  return HWY_DYNAMIC_DISPATCH(AddGridpointLines)(lines, moments, rows, count, columns);
}

void fixed_frame_forces(std::span<const FramedGroup> groups, const CongruentBlocks& congruent, const ZoneStep& step) {
  HWY_DYNAMIC_DISPATCH(FixedFrameForces)(groups, congruent, step);
}

void congruent_forces(std::span<const FramedGroup> groups, const CongruentBlocks& congruent, const ZoneStep& step) {
  HWY_DYNAMIC_DISPATCH(CongruentForces)(groups, congruent, step);
}

void distinct_forces(const FramedGroup& group, const ZoneStep& step) {
  HWY_DYNAMIC_DISPATCH(DistinctForces)(group, step);
}

void advance_gridpoints(std::span<const LaneBlock> blocks, const LaneColumns& columns, const RigidGains* gains,
                        const GridpointStep& step, const CongruentBlocks* shared, BlockSums* sums) {
  HWY_DYNAMIC_DISPATCH(AdvanceGridpoints)(blocks, columns, gains, step, shared, sums);
}

}  // namespace quoin::blocks

#endif  // HWY_ONCE
