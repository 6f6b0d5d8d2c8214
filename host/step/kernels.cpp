#include "step/kernels.h"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A line of 8 lanes is kParts vectors of kWidth.
using D = hn::CappedTag<double, kLanes>;
using V = hn::Vec<D>;
constexpr int kWidth = static_cast<int>(hn::MaxLanes(D()));
constexpr int kParts = kLanes / kWidth;

// Up to so many blocks of a group are cheaper one by one (benchmarks/README.md). It must not depend on the instruction
// set: the two ways differ in the last bits.
constexpr int kFewBlocks = 1;

// base[index[i]] for the next lanes of a tag. On AVX2 machines the gather instruction is slower than the loads that it
// stands for (a third of the time of a chunk's jumps on Zen 3), with AVX-512 it is faster.
template <class Tag>
HWY_INLINE hn::Vec<Tag> gather(Tag d, const double* base, const std::int32_t* index) {
#if HWY_TARGET == HWY_AVX2
  if constexpr (hn::MaxLanes(Tag()) == 4) {
    return hn::Vec<Tag>{_mm256_set_pd(base[index[3]], base[index[2]], base[index[1]], base[index[0]])};
  }
#endif
  const hn::Rebind<std::int64_t, Tag> wide;
  const hn::Rebind<std::int32_t, Tag> narrow;
  return hn::GatherIndex(d, base, hn::PromoteTo(wide, hn::LoadU(narrow, index)));
}

// ---- Contact points ------------------------------------------------------------------------------------------------

template <class Tag>
HWY_INLINE void jumps_of(Tag d, const Model& model, const ContactChunk& chunk, const StepData& step, int i,
                         ChunkJumps* jumps) {
  const std::int32_t* a = model.node_a.data() + chunk.first_point + i;
  const std::int32_t* b = model.node_b.data() + chunk.first_point + i;
  const int n = kLanes * chunk.axis, s = kLanes * ((chunk.axis + 1) % 3), t = kLanes * ((chunk.axis + 2) % 3);
  const auto dt = hn::Set(d, step.time_step);
  // Gridpoints side by side in memory, as a regular wall has them, need no gathers.
  const bool side_by_side = model.point_run[static_cast<std::size_t>(chunk.first_point + i)] >= hn::Lanes(d);
  const auto jump = [&](const double* field) {
    if (side_by_side) return hn::Sub(hn::LoadU(d, field + *b), hn::LoadU(d, field + *a));
    return hn::Sub(gather(d, field, b), gather(d, field, a));
  };
  auto normal = jump(step.displacement + n);
  if (step.normal_shift) normal = hn::Add(normal, hn::LoadU(d, step.normal_shift + chunk.first_point + i));
  hn::StoreU(normal, d, jumps->normal + i);
  hn::StoreU(hn::Mul(jump(step.velocity + s), dt), d, jumps->slip_s + i);
  hn::StoreU(hn::Mul(jump(step.velocity + t), dt), d, jumps->slip_t + i);
}

void ContactJumps(const Model& model, const ContactChunk& chunk, const StepData& step, ChunkJumps* jumps) {
  int i = 0;
  for (; i + kWidth <= chunk.point_count; i += kWidth) jumps_of(D(), model, chunk, step, i, jumps);
  for (; i < chunk.point_count; ++i) jumps_of(hn::CappedTag<double, 1>(), model, chunk, step, i, jumps);
}

template <class Tag>
HWY_INLINE void forces_of(Tag d, const Model& model, const ContactChunk& chunk, const StepData& step, int i) {
  const auto area = hn::LoadU(d, model.area.data() + i);
  for (int k = 0; k < 3; ++k) {
    hn::StoreU(hn::Mul(hn::LoadU(d, step.traction[k] + i), area), d, step.force[(chunk.axis + k) % 3] + i);
  }
}

void ContactForces(const Model& model, const ContactChunk& chunk, const StepData& step) {
  const int end = chunk.first_point + chunk.point_count;
  int i = chunk.first_point;
  for (; i + kWidth <= end; i += kWidth) forces_of(D(), model, chunk, step, i);
  for (; i < end; ++i) forces_of(hn::CappedTag<double, 1>(), model, chunk, step, i);
}

// ---- Deformable blocks ---------------------------------------------------------------------------------------------

