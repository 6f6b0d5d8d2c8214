#include "step/contact_kernels.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/contact_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

// ---- On triangles --------------------------------------------------------------------------------------------------

static_assert(FacetLanes::kCount == kLanes);

HWY_INLINE Lanes3 columns_of(const double (&of)[3][kLanes], int first) {
  return {hn::Load(D(), of[0] + first), hn::Load(D(), of[1] + first), hn::Load(D(), of[2] + first)};
}
HWY_INLINE void keep(const Lanes3& a, double (&in)[3][kLanes], int first) {
  for (int k = 0; k < 3; ++k) hn::Store(a[k], D(), in[k] + first);
}

// Positions of the corners of triangles.
HWY_INLINE void corners_of(const std::int32_t (&node)[3][kLanes], int first, const Vector* x, Lanes3 (&corner)[3]) {
  for (int k = 0; k < 3; ++k) corner[k] = load_vectors([&](int l) { return &x[node[k][first + l]].x; });
}

HWY_INLINE Lanes3 weighted(const Lanes3& weight, const Lanes3 (&corner)[3]) {
  return plus_scaled(plus_scaled(scaled(weight.x, corner[0]), weight.y, corner[1]), weight.z, corner[2]);
}

void FacetJumps(std::span<FacetLanes> all, FacetFrames* frames, const Vector* node_x, const PointColumns& c,
                bool fixed) {
  const D d;
  const V one = hn::Set(d, 1.0);
  for (FacetLanes& lanes : all) {
    FacetFrames& frame = *frames++;
    for (int first = 0; first < static_cast<int>(lanes.count); first += kWidth) {
      const FirstLanes part{static_cast<int>(lanes.count) - first};
      const std::size_t i = lanes.first + static_cast<std::size_t>(first);
      Lanes3 a[3], at;
      corners_of(lanes.node_a, first, node_x, a);
      if (lanes.on_gridpoints) {
        at = load_vectors([&](int l) { return &node_x[lanes.node_b[0][first + l]].x; });
      } else {
        Lanes3 b[3];
        corners_of(lanes.node_b, first, node_x, b);
        at = weighted(columns_of(lanes.weight_b, first), b);
      }
      const Lanes3 weight_a = columns_of(lanes.weight_a, first);
      const Lanes3 apart = difference_of(at, weighted(weight_a, a));
      Lanes3 n, s, t, slope;
      if (fixed) {
        n = columns_of(frame.n, first), s = columns_of(frame.s, first), t = columns_of(frame.t, first);
      } else {
        const Lanes3 e2 = difference_of(a[1], a[0]), e3 = difference_of(a[2], a[0]), across = cross_of(e2, e3);
        const V length = hn::Sqrt(dot_of(e2, e2)), over_length = hn::Div(one, length);
        const V over_area = hn::Div(one, hn::Sqrt(dot_of(across, across)));
        s = scaled(over_length, e2), n = scaled(over_area, across), t = cross_of(n, s);
        const V over_height = hn::Mul(length, over_area);
        slope = {over_length, hn::Neg(hn::Mul(hn::Mul(dot_of(s, e3), over_length), over_height)), over_height};
        keep(n, frame.n, first), keep(s, frame.s, first), keep(t, frame.t, first), keep(slope, frame.slope, first);
      }
      part.store(hn::Sub(dot_of(n, apart), hn::Load(d, lanes.reference + first)), c.normal_jump + i);
      const V place[2] = {dot_of(s, apart), dot_of(t, apart)};
      for (int k = 0; k < 2; ++k) {
        part.store(hn::Sub(place[k], part.load(c.slid[k] + i)), c.slip[k] + i);
        part.store(fixed ? place[k] : hn::Zero(d), c.slid[k] + i);
      }
      if (fixed) continue;
      const V of_1 = hn::MulAdd(slope.y, place[1], hn::Mul(slope.x, place[0])), of_2 = hn::Mul(slope.z, place[1]);
      keep(sum_of(weight_a, {hn::Neg(hn::Add(of_1, of_2)), of_1, of_2}), lanes.weight_a, first);
    }
  }
}

