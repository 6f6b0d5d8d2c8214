#include "step/gridpoint_kernels.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/gridpoint_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

// Computes the axes of a pair in space: sums of the columns of R.
HWY_INLINE void turn_axes(const BlockFrame& frame, const GridpointPair& pair, PairAxes& axes) {
  const Four d;
  for (int k = 0; k < 3; ++k) {
    const Vector& axis = pair.axis[k];
    for (int c = 0; c < kFour; c += kPart) {
      // The fourth double after the last row is that of another matrix.
      const auto column = [&](int j) HWY_ATTR { return hn::LoadU(d, &frame.transposed_r.row[j].x + c); };
      const F sum = hn::MulAdd(hn::Set(d, axis.x), column(0),
                               hn::MulAdd(hn::Set(d, axis.y), column(1), hn::Mul(hn::Set(d, axis.z), column(2))));
      hn::StoreU(sum, d, axes.axis[k] + c);
    }
  }
}

HWY_INLINE Lanes33 broadcast_matrix(const geometry::Matrix& m) {
  return {{broadcast(&m.row[0].x), broadcast(&m.row[1].x), broadcast(&m.row[2].x)}};
}

// Positions of gridpoints, from node[0] on; lanes beyond the part have any of them.
HWY_INLINE Lanes3 places_of(const geometry::Vector* x, const std::int32_t* node, const FirstLanes& part) {
  if (part.count >= kWidth) return load_vectors([&](int l) { return &x[node[l]].x; });
  if (part.count == 1) return broadcast(&x[*node].x);  // joints with 9 points leave one to the last vector
  return load_vectors([&](int l) { return &x[node[l < part.count ? l : 0]].x; });
}

void GridpointJumps(std::span<const GridpointPair> pairs, PairAxes* axes, const BlockPlaces& places,
                    const GridpointColumns& columns) {
  const GridpointColumns c = columns;  // else the compiler would load it again after each store
  const geometry::Vector* const x = places.node_x;
  for (const GridpointPair& pair : pairs) {
    PairAxes& of_pair = *axes++;
    if (places.frames) turn_axes(places.frames[pair.a], pair, of_pair);
    const Lanes3 n = broadcast(of_pair.axis[0]), s = broadcast(of_pair.axis[1]), t = broadcast(of_pair.axis[2]);
    const std::uint32_t end = pair.first + pair.count;
    for (std::uint32_t i = pair.first; i < end; i += kWidth) {
      const FirstLanes part{static_cast<int>(end - i)};
      Lanes3 at_b;
      if (pair.has_body()) {
        const Body& b = places.bodies[pair.body_b];
        const Lanes3 arm{part.load(c.arm[0] + i), part.load(c.arm[1] + i), part.load(c.arm[2] + i)};
        at_b = sum_of(broadcast(&b.x.x), times(broadcast_matrix(b.r), arm));
      } else {
        at_b = places_of(x, c.node_b + (i - c.first), part);
      }
      const Lanes3 apart = difference_of(at_b, places_of(x, c.node_a + (i - c.first), part));
      part.store(hn::Sub(dot_of(n, apart), part.load(c.offset + i)), c.normal_jump + i);
      const V place[2] = {dot_of(s, apart), dot_of(t, apart)};
      for (int k = 0; k < 2; ++k) {
        part.store(hn::Sub(place[k], part.load(c.slid[k] + i)), c.slip[k] + i);
        part.store(place[k], c.slid[k] + i);
      }
    }
  }
}

// Sums of three numbers over eight lanes, as a tree that is the same for vectors of any width.
struct LaneTree {
  V of[3][kParts];
  HWY_INLINE LaneTree() {
    for (auto& parts : of) std::fill(parts, parts + kParts, hn::Zero(D()));
  }
  HWY_INLINE void add(int part, const Lanes3& x) {
    for (int k = 0; k < 3; ++k) of[k][part] = hn::Add(of[k][part], x[k]);
  }
  HWY_INLINE Vector sum() const {
    alignas(64) double lane[3][kLanes];
    for (int k = 0; k < 3; ++k) {
      for (int p = 0; p < kParts; ++p) hn::Store(of[k][p], D(), lane[k] + p * kWidth);
    }
    Vector sum;
    for (int k = 0; k < 3; ++k) {
      const double* const x = lane[k];
      sum[k] = ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]));
    }
    return sum;
  }
};