// Walks the rows of a template: next() gives K w of the next gridpoint. Even and odd columns are summed apart, so that
// there are enough independent multiply-adds to hide the latency of one.
struct StiffnessRows {
  explicit StiffnessRows(const BrickTemplate& shape)
      : column(shape.column.data()),
        columns(column),
        column_end(shape.column_end.data()),
        coefficient(shape.coefficient.data()) {}

  HWY_INLINE void next(const double* w, V (&f)[3][kParts]) {
    const D d;
    V odd[3][kParts];
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) f[c][p] = odd[c][p] = hn::Zero(d);
    }
    const auto add = [&](const double* x, const double* k, V(&sum)[3][kParts]) HWY_ATTR {
      V part[kParts];
      for (int p = 0; p < kParts; ++p) part[p] = hn::Load(d, x + p * kWidth);
      for (int c = 0; c < 3; ++c) {
        const V factor = hn::Set(d, k[c]);
        for (int p = 0; p < kParts; ++p) sum[c][p] = hn::MulAdd(factor, part[p], sum[c][p]);
      }
    };
    for (const std::int32_t* end = columns + *column_end++; column < end; column += 2, coefficient += 6) {
      add(w + column[0], coefficient, f);
      add(w + column[1], coefficient + 3, odd);
    }
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) f[c][p] = hn::Add(f[c][p], odd[c][p]);
    }
  }

  const std::int32_t* column;
  const std::int32_t* columns;
  const std::int32_t* column_end;
  const double* coefficient;
};

// K w zone by zone for the blocks of a group, one after the other: f = V sigma grad N at each corner.
HWY_NOINLINE void zone_forces(const BrickTemplate& shape, int block_count, const double* w, double* f) {
  std::memset(f, 0, sizeof(double) * static_cast<std::size_t>(shape.node_count) * kLine);
  for (int lane = 0; lane < block_count; ++lane) {
    for (const Zone& zone : shape.zone) {
      double gradient[3][3] = {};  // d w_c / d x_k
      for (std::size_t a = 0; a < 4; ++a) {
        const double* at = w + zone.node[a] * kLine + lane;
        const Vec3& shape_gradient = zone.shape_gradient[a];
        for (std::size_t c = 0; c < 3; ++c) {
          for (std::size_t k = 0; k < 3; ++k) gradient[c][k] += at[c * kLanes] * shape_gradient[k];
        }
      }
      const double pressure = shape.lambda * (gradient[0][0] + gradient[1][1] + gradient[2][2]);
      double stress[3][3];  // times volume
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < 3; ++k)
          stress[c][k] = zone.volume * shape.shear_modulus * (gradient[c][k] + gradient[k][c]);
        stress[c][c] += zone.volume * pressure;
      }
      for (std::size_t a = 0; a < 4; ++a) {
        double* at = f + zone.node[a] * kLine + lane;
        const Vec3& shape_gradient = zone.shape_gradient[a];
        for (std::size_t c = 0; c < 3; ++c) {
          at[c * kLanes] +=
              stress[c][0] * shape_gradient[0] + stress[c][1] * shape_gradient[1] + stress[c][2] * shape_gradient[2];
        }
      }
    }
  }
}

// K w of a group, gridpoint by gridpoint: from the template, or from what zone_forces left in lane layout.
class InternalForceRows {
 public:
  InternalForceRows(const BrickTemplate& shape, const double* w, const double* by_zone)
      : rows_(shape), w_(w), by_zone_(by_zone) {}

  HWY_INLINE void next(V (&f)[3][kParts]) {
    if (!by_zone_) return rows_.next(w_, f);
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) f[c][p] = hn::Load(D(), by_zone_ + c * kLanes + p * kWidth);
    }
    by_zone_ += kLine;
  }

 private:
  StiffnessRows rows_;
  const double* w_;
  const double* by_zone_;
};

// Sums lanes 0 .. 7 in this order.
HWY_INLINE double sum_lanes(const V (&x)[kParts]) {
  alignas(64) double lane[kLanes];
  for (int p = 0; p < kParts; ++p) hn::Store(x[p], D(), lane + p * kWidth);
  double sum = 0.0;
  for (double value : lane) sum += value;
  return sum;
}