void FacetForces(std::span<const FacetLanes> all, const FacetFrames* frames, const PointColumns& c, FacetRow* rows) {
  const D d;
  for (const FacetLanes& lanes : all) {
    const FacetFrames& frame = *frames++;
    for (int first = 0; first < static_cast<int>(lanes.count); first += kWidth) {
      const FirstLanes part{static_cast<int>(lanes.count) - first};
      const std::size_t i = lanes.first + static_cast<std::size_t>(first);
      const V area = hn::Load(d, lanes.area + first);
      V f[3];
      for (int k = 0; k < 3; ++k) {
        f[k] = part.load(c.traction[k] + i);
        if (c.viscous[0]) f[k] = hn::Add(f[k], part.load(c.viscous[k] + i));
        f[k] = hn::Mul(area, f[k]);
      }
      const Lanes3 n = columns_of(frame.n, first);
      const Lanes3 force =
          plus_scaled(plus_scaled(scaled(f[0], n), f[1], columns_of(frame.s, first)), f[2], columns_of(frame.t, first));
      const V gap = hn::Add(part.load(c.normal_jump + i), hn::Load(d, lanes.reference + first));
      const Lanes3 slope = columns_of(frame.slope, first);
      const V of_1 = hn::Neg(hn::Mul(gap, hn::MulAdd(slope.y, f[2], hn::Mul(slope.x, f[1]))));
      const V of_2 = hn::Neg(hn::Mul(gap, hn::Mul(slope.z, f[2])));
      FacetRow* const row = rows + lanes.row + FacetRow::kCount * first;
      const auto put = [&](const Lanes3& on_a, int k) HWY_ATTR {
        const V column[kFour] = {on_a.x, on_a.y, on_a.z, hn::Zero(d)};
        for_rows(column, std::min(kWidth, part.count), [&](int l, int at, F four) HWY_ATTR {
          hn::StoreU(four, Four(), row[FacetRow::kCount * l + k].force + at);
        });
      };
      put(force, 0);
      put(plus_scaled(scaled(hn::Load(d, lanes.weight_a[1] + first), force), of_1, n), 1);
      put(plus_scaled(scaled(hn::Load(d, lanes.weight_a[2] + first), force), of_2, n), 2);
    }
  }
}

Vector AddFacetRows(const FacetTouches& touches, const FacetRow* rows, double* force) {
  const Four d;
  F sum[kFour / kPart];
  for (F& s : sum) s = hn::Zero(d);
  const auto add = [&](std::int32_t node, int c, F f) HWY_ATTR {
    double* const at = force + kFour * node + c;
    hn::StoreU(hn::Add(hn::LoadU(d, at), f), d, at);
  };
  for (const OwnerTouch& touch : touches.owner) {
    const FacetRow* const row = rows + touch.row;
    for (int c = 0; c < kFour; c += kPart) {
      const F all = hn::LoadU(d, row[0].force + c), of_1 = hn::LoadU(d, row[1].force + c);
      const F of_2 = hn::LoadU(d, row[2].force + c);
      sum[c / kPart] = hn::Add(sum[c / kPart], all);
      add(touch.node[0], c, hn::Sub(all, hn::Add(of_1, of_2)));
      add(touch.node[1], c, of_1);
      add(touch.node[2], c, of_2);
    }
  }
  for (const CarrierTouch& touch : touches.carrier) {
    for (int c = 0; c < kFour; c += kPart) {
      const F all = hn::LoadU(d, rows[touch.row].force + c);
      sum[c / kPart] = hn::Sub(sum[c / kPart], all);
      for (int k = 0; k < 3; ++k) add(touch.node[k], c, hn::Mul(hn::Set(d, -touch.weight[k]), all));
    }
  }
  const auto add_on_gridpoints = [&](std::span<const GridpointTouch> sides, bool is_a) HWY_ATTR {
    for (const GridpointTouch& touch : sides) {
      for (int c = 0; c < kFour; c += kPart) {
        const F on_a = hn::LoadU(d, rows[touch.row].force + c), here = is_a ? on_a : hn::Neg(on_a);
        sum[c / kPart] = hn::Add(sum[c / kPart], here);
        add(touch.node, c, here);
      }
    }
  };
  add_on_gridpoints(touches.gridpoint, false);
  add_on_gridpoints(touches.owner_gridpoint, true);
  double total[kFour];
  for (int c = 0; c < kFour; c += kPart) hn::StoreU(sum[c / kPart], d, total + c);
  return {total[0], total[1], total[2]};
}

// ---- On gridpoints, pair by pair -----------------------------------------------------------------------------------

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

HWY_EXPORT(FacetJumps);
HWY_EXPORT(FacetForces);
HWY_EXPORT(AddFacetRows);

void facet_jumps(std::span<FacetLanes> lanes, FacetFrames* frames, const Vector* node_x, const PointColumns& columns,
                 bool fixed) {
  HWY_DYNAMIC_DISPATCH(FacetJumps)(lanes, frames, node_x, columns, fixed);
}

void facet_forces(std::span<const FacetLanes> lanes, const FacetFrames* frames, const PointColumns& columns,
                  FacetRow* rows) {
  HWY_DYNAMIC_DISPATCH(FacetForces)(lanes, frames, columns, rows);
}

Vector add_facet_rows(const FacetTouches& touches, const FacetRow* rows, double* force) {
  return HWY_DYNAMIC_DISPATCH(AddFacetRows)(touches, rows, force);
}

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