HWY_INLINE void store_vector(const Vector& x, FacetRow& row) { row = {{x.x, x.y, x.z, 0.0}}; }

// A pair's forces. kBody: on a rigid block b; kTurns: the axes turn.
template <bool kBody, bool kTurns>
HWY_INLINE void forces_of(const GridpointPair& pair, const PairAxes& axes, const Body* bodies,
                          const GridpointColumns& c, FacetRow* rows) {
  const auto& in_space = axes.axis;
  const Lanes3 n = broadcast(in_space[0]), s = broadcast(in_space[1]), t = broadcast(in_space[2]);
  const std::uint32_t end = pair.first + pair.count;
  LaneTree moment, on_body, torque;
  Lanes33 turn;
  if constexpr (kBody) turn = broadcast_matrix(bodies[pair.body_b].r);
  int p = 0;
  for (std::uint32_t i = pair.first; i < end; i += kWidth, p = (p + 1) % kParts) {
    const FirstLanes part{static_cast<int>(end - i)};
    const V area = part.load(c.area + i);
    V f[3];
    for (int k = 0; k < 3; ++k) {
      f[k] = part.load(c.traction[k] + i);
      if (c.viscous[0]) f[k] = hn::Add(f[k], part.load(c.viscous[k] + i));
      f[k] = hn::Mul(area, f[k]);
    }
    const Lanes3 force = plus_scaled(plus_scaled(scaled(f[0], n), f[1], s), f[2], t);
    const V column[kFour] = {force.x, force.y, force.z, hn::Zero(D())};
    FacetRow* const row = rows + pair.row + (i - pair.first);
    const auto store = [&](int l, int at, F four) HWY_ATTR { hn::StoreU(four, Four(), row[l].force + at); };
    part.count >= kWidth ? for_rows(column, kWidth, store) : for_rows(column, part.count, store);
    if constexpr (kBody) {
      const Lanes3 arm{part.load(c.arm[0] + i), part.load(c.arm[1] + i), part.load(c.arm[2] + i)};
      on_body.add(p, force);
      torque.add(p, cross_of(times(turn, arm), force));
    }
    if constexpr (kTurns) {
      const Lanes3 apart{hn::Add(part.load(c.normal_jump + i), part.load(c.offset + i)), part.load(c.slid[0] + i),
                         part.load(c.slid[1] + i)};
      moment.add(p, cross_of(apart, {f[0], f[1], f[2]}));  // along n, s, t
    }
  }
  if constexpr (kTurns) {
    const Vector sum = moment.sum();
    Vector turned;
    for (int k = 0; k < 3; ++k) turned += sum[k] * Vector{in_space[k][0], in_space[k][1], in_space[k][2]};
    store_vector(turned, rows[pair.sums]);
  }
  if constexpr (kBody) {
    store_vector(-on_body.sum(), rows[pair.sums + 1]);
    store_vector(-torque.sum(), rows[pair.sums + 2]);
  }
}

void GridpointForces(std::span<const GridpointPair> pairs, const PairAxes* axes, const BlockPlaces& places,
                     const GridpointColumns& columns, FacetRow* rows) {
  const GridpointColumns c = columns;  // as in GridpointJumps
  for (const GridpointPair& pair : pairs) {
    const PairAxes& of_pair = *axes++;
    if (pair.has_body())
      places.frames ? forces_of<true, true>(pair, of_pair, places.bodies, c, rows)
                    : forces_of<true, false>(pair, of_pair, places.bodies, c, rows);
    else
      places.frames ? forces_of<false, true>(pair, of_pair, places.bodies, c, rows)
                    : forces_of<false, false>(pair, of_pair, places.bodies, c, rows);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace quoin::blocks {

HWY_EXPORT(GridpointJumps);
HWY_EXPORT(GridpointForces);

void gridpoint_jumps(std::span<const GridpointPair> pairs, PairAxes* axes, const BlockPlaces& places,
                     const GridpointColumns& columns) {
  HWY_DYNAMIC_DISPATCH(GridpointJumps)(pairs, axes, places, columns);
}

void gridpoint_forces(std::span<const GridpointPair> pairs, const PairAxes* axes, const BlockPlaces& places,
                      const GridpointColumns& columns, FacetRow* rows) {
  HWY_DYNAMIC_DISPATCH(GridpointForces)(pairs, axes, places, columns, rows);
}

}  // namespace quoin::blocks

#endif  // HWY_ONCE