// Columns of scratch, in lane layout: what the two or three passes over a group hand on.
struct GroupScratch {
  GroupScratch(double* memory, int doubles)
      : net(memory),
        weighted(memory + doubles),
        elastic(memory + 2 * doubles),
        damping(memory + 3 * doubles),
        velocity(memory + 4 * doubles),
        by_zone(memory + 5 * doubles),
        elastic_by_zone(memory + 6 * doubles) {}
  double* net;       // forces less damping
  double* weighted;  // u + beta v, with stiffness-proportional damping
  // In measured steps:
  double* elastic;   // K u
  double* damping;   // damping forces
  double* velocity;  // of half a step ago
  // With forces by zones:
  double* by_zone;
  double* elastic_by_zone;
};

// Everything about a group that its passes need.
struct GroupData {
  GroupData(const Model& model, const BlockGroup& group_in, const StepData& step_in, double* scratch_in)
      : group(group_in),
        step(step_in),
        shape(model.templates[static_cast<std::size_t>(group_in.brick_template)]),
        slots(model.slots[static_cast<std::size_t>(group_in.brick_template)]),
        slot_point(model.slot_point.data() + static_cast<std::size_t>(group_in.first_slot) * kLanes),
        slot_run(model.slot_run.data() + group_in.first_slot),
        motion(step_in.rigid_motion ? step_in.rigid_motion + (&group_in - model.groups.data()) : nullptr),
        doubles(shape.node_count * kLine),
        u(step_in.displacement + static_cast<std::size_t>(group_in.first_line) * kLine),
        v(step_in.velocity + static_cast<std::size_t>(group_in.first_line) * kLine),
        dt_over_mass(step_in.dt_over_mass + static_cast<std::size_t>(group_in.first_line) * kLine),
        scratch(scratch_in, doubles) {}

  const BlockGroup& group;
  const StepData& step;
  const BrickTemplate& shape;
  const ContactSlots& slots;
  const std::int32_t* slot_point;
  const std::int32_t* slot_run;
  const RigidMotion* motion;
  const int doubles;
  double* const u;
  double* const v;
  const double* const dt_over_mass;
  GroupScratch scratch;
};

// The assembled template does all 8 lanes whatever they hold.
bool forces_by_zone(const GroupData& g) {
  if (g.step.internal_forces != InternalForces::automatic) return g.step.internal_forces == InternalForces::zones;
  return g.group.block_count <= kFewBlocks;
}

// Nodal forces and damping forces: - K u, contact points in the order of the slots, weight; Fd of equation 1.
template <DampingKind kDamping, bool kMeasure>
HWY_INLINE void group_forces(const GroupData& g) {
  const D d;
  const StepData& step = g.step;
  double* HWY_RESTRICT net = g.scratch.net;
  const double* HWY_RESTRICT v = g.v;
  const V zero = hn::Zero(d), gamma = hn::Set(d, step.local_damping);

  // Stiffness-proportional damping acts like the stiffness on u + beta v.
  const double* w = g.u;
  if (step.stiffness_damping != 0.0) {
    const V beta = hn::Set(d, step.stiffness_damping);
    for (int i = 0; i < g.doubles; i += kWidth) {
      hn::Store(hn::MulAdd(beta, hn::Load(d, v + i), hn::Load(d, g.u + i)), d, g.scratch.weighted + i);
    }
    w = g.scratch.weighted;
  }

  const bool by_zone = forces_by_zone(g);
  const bool elastic_apart = kMeasure && w != g.u;
  if (by_zone) {
    zone_forces(g.shape, g.group.block_count, w, g.scratch.by_zone);
    if (elastic_apart) zone_forces(g.shape, g.group.block_count, g.u, g.scratch.elastic_by_zone);
  }
  InternalForceRows rows(g.shape, w, by_zone ? g.scratch.by_zone : nullptr);
  InternalForceRows elastic_rows(g.shape, g.u, by_zone ? g.scratch.elastic_by_zone : nullptr);
  int slot = 0;
  for (int n = 0; n < g.shape.node_count; ++n) {
    V f[3][kParts];
    rows.next(f);
    if (kMeasure) {
      V elastic[3][kParts];
      if (elastic_apart) elastic_rows.next(elastic);
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) {
          if (!elastic_apart) elastic[c][p] = f[c][p];
          const int i = n * kLine + c * kLanes + p * kWidth;
          hn::Store(elastic[c][p], d, g.scratch.elastic + i);
          hn::Store(hn::Sub(f[c][p], elastic[c][p]), d, g.scratch.damping + i);  // beta K v
        }
      }
    }
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) f[c][p] = hn::Neg(f[c][p]);
    }
    for (; slot < g.slots.slot_end[static_cast<std::size_t>(n)]; ++slot) {
      const V sign = hn::Set(d, g.slots.sign[static_cast<std::size_t>(slot)]);
      const std::int32_t* point = g.slot_point + slot * kLanes;
      const std::int32_t run = g.slot_run[slot];
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) {
          const double* force = step.force[c];
          const V along = run >= 0 ? hn::LoadU(d, force + run + p * kWidth) : gather(d, force, point + p * kWidth);
          f[c][p] = hn::MulAdd(sign, along, f[c][p]);
        }
      }
    }
    const double mass = g.shape.node_mass[static_cast<std::size_t>(n)];
    for (int c = 0; c < 3; ++c) {
      const V weight = hn::Set(d, mass * step.gravity[static_cast<std::size_t>(c)]);
      for (int p = 0; p < kParts; ++p) {
        const int i = n * kLine + c * kLanes + p * kWidth;
        const V force = hn::Add(f[c][p], weight);
        V after = force;
        if (kDamping == DampingKind::local) {
          // Fd = gamma |F| sgn(v), sgn(0) = +1
          const V amount = hn::Mul(gamma, hn::Abs(force));
          const V damping = hn::IfThenElse(hn::Lt(hn::Load(d, v + i), zero), hn::Neg(amount), amount);
          after = hn::Sub(force, damping);
          if (kMeasure) hn::Store(damping, d, g.scratch.damping + i);
        }
        hn::Store(after, d, net + i);
        if (kMeasure) hn::Store(hn::Load(d, v + i), d, g.scratch.velocity + i);
      }
    }
  }
}

