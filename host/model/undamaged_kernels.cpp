#include "model/undamaged_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/undamaged_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE Lanes3 times(const Lanes3& a, const Lanes3& b) {
  return {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)};
}
// Cross product, without fused operations.
HWY_INLINE Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

struct Rotor {  // velocity v(r) = linear + angular x r; for sums, force and torque
  Lanes3 linear, angular;
};

HWY_INLINE void add_force(const Lanes3& force, const Lanes3& arm, Rotor* sums) {
  sums->linear = sum_of(sums->linear, force);
  sums->angular = sum_of(sums->angular, cross(arm, force));
}

HWY_INLINE V row_times(const double* row, const Lanes3& v) {
  const D d;
  return hn::Add(hn::Add(hn::Mul(hn::Set(d, row[0]), v.x), hn::Mul(hn::Set(d, row[1]), v.y)),
                 hn::Mul(hn::Set(d, row[2]), v.z));
}

HWY_INLINE void make_velocity(const RigidMotion& motion, Rotor* sums) {
  sums->linear = times(broadcast(motion.inverse_mass.data()), sums->linear);
  const double* j = motion.inverse_inertia.data();
  const Lanes3 torque = sums->angular;
  sums->angular = {row_times(j, torque), row_times(j + 3, torque), row_times(j + 6, torque)};
}

HWY_INLINE Lanes3 velocity(const Rotor& motion, const Lanes3& arm) {
  return sum_of(motion.linear, cross(motion.angular, arm));
}

struct UnitView {
  const BlockGroup* group;
  const BrickTemplate* shape[kUnitBlocks];
  const RigidMotion* block[kUnitBlocks] = {};
  const RigidMotion* whole = nullptr;
  int count;

  UnitView(const Model& model, const UnitGroup& unit, const MotionScaling& scaling)
      : group(&model.groups[static_cast<std::size_t>(unit.first_group)]), count(unit.group_count) {
    for (int b = 0; b < count; ++b) {
      shape[b] = &model.templates[static_cast<std::size_t>(group[b].brick_template)];
      if (scaling.rigid) block[b] = &scaling.rigid->block[static_cast<std::size_t>(unit.first_group + b)];
    }
    if (scaling.rigid) whole = &scaling.rigid->unit[static_cast<std::size_t>(&unit - model.unit_groups.data())];
  }

  // Arms of gridpoint n of block b from the centre of its unit and of its block.
  HWY_INLINE void arms(int b, int n, Lanes3* of_unit, Lanes3* of_block) const {
    const Vec3& node = shape[b]->node[static_cast<std::size_t>(n)];
    const Vec3& offset = group[b].offset;
    double u[3], v[3];
    for (std::size_t c = 0; c < 3; ++c) {
      const double place = node[c] + offset[c];
      u[c] = place - whole->centre[c];
      v[c] = place - (block[b]->centre[c] + offset[c]);
    }
    *of_unit = broadcast(u);
    *of_block = broadcast(v);
  }
};

// Scales the motion of the gridpoints of a unit in order, for one vector of lanes. get(i) returns the three components
// at offset i, put(i, components) stores the scaled ones.
template <class Get, class Put>
HWY_INLINE void scale_lanes(const UnitView& unit, const MotionScaling& scaling, int lane, Get get, Put put) {
  const D d;
  const Lanes3 zero = zeros();
  Rotor whole{zero, zero}, part[kUnitBlocks] = {{zero, zero}, {zero, zero}};
  for (int b = 0; b < unit.count; ++b) {
    for (int n = 0; n < unit.shape[b]->node_count; ++n) {
      const int line = unit.group[b].first_line + n;
      Lanes3 of_unit, of_block;
      unit.arms(b, n, &of_unit, &of_block);
      const V root = hn::LoadU(d, scaling.node_root_mass + line * kLanes + lane);
      const Lanes3 force = scaled(root, get(line * kLine + lane));
      add_force(force, of_unit, &whole);
      add_force(force, of_block, &part[b]);
    }
    make_velocity(*unit.block[b], &part[b]);
  }
  make_velocity(*unit.whole, &whole);
  const V of_deformation = hn::Set(d, scaling.of_deformation);
  const V of_part = hn::Set(d, scaling.of_unit - scaling.of_deformation), of_whole = hn::Set(d, 1.0 - scaling.of_unit);
  for (int b = 0; b < unit.count; ++b) {
    for (int n = 0; n < unit.shape[b]->node_count; ++n) {
      const int line = unit.group[b].first_line + n;
      Lanes3 of_unit, of_block;
      unit.arms(b, n, &of_unit, &of_block);
      const V root = hn::LoadU(d, scaling.node_root_mass + line * kLanes + lane);
      const Lanes3 block = scaled(root, velocity(part[b], of_block)), rigid = scaled(root, velocity(whole, of_unit));
      const int i = line * kLine + lane;
      put(i, sum_of(sum_of(scaled(of_deformation, get(i)), scaled(of_part, block)), scaled(of_whole, rigid)));
    }
  }
}

