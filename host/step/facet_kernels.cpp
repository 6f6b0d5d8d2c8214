#include "step/facet_kernels.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/facet_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

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

}  // namespace quoin::blocks

#endif  // HWY_ONCE