// Lanes that hold a block.
HWY_INLINE V lanes_in_use(const GroupData& g, int part) {
  alignas(64) double use[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) use[lane] = lane < g.group.block_count ? 1.0 : 0.0;
  return hn::Load(D(), use + part * kWidth);
}

// Sum x and sum r x x over the gridpoints, times inverse mass and inertia: the rigid-body acceleration of forces x.
struct RigidVectors {
  V linear[3][kParts], angular[3][kParts];
};
template <class Weight>
HWY_INLINE void rigid_sums(const GroupData& g, const double* x, Weight weight_of, RigidVectors* sum) {
  const D d;
  for (int c = 0; c < 3; ++c) {
    for (int p = 0; p < kParts; ++p) sum->linear[c][p] = sum->angular[c][p] = hn::Zero(d);
  }
  for (int n = 0; n < g.shape.node_count; ++n) {
    const Vec3& at = g.shape.node[static_cast<std::size_t>(n)];
    for (int p = 0; p < kParts; ++p) {
      V f[3];
      for (int c = 0; c < 3; ++c) {
        const int i = n * kLine + c * kLanes + p * kWidth;
        f[c] = weight_of(n, i, hn::Load(d, x + i));
        sum->linear[c][p] = hn::Add(sum->linear[c][p], f[c]);
      }
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
        const V r_next = hn::Set(d, at[next] - g.motion->centre[next]);
        const V r_last = hn::Set(d, at[last] - g.motion->centre[last]);
        sum->angular[c][p] = hn::MulAdd(r_next, f[last], hn::NegMulAdd(r_last, f[next], sum->angular[c][p]));
      }
    }
  }
}
HWY_INLINE RigidVectors times_inverse_inertia(const GroupData& g, const RigidVectors& sum, double factor) {
  const D d;
  RigidVectors result;
  for (int p = 0; p < kParts; ++p) {
    const V use = hn::Mul(lanes_in_use(g, p), hn::Set(d, factor));
    for (std::size_t c = 0; c < 3; ++c) {
      result.linear[c][p] = hn::Mul(hn::Mul(hn::Set(d, g.motion->inverse_mass[c]), use), sum.linear[c][p]);
      V turn = hn::Zero(d);
      for (std::size_t k = 0; k < 3; ++k)
        turn = hn::MulAdd(hn::Set(d, g.motion->inverse_inertia[3 * c + k]), sum.angular[k][p], turn);
      result.angular[c][p] = hn::Mul(turn, use);
    }
  }
  return result;
}