void ScaleMotionThen(const Model& model, const UnitGroup& unit_group, const MotionScaling& scaling,
                     const double* HWY_RESTRICT diagonal, const double* HWY_RESTRICT x, double* HWY_RESTRICT y) {
  const UnitView unit(model, unit_group, scaling);
  const auto get = [&](int i) HWY_ATTR { return load_line(x + i); };
  const auto put = [&](int i, const Lanes3& v) HWY_ATTR { store_line(times(v, load_line(diagonal + i)), y + i); };
  for (int lane = 0; lane < kLanes; lane += kWidth) {
    if (scaling.rigid) {
      scale_lanes(unit, scaling, lane, get, put);
      continue;
    }
    for (int b = 0; b < unit.count; ++b) {
      for (int n = 0; n < unit.shape[b]->node_count; ++n) {
        const int i = (unit.group[b].first_line + n) * kLine + lane;
        put(i, get(i));
      }
    }
  }
}

double ScaleMotionAfter(const Model& model, const UnitGroup& unit_group, const MotionScaling& scaling,
                        const double* HWY_RESTRICT diagonal, double sum, const double* HWY_RESTRICT x,
                        double* HWY_RESTRICT y) {
  const UnitView unit(model, unit_group, scaling);
  const auto get = [&](int i) HWY_ATTR { return times(load_line(y + i), load_line(diagonal + i)); };
  const auto put = [&](int i, const Lanes3& v) HWY_ATTR { store_line(v, y + i); };
  for (int lane = 0; scaling.rigid && lane < kLanes; lane += kWidth) scale_lanes(unit, scaling, lane, get, put);
  for (int b = 0; b < unit.count; ++b) {
    for (int n = 0; n < unit.shape[b]->node_count; ++n) {
      const int first = (unit.group[b].first_line + n) * kLine;
      for (int lane = 0; !scaling.rigid && lane < kLanes; lane += kWidth) put(first + lane, get(first + lane));
      for (int i = first; i < first + kLine; ++i) sum += y[i] * x[i];
    }
  }
  return sum;
}

// kCount groups of one template share the loads of the coefficients; their independent sums hide latency.
template <int kCount>
HWY_INLINE void zones_of(const BrickTemplate& shape, const BlockGroup* group, const double* HWY_RESTRICT u,
                         double* HWY_RESTRICT f) {
  const D d;
  const std::int32_t* column = shape.stiffness.column.data();
  const std::int32_t* columns = column;
  const double* coefficient = shape.stiffness.coefficient.data();
  const double* from[kCount];
  double* to[kCount];
  for (int b = 0; b < kCount; ++b) {
    from[b] = u + group[b].first_line * kLine;
    to[b] = f + group[b].first_line * kLine;
  }
  for (int n = 0; n < shape.node_count; ++n) {
    V sum[kCount][3][kParts];
    for (auto& of_group : sum) {
      for (auto& of_component : of_group) {
        for (V& s : of_component) s = hn::Zero(d);
      }
    }
    for (const std::int32_t* end = columns + shape.stiffness.column_end[static_cast<std::size_t>(n)]; column < end;
         ++column, coefficient += 3) {
      const V k[3] = {hn::Set(d, coefficient[0]), hn::Set(d, coefficient[1]), hn::Set(d, coefficient[2])};
      for (int b = 0; b < kCount; ++b) {
        for (int p = 0; p < kParts; ++p) {
          const V x = hn::LoadU(d, from[b] + *column + p * kWidth);
          for (int c = 0; c < 3; ++c) sum[b][c][p] = hn::Add(sum[b][c][p], hn::Mul(k[c], x));
        }
      }
    }
    for (int b = 0; b < kCount; ++b) {
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) hn::StoreU(sum[b][c][p], d, to[b] + n * kLine + c * kLanes + p * kWidth);
      }
    }
  }
}