// Central differences: v += dt M'^-1 (F - Fd), u += dt v. With damping by block, rigid_damping gets force and moment of
// Fd = gamma |F| sgn(v) on the rigid motion.
template <DampingKind kDamping>
HWY_INLINE void integrate_group(const GroupData& g, RigidVectors* rigid_damping) {
  const D d;
  const V dt = hn::Set(d, g.step.time_step);
  // The part alpha m v of viscous damping needs no mass: alpha m v dt/m = alpha dt v.
  const V decay = hn::Set(d, g.step.mass_damping * g.step.time_step);
  const double* net = g.scratch.net;
  const auto move = [&](int i, V extra) {
    const V before = hn::Load(d, g.v + i);
    const V after = hn::MulAdd(hn::Load(d, net + i), hn::Load(d, g.dt_over_mass + i),
                               hn::Add(hn::NegMulAdd(decay, before, before), extra));
    hn::Store(after, d, g.v + i);
    hn::Store(hn::MulAdd(after, dt, hn::Load(d, g.u + i)), d, g.u + i);
  };
  if (!g.motion) {
    for (int i = 0; i < g.doubles; i += kWidth) move(i, hn::Zero(d));
    return;
  }
  RigidVectors force, excess;
  rigid_sums(
      g, net, [](int, int, V f) { return f; }, &force);
  const V released = hn::Set(d, 1.0 - 1.0 / g.step.deformation_inertia);
  if (kDamping == DampingKind::block) {
    RigidVectors momentum;
    const auto mass_times = [&](int n, int, V velocity) {
      return hn::Mul(hn::Set(d, g.shape.node_mass[static_cast<std::size_t>(n)]), velocity);
    };
    rigid_sums(g, g.v, mass_times, &momentum);
    const V gamma = hn::Set(d, g.step.local_damping), zero = hn::Zero(d);
    const auto damp = [&](const V(&f)[3][kParts], const V(&motion)[3][kParts], V(&damping)[3][kParts],
                          V(&net_force)[3][kParts]) {
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) {
          const V amount = hn::Mul(gamma, hn::Abs(f[c][p]));
          damping[c][p] = hn::IfThenElse(hn::Lt(motion[c][p], zero), hn::Neg(amount), amount);
          net_force[c][p] = hn::MulSub(released, f[c][p], damping[c][p]);
        }
      }
    };
    damp(force.linear, momentum.linear, rigid_damping->linear, excess.linear);
    damp(force.angular, momentum.angular, rigid_damping->angular, excess.angular);
  } else {
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) {
        excess.linear[c][p] = hn::Mul(released, force.linear[c][p]);
        excess.angular[c][p] = hn::Mul(released, force.angular[c][p]);
      }
    }
  }
  const RigidVectors rigid = times_inverse_inertia(g, excess, g.step.time_step);
  for (int n = 0; n < g.shape.node_count; ++n) {
    const Vec3& at = g.shape.node[static_cast<std::size_t>(n)];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
      const V r_next = hn::Set(d, at[next] - g.motion->centre[next]);
      const V r_last = hn::Set(d, at[last] - g.motion->centre[last]);
      for (int p = 0; p < kParts; ++p) {
        const V turn = hn::NegMulAdd(rigid.angular[last][p], r_next, hn::Mul(rigid.angular[next][p], r_last));
        move(n * kLine + static_cast<int>(c) * kLanes + p * kWidth, hn::Add(rigid.linear[c][p], turn));
      }
    }
  }
}