void ZoneStiffness(const Model& model, const UnitGroup& unit, const double* u, double* f) {
  const BlockGroup* group = &model.groups[static_cast<std::size_t>(unit.first_group)];
  const auto shape = [&](int b) -> const BrickTemplate& {
    return model.templates[static_cast<std::size_t>(group[b].brick_template)];
  };
  if (unit.group_count == 2 && group[0].brick_template == group[1].brick_template) {
    zones_of<2>(shape(0), group, u, f);
    return;
  }
  for (int b = 0; b < unit.group_count; ++b) zones_of<1>(shape(b), group + b, u, f);
}

template <class Tag>
HWY_INLINE void spring(Tag d, int a, int b, hn::Vec<Tag> stiffness, const double* u, double* f) {
  const auto force = hn::Mul(stiffness, hn::Sub(hn::LoadU(d, u + b), hn::LoadU(d, u + a)));
  hn::StoreU(hn::Sub(hn::LoadU(d, f + a), force), d, f + a);
  hn::StoreU(hn::Add(hn::LoadU(d, f + b), force), d, f + b);
}

template <class Tag>
HWY_INLINE void springs_of(Tag d, const Model& model, const SpringRun& run, std::size_t point, const double* u,
                           double* f) {
  const auto area = hn::LoadU(d, model.area.data() + point);
  const auto normal = hn::Mul(hn::Set(d, run.normal_stiffness), area);
  const auto shear = hn::Mul(hn::Set(d, run.shear_stiffness), area);
  for (int c = 0; c < 3; ++c) {
    spring(d, model.node_a[point] + c * kLanes, model.node_b[point] + c * kLanes, c == run.axis ? normal : shear, u, f);
  }
}

void AddSprings(const Model& model, const SpringRun& run, const double* u, double* f) {
  auto i = static_cast<std::size_t>(run.first_point);
  const std::size_t end = i + static_cast<std::size_t>(run.point_count);
  while (i < end) {
    // Gridpoints are consecutive, so they belong to one face of blocks, and no two are the same.
    if (model.point_run[i] >= kWidth && i + kWidth <= end) {
      springs_of(D(), model, run, i, u, f);
      i += kWidth;
    } else {
      springs_of(hn::CappedTag<double, 1>(), model, run, i, u, f);
      ++i;
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin {

HWY_EXPORT(ScaleMotionThen);
HWY_EXPORT(ScaleMotionAfter);
HWY_EXPORT(ZoneStiffness);
HWY_EXPORT(AddSprings);

void scale_motion_then(const Model& model, const UnitGroup& unit, const MotionScaling& scaling, const double* diagonal,
                       const double* x, double* y) {
  HWY_DYNAMIC_DISPATCH(ScaleMotionThen)(model, unit, scaling, diagonal, x, y);
}
double scale_motion_after(const Model& model, const UnitGroup& unit, const MotionScaling& scaling,
                          const double* diagonal, double sum, const double* x, double* y) {
  return HWY_DYNAMIC_DISPATCH(ScaleMotionAfter)(model, unit, scaling, diagonal, sum, x, y);
}
void zone_stiffness(const Model& model, const UnitGroup& unit, const double* u, double* f) {
  HWY_DYNAMIC_DISPATCH(ZoneStiffness)(model, unit, u, f);
}
void add_springs(const Model& model, const SpringRun& run, const double* u, double* f) {
  HWY_DYNAMIC_DISPATCH(AddSprings)(model, run, u, f);
}

}  // namespace quoin
#endif