// What a measured step records, from what the passes left in scratch.
template <DampingKind kDamping>
HWY_INLINE void measure_group(const GroupData& g, const RigidVectors& rigid_damping, Measured* measured) {
  const D d;
  const StepData& step = g.step;
  const V zero = hn::Zero(d), half = hn::Set(d, 0.5), dt = hn::Set(d, step.time_step);
  const V half_dt = hn::Mul(half, dt), alpha = hn::Set(d, step.mass_damping);
  const GroupScratch& s = g.scratch;
  V unbalanced[kParts], kinetic[kParts], moment[kParts], strain[kParts], damping_before[kParts], damping_after[kParts],
      weight_before[kParts], weight_after[kParts];
  for (int p = 0; p < kParts; ++p) {
    unbalanced[p] = kinetic[p] = moment[p] = strain[p] = damping_before[p] = damping_after[p] = weight_before[p] =
        weight_after[p] = zero;
  }
  const auto inertia_at = [&](int i) {
    const V scale = hn::Load(d, g.dt_over_mass + i);
    return hn::IfThenElseZero(hn::Ne(scale, zero), hn::Div(dt, scale));
  };
  for (int n = 0; n < g.shape.node_count; ++n) {
    const double mass = g.shape.node_mass[static_cast<std::size_t>(n)];
    V squared[kParts];
    for (int p = 0; p < kParts; ++p) squared[p] = zero;
    for (int c = 0; c < 3; ++c) {
      const V weight = hn::Set(d, mass * step.gravity[static_cast<std::size_t>(c)]);
      for (int p = 0; p < kParts; ++p) {
        const int i = n * kLine + c * kLanes + p * kWidth;
        const V before = hn::Load(d, s.velocity + i), after = hn::Load(d, g.v + i), inertia = inertia_at(i);
        const V damping = hn::Load(d, s.damping + i);
        // Local damping is part of the net force, beta K v of the internal force.
        const V force =
            kDamping == DampingKind::local ? hn::Add(hn::Load(d, s.net + i), damping) : hn::Load(d, s.net + i);
        const V free_force = hn::IfThenElseZero(hn::Ne(inertia, zero), force);
        squared[p] = hn::MulAdd(free_force, free_force, squared[p]);
        kinetic[p] = hn::MulAdd(inertia, hn::Mul(before, after), kinetic[p]);
        moment[p] = hn::MulAdd(inertia, hn::Mul(before, before), moment[p]);
        // K u was formed before u moved on.
        const V displacement = hn::NegMulAdd(after, dt, hn::Load(d, g.u + i));
        strain[p] = hn::MulAdd(hn::Mul(half, hn::Load(d, s.elastic + i)), displacement, strain[p]);
        if (kDamping != DampingKind::none) {
          damping_before[p] = hn::MulAdd(damping, hn::Mul(before, half_dt), damping_before[p]);
          damping_after[p] = hn::MulAdd(damping, hn::Mul(after, half_dt), damping_after[p]);
        }
        weight_before[p] = hn::MulAdd(weight, hn::Mul(before, half_dt), weight_before[p]);
        weight_after[p] = hn::MulAdd(weight, hn::Mul(after, half_dt), weight_after[p]);
      }
    }
    for (int p = 0; p < kParts; ++p) unbalanced[p] = hn::Max(unbalanced[p], squared[p]);
  }

  // v M' w = s v m w - (s - 1) (P v) M (P w): rigid motion has its true inertia.
  if (g.motion) {
    const double s_factor = step.deformation_inertia;
    const auto momentum = [&](int, int i, V velocity) { return hn::Mul(inertia_at(i), velocity); };
    RigidVectors before, after;
    rigid_sums(g, s.velocity, momentum, &before);
    rigid_sums(g, g.v, momentum, &after);
    // The sums hold s m v: what is over is (s - 1)/s^2 of their product.
    const double over = (s_factor - 1.0) / (s_factor * s_factor);
    const RigidVectors motion = times_inverse_inertia(g, before, over);
    if (kDamping == DampingKind::block) {
      const RigidVectors first = times_inverse_inertia(g, before, 1.0 / s_factor);
      const RigidVectors second = times_inverse_inertia(g, after, 1.0 / s_factor);
      const auto add_work = [&](const V(&force)[3][kParts], const V(&velocity)[3][kParts], V(&work)[kParts]) {
        for (int p = 0; p < kParts; ++p) {
          for (int c = 0; c < 3; ++c) work[p] = hn::MulAdd(hn::Mul(force[c][p], half_dt), velocity[c][p], work[p]);
        }
      };
      add_work(rigid_damping.linear, first.linear, damping_before);
      add_work(rigid_damping.angular, first.angular, damping_before);
      add_work(rigid_damping.linear, second.linear, damping_after);
      add_work(rigid_damping.angular, second.angular, damping_after);
    }
    for (int p = 0; p < kParts; ++p) {
      for (int c = 0; c < 3; ++c) {
        kinetic[p] = hn::NegMulAdd(motion.linear[c][p], after.linear[c][p], kinetic[p]);
        kinetic[p] = hn::NegMulAdd(motion.angular[c][p], after.angular[c][p], kinetic[p]);
        moment[p] = hn::NegMulAdd(motion.linear[c][p], before.linear[c][p], moment[p]);
        moment[p] = hn::NegMulAdd(motion.angular[c][p], before.angular[c][p], moment[p]);
      }
    }
  }
  if (kDamping == DampingKind::viscous) {
    for (int p = 0; p < kParts; ++p) {  // the part alpha M' v
      damping_before[p] = hn::MulAdd(hn::Mul(alpha, half_dt), moment[p], damping_before[p]);
      damping_after[p] = hn::MulAdd(hn::Mul(alpha, half_dt), kinetic[p], damping_after[p]);
    }
  }
  for (int p = 0; p < kParts; ++p) kinetic[p] = hn::Mul(half, kinetic[p]);

  alignas(64) double lane[kLanes];
  for (int p = 0; p < kParts; ++p) hn::Store(unbalanced[p], d, lane + p * kWidth);
  measured->unbalanced_squared = 0.0;
  for (double x : lane)
    measured->unbalanced_squared = x > measured->unbalanced_squared ? x : measured->unbalanced_squared;
  measured->kinetic = sum_lanes(kinetic);
  measured->strain = sum_lanes(strain);
  measured->damping_before = sum_lanes(damping_before);
  measured->damping_after = sum_lanes(damping_after);
  measured->external_before = sum_lanes(weight_before);
  measured->external_after = sum_lanes(weight_after);
}

template <DampingKind kDamping, bool kMeasure>
HWY_NOINLINE void AdvanceGroupAs(const Model& model, const BlockGroup& group, const StepData& step, double* scratch,
                                 Measured* measured) {
  const GroupData g(model, group, step, scratch);
  RigidVectors rigid_damping;
  group_forces<kDamping, kMeasure>(g);
  integrate_group<kDamping>(g, &rigid_damping);
  if (kMeasure) measure_group<kDamping>(g, rigid_damping, measured);
}

void AdvanceGroup(const Model& model, const BlockGroup& group, const StepData& step, double* scratch,
                  Measured* measured) {
  switch (step.damping) {
    case DampingKind::none:
      return measured ? AdvanceGroupAs<DampingKind::none, true>(model, group, step, scratch, measured)
                      : AdvanceGroupAs<DampingKind::none, false>(model, group, step, scratch, measured);
    case DampingKind::local:
      return measured ? AdvanceGroupAs<DampingKind::local, true>(model, group, step, scratch, measured)
                      : AdvanceGroupAs<DampingKind::local, false>(model, group, step, scratch, measured);
    case DampingKind::viscous:
      return measured ? AdvanceGroupAs<DampingKind::viscous, true>(model, group, step, scratch, measured)
                      : AdvanceGroupAs<DampingKind::viscous, false>(model, group, step, scratch, measured);
    case DampingKind::block:
      return measured ? AdvanceGroupAs<DampingKind::block, true>(model, group, step, scratch, measured)
                      : AdvanceGroupAs<DampingKind::block, false>(model, group, step, scratch, measured);
  }
}

const char* InstructionSet() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin {

HWY_EXPORT(ContactJumps);
HWY_EXPORT(ContactForces);
HWY_EXPORT(AdvanceGroup);
HWY_EXPORT(InstructionSet);

void contact_jumps(const Model& model, const ContactChunk& chunk, const StepData& step, ChunkJumps* jumps) {
  HWY_DYNAMIC_DISPATCH(ContactJumps)(model, chunk, step, jumps);
}
void contact_forces(const Model& model, const ContactChunk& chunk, const StepData& step) {
  HWY_DYNAMIC_DISPATCH(ContactForces)(model, chunk, step);
}
void advance_group(const Model& model, const BlockGroup& group, const StepData& step, double* scratch,
                   Measured* measured) {
  HWY_DYNAMIC_DISPATCH(AdvanceGroup)(model, group, step, scratch, measured);
}
const char* kernel_instruction_set() { return HWY_DYNAMIC_DISPATCH(InstructionSet)(); }

}  // namespace quoin
#endif
