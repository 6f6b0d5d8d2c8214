#include "step/kernels.h"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/larger.h"
#include "model/stiffness-inl.h"
#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {

// Groups of at most this many blocks are cheaper zone by zone (benchmarks/README.md). It must not depend on the
// instruction set: both ways differ in the last bits.
constexpr int kFewBlocks = 1;

// ---- Contact points ------------------------------------------------------------------------------------------------

// Pointers of a chunk in local copies: after each store the compiler would load them again, as stores might alias them.
struct JumpSource {
  const std::int32_t *a, *b;
  const std::uint8_t* run;
  const double *normal, *slip_s, *slip_t;  // displacement, velocity, velocity, each along its axis
  const double* shift;                     // null: none
  double time_step;
};

template <class Tag>
HWY_INLINE void jumps_of(Tag d, const JumpSource& from, int i, ChunkJumps* jumps) {
  const std::int32_t* a = from.a + i;
  const std::int32_t* b = from.b + i;
  const auto dt = hn::Set(d, from.time_step);
  // Consecutive gridpoints, as in a regular wall, need no gather instructions.
  const bool side_by_side = from.run[i] >= hn::Lanes(d);
  const auto jump = [&](const double* field) {
    if (side_by_side) return hn::Sub(hn::LoadU(d, field + *b), hn::LoadU(d, field + *a));
    return hn::Sub(gather(d, field, b), gather(d, field, a));
  };
  auto normal = jump(from.normal);
  if (from.shift) normal = hn::Add(normal, hn::LoadU(d, from.shift + i));
  hn::StoreU(normal, d, jumps->normal + i);
  hn::StoreU(hn::Mul(jump(from.slip_s), dt), d, jumps->slip_s + i);
  hn::StoreU(hn::Mul(jump(from.slip_t), dt), d, jumps->slip_t + i);
}

void ContactJumps(const Model& model, const ContactChunk& chunk, const StepData& step, ChunkJumps* jumps) {
  const int first = chunk.first_point, count = chunk.point_count;
  const int n = kLanes * chunk.axis, s = kLanes * ((chunk.axis + 1) % 3), t = kLanes * ((chunk.axis + 2) % 3);
  const JumpSource from{model.node_a.data() + first,
                        model.node_b.data() + first,
                        model.point_run.data() + first,
                        step.displacement + n,
                        step.velocity + s,
                        step.velocity + t,
                        step.normal_shift ? step.normal_shift + first : nullptr,
                        step.time_step};
  int i = 0;
  for (; i + kWidth <= count; i += kWidth) jumps_of(D(), from, i, jumps);
  for (; i < count; ++i) jumps_of(hn::CappedTag<double, 1>(), from, i, jumps);
}

template <class Tag>
HWY_INLINE void forces_of(Tag d, const double* area, const double* const (&traction)[3], const double* const* viscous,
                          double* const (&force)[3], int i) {
  const auto times = hn::LoadU(d, area + i);
  for (int k = 0; k < 3; ++k) {
    auto sum = hn::LoadU(d, traction[k] + i);
    if (viscous) sum = hn::Add(sum, hn::LoadU(d, viscous[k] + i));
    hn::StoreU(hn::Mul(sum, times), d, force[k] + i);
  }
}

void ContactForces(const Model& model, const ContactChunk& chunk, const StepData& step, const double* const* viscous) {
  const int axis = chunk.axis, end = chunk.first_point + chunk.point_count;
  const double* area = model.area.data();
  const double* const traction[3] = {step.traction[0], step.traction[1], step.traction[2]};
  double* const force[3] = {step.force[axis], step.force[(axis + 1) % 3], step.force[(axis + 2) % 3]};
  int i = chunk.first_point;
  for (; i + kWidth <= end; i += kWidth) forces_of(D(), area, traction, viscous, force, i);
  for (; i < end; ++i) forces_of(hn::CappedTag<double, 1>(), area, traction, viscous, force, i);
}

// ---- Deformable blocks ---------------------------------------------------------------------------------------------

// K w zone by zone for the blocks of a group, one after the other: f = V sigma grad N at each corner.
HWY_NOINLINE void zone_forces(const BrickTemplate& shape, int block_count, const double* w, double* f) {
  std::memset(f, 0, sizeof(double) * static_cast<std::size_t>(shape.node_count) * kLine);
  for (int lane = 0; lane < block_count; ++lane) {
    for (const Zone& zone : shape.zone) {
      double gradient[3][3] = {};  // dw_c / dx_k
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

// K w of kCount groups, gridpoint by gridpoint: from the template's stiffness, or from zone_forces in lane layout.
template <int kCount>
class InternalForceRows {
 public:
  explicit InternalForceRows(const BrickTemplate& shape) : rows_(shape.stiffness) {}
  void group(int b, const double* w, const double* by_zone) {
    w_[b] = w;
    by_zone_[b] = by_zone;
  }

  HWY_INLINE void next(V (&f)[kCount][3][kParts]) {
    if (!by_zone_[0]) return rows_.next(w_, f);
    for (int b = 0; b < kCount; ++b) {
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) f[b][c][p] = hn::Load(D(), by_zone_[b] + c * kLanes + p * kWidth);
      }
      by_zone_[b] += kLine;
    }
  }

 private:
  StiffnessRows<kCount> rows_;
  const double* w_[kCount] = {};
  const double* by_zone_[kCount] = {};
};

// Sums lanes 0 .. 7 in this order.
HWY_INLINE double sum_lanes(const V (&x)[kParts]) {
  alignas(64) double lane[kLanes];
  for (int p = 0; p < kParts; ++p) hn::Store(x[p], D(), lane + p * kWidth);
  double sum = 0.0;
  for (double value : lane) sum += value;
  return sum;
}

// Columns of scratch in lane layout, which the passes over a group share.
struct GroupScratch {
  GroupScratch(double* memory, int doubles)
      : net(memory),
        weighted(memory + doubles),
        elastic(memory + 2 * doubles),
        damping(memory + 3 * doubles),
        velocity(memory + 4 * doubles),
        by_zone(memory + 5 * doubles),
        elastic_by_zone(memory + 6 * doubles) {}
  double* net;       // forces less damping, N
  double* weighted;  // u + beta v, m, with stiffness-proportional damping
  // In measured steps:
  double* elastic;   // K u, N
  double* damping;   // damping forces, N
  double* velocity;  // velocity at t - dt/2, m/s
  // With forces by zones:
  double* by_zone;
  double* elastic_by_zone;
};

// Data of a group that its passes read.
struct GroupData {
  GroupData(const Model& model, int index, const StepData& step_in, double* scratch_in)
      : group(model.groups[static_cast<std::size_t>(index)]),
        step(step_in),
        shape(model.templates[static_cast<std::size_t>(group.brick_template)]),
        slots(model.slots[static_cast<std::size_t>(group.brick_template)]),
        slot_point(model.slot_point.data() + static_cast<std::size_t>(group.first_slot) * kLanes),
        slot_run(model.slot_run.data() + group.first_slot),
        motion(step_in.block_motion ? step_in.block_motion + index : nullptr),
        doubles(shape.node_count * kLine),
        u(step_in.displacement + static_cast<std::size_t>(group.first_line) * kLine),
        v(step_in.velocity + static_cast<std::size_t>(group.first_line) * kLine),
        dt_over_mass(step_in.dt_over_mass + static_cast<std::size_t>(group.first_line) * kLine),
        shared_dt_over_mass(step_in.shared_dt_over_mass[index]),
        load(step_in.load[index]),
        scratch(scratch_in, doubles) {
    for (int lane = 0; lane < kLanes; ++lane) in_use[lane] = lane < group.block_count ? 1.0 : 0.0;
  }

  const BlockGroup& group;
  const StepData& step;
  const BrickTemplate& shape;
  const ContactSlots& slots;
  const std::int32_t* slot_point;
  const std::int32_t* slot_run;
  const RigidMotion* motion;  // rigid motion of its blocks; null: not needed
  const int doubles;
  double* const u;
  double* const v;
  const double* const dt_over_mass;
  const double* const shared_dt_over_mass;  // null: not shared
  const double* const load;                 // null: none
  alignas(64) double in_use[kLanes];        // 1: the lane holds a block; else 0
  GroupScratch scratch;
};

// dt/(s_b m) of component c of gridpoint n in part p of the lanes.
HWY_INLINE V dt_over_mass(const GroupData& g, int n, int c, int p) {
  const D d;
  if (g.shared_dt_over_mass)
    return hn::Mul(hn::Set(d, g.shared_dt_over_mass[3 * n + c]), hn::Load(d, g.in_use + p * kWidth));
  return hn::Load(d, g.dt_over_mass + n * kLine + c * kLanes + p * kWidth);
}

// s_b m; 0 where held.
HWY_INLINE V inertia_at(const GroupData& g, int n, int c, int p) {
  const D d;
  const V scale = dt_over_mass(g, n, c, p);
  return hn::IfThenElseZero(hn::Ne(scale, hn::Zero(d)), hn::Div(hn::Set(d, g.step.time_step), scale));
}

// Whether internal forces are computed zone by zone. With few blocks they are, as the assembled template computes all 8
// lanes.
bool forces_by_zone(const GroupData& g) {
  if (g.step.internal_forces != InternalForces::automatic) return g.step.internal_forces == InternalForces::zones;
  return g.group.block_count <= kFewBlocks;
}

// Stiffness-proportional damping acts like the stiffness on u + beta v.
HWY_INLINE const double* damped_displacement(const GroupData& g) {
  if (g.step.stiffness_damping == 0.0) return g.u;
  const D d;
  const V beta = hn::Set(d, g.step.stiffness_damping);
  for (int i = 0; i < g.doubles; i += kWidth)
    hn::Store(hn::MulAdd(beta, hn::Load(d, g.v + i), hn::Load(d, g.u + i)), d, g.scratch.weighted + i);
  return g.scratch.weighted;
}

// Internal forces at gridpoint n, split into those of u and those of beta v.
template <int kCount>
HWY_INLINE void store_split(const GroupData* groups, int n, const V (&internal)[kCount][3][kParts],
                            const V (&elastic)[kCount][3][kParts]) {
  const D d;
  for (int b = 0; b < kCount; ++b) {
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) {
        const int i = n * kLine + c * kLanes + p * kWidth;
        hn::Store(elastic[b][c][p], d, groups[b].scratch.elastic + i);
        hn::Store(hn::Sub(internal[b][c][p], elastic[b][c][p]), d, groups[b].scratch.damping + i);
      }
    }
  }
}

// Computes nodal forces and damping forces of kCount groups of one template. Forces: - K u, those of contact points in
// the order of the slots, weight. Damping: Fd of eq. 1.
template <Brake kBrake, bool kMeasure, int kCount>
HWY_INLINE void group_forces(const GroupData* groups) {
  const D d;
  const StepData& step = groups[0].step;
  const BrickTemplate& shape = groups[0].shape;
  const ContactSlots& slots = groups[0].slots;
  const V gamma = hn::Set(d, step.local_damping);
  const bool by_zone = forces_by_zone(groups[0]);
  const bool elastic_apart = kMeasure && step.energies && step.stiffness_damping != 0.0;

  InternalForceRows<kCount> rows(shape), elastic_rows(shape);
  for (int b = 0; b < kCount; ++b) {
    const GroupData& g = groups[b];
    const double* const w = damped_displacement(g);
    if (by_zone) {
      zone_forces(shape, g.group.block_count, w, g.scratch.by_zone);
      if (elastic_apart) zone_forces(shape, g.group.block_count, g.u, g.scratch.elastic_by_zone);
    }
    rows.group(b, w, by_zone ? g.scratch.by_zone : nullptr);
    elastic_rows.group(b, g.u, by_zone ? g.scratch.elastic_by_zone : nullptr);
  }

  int slot = 0;
  for (int n = 0; n < shape.node_count; ++n) {
    V f[kCount][3][kParts];
    rows.next(f);
    if (elastic_apart) {
      V elastic[kCount][3][kParts];
      elastic_rows.next(elastic);
      store_split<kCount>(groups, n, f, elastic);
    } else if (kMeasure && step.energies) {
      store_split<kCount>(groups, n, f, f);
    }
    for (int b = 0; b < kCount; ++b) {
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) f[b][c][p] = hn::Neg(f[b][c][p]);
      }
    }
    for (; slot < slots.slot_end[static_cast<std::size_t>(n)]; ++slot) {
      const V sign = hn::Set(d, slots.sign[static_cast<std::size_t>(slot)]);
      for (int b = 0; b < kCount; ++b) {
        const std::int32_t* point = groups[b].slot_point + slot * kLanes;
        const std::int32_t run = groups[b].slot_run[slot];
        for (int c = 0; c < 3; ++c) {
          for (int p = 0; p < kParts; ++p) {
            const double* force = step.force[c];
            const V along = run >= 0 ? hn::LoadU(d, force + run + p * kWidth) : gather(d, force, point + p * kWidth);
            f[b][c][p] = hn::MulAdd(sign, along, f[b][c][p]);
          }
        }
      }
    }
    const double mass = shape.node_mass[static_cast<std::size_t>(n)];
    for (int c = 0; c < 3; ++c) {
      const V weight = hn::Set(d, mass * step.gravity[static_cast<std::size_t>(c)]);
      for (int b = 0; b < kCount; ++b) {
        const GroupData& g = groups[b];
        for (int p = 0; p < kParts; ++p) {
          const int i = n * kLine + c * kLanes + p * kWidth;
          V force = hn::Add(f[b][c][p], weight);
          if (g.load) force = hn::MulAdd(hn::Set(d, mass), hn::Load(d, g.load + c * kLanes + p * kWidth), force);
          V after = force;
          if (kBrake == Brake::gridpoints) {
            const V ground = hn::Set(d, step.ground_velocity[static_cast<std::size_t>(c)]);
            const V damping = local_damping(gamma, force, hn::Sub(hn::Load(d, g.v + i), ground));
            after = hn::Sub(force, damping);
            if (kMeasure) hn::Store(damping, d, g.scratch.damping + i);
          }
          hn::Store(after, d, g.scratch.net + i);
          if (kMeasure) hn::Store(hn::Load(d, g.v + i), d, g.scratch.velocity + i);
        }
      }
    }
  }
}

template <int kCount>
HWY_INLINE void stiffness_times_u(const GroupData* groups, double* force) {
  InternalForceRows<kCount> rows(groups[0].shape);
  for (int b = 0; b < kCount; ++b) rows.group(b, groups[b].u, nullptr);
  for (int n = 0; n < groups[0].shape.node_count; ++n) {
    V f[kCount][3][kParts];
    rows.next(f);
    for (int b = 0; b < kCount; ++b) {
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p)
          hn::Store(f[b][c][p], D(), force + b * groups[0].doubles + n * kLine + c * kLanes + p * kWidth);
      }
    }
  }
}

// ---- Rigid motion of blocks and units (model/rigid_motion.h) -------------------------------------------------------

// Force and moment about a centre, or velocity and spin, or acceleration of both; for the blocks of a group, by lane.
struct Rigid {
  V linear[3][kParts], angular[3][kParts];
};

template <class Operation>
HWY_INLINE Rigid each(const Rigid& x, const Rigid& y, Operation operation) {
  Rigid result;
  for (int c = 0; c < 3; ++c) {
    for (int p = 0; p < kParts; ++p) {
      result.linear[c][p] = operation(x.linear[c][p], y.linear[c][p]);
      result.angular[c][p] = operation(x.angular[c][p], y.angular[c][p]);
    }
  }
  return result;
}

// Data of the blocks of a unit group, and their rigid motion.
struct UnitData {
  UnitData(const Model& model, const UnitGroup& unit, const StepData& step_in, double* scratch)
      : step(step_in),
        count(unit.group_count),
        blocks{{model, unit.first_group, step_in, scratch},
               {model, unit.first_group + unit.group_count - 1, step_in, scratch + step_in.scratch_doubles}},
        motion(step_in.unit_motion ? step_in.unit_motion + (&unit - model.unit_groups.data()) : nullptr) {
    if (!motion) return;
    for (std::size_t b = 0; b < kUnitBlocks; ++b) {
      for (std::size_t c = 0; c < 3; ++c)
        arm[b][c] = blocks[b].motion->centre[c] + blocks[b].group.offset[c] - motion->centre[c];
    }
  }

  const StepData& step;
  const int count;
  const GroupData blocks[kUnitBlocks];  // count 1: both are of the same group
  const RigidMotion* const motion;
  Vec3 arm[kUnitBlocks];  // centre of each block from that of the unit, m
};

// Sum x and sum r x x over the gridpoints of a group, r from the centre of the block.
template <class Weight>
HWY_INLINE Rigid rigid_sums(const GroupData& g, const double* x, Weight weight_of) {
  const D d;
  Rigid sum;
  for (int c = 0; c < 3; ++c) {
    for (int p = 0; p < kParts; ++p) sum.linear[c][p] = sum.angular[c][p] = hn::Zero(d);
  }
  for (int n = 0; n < g.shape.node_count; ++n) {
    const Vec3& at = g.shape.node[static_cast<std::size_t>(n)];
    for (int p = 0; p < kParts; ++p) {
      V f[3];
      for (int c = 0; c < 3; ++c) {
        const int i = n * kLine + c * kLanes + p * kWidth;
        f[c] = weight_of(n, c, p, hn::Load(d, x + i));
        sum.linear[c][p] = hn::Add(sum.linear[c][p], f[c]);
      }
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
        const V r_next = hn::Set(d, at[next] - g.motion->centre[next]);
        const V r_last = hn::Set(d, at[last] - g.motion->centre[last]);
        sum.angular[c][p] = hn::MulAdd(r_next, f[last], hn::NegMulAdd(r_last, f[next], sum.angular[c][p]));
      }
    }
  }
  return sum;
}

HWY_INLINE Rigid times(const std::array<double, 9>& matrix, const Vec3& diagonal, const Rigid& x) {
  const D d;
  Rigid result;
  for (int p = 0; p < kParts; ++p) {
    for (std::size_t c = 0; c < 3; ++c) {
      result.linear[c][p] = hn::Mul(hn::Set(d, diagonal[c]), x.linear[c][p]);
      V turn = hn::Zero(d);
      for (std::size_t k = 0; k < 3; ++k) turn = hn::MulAdd(hn::Set(d, matrix[3 * c + k]), x.angular[k][p], turn);
      result.angular[c][p] = turn;
    }
  }
  return result;
}
HWY_INLINE Rigid over_inertia(const RigidMotion& motion, const Rigid& x) {
  return times(motion.inverse_inertia, motion.inverse_mass, x);
}
HWY_INLINE Rigid times_inertia(const RigidMotion& motion, const Rigid& x) {
  return times(motion.inertia, {motion.mass, motion.mass, motion.mass}, x);
}

// sum + arm x direct, component by component.
HWY_INLINE void add_cross(const Vec3& arm, const V (&direct)[3][kParts], V (&sum)[3][kParts]) {
  const D d;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
    const V r_next = hn::Set(d, arm[next]), r_last = hn::Set(d, arm[last]);
    for (int p = 0; p < kParts; ++p)
      sum[c][p] = hn::MulAdd(r_next, direct[last][p], hn::NegMulAdd(r_last, direct[next][p], sum[c][p]));
  }
}

// Motion of the unit from forces on its blocks, or from their momenta.
HWY_INLINE Rigid motion_of_unit(const UnitData& unit, const Rigid (&of_block)[kUnitBlocks]) {
  Rigid sum = of_block[0];
  add_cross(unit.arm[0], of_block[0].linear, sum.angular);
  Rigid second = of_block[1];
  add_cross(unit.arm[1], of_block[1].linear, second.angular);
  sum = each(sum, second, [](V x, V y) HWY_ATTR { return hn::Add(x, y); });
  return over_inertia(*unit.motion, sum);
}

// Motion of the unit at its block b: A + alpha x arm, alpha.
HWY_INLINE Rigid at_block(const UnitData& unit, int b, const Rigid& of_unit) {
  Rigid result = of_unit;
  const Vec3& arm = unit.arm[b];
  add_cross({-arm[0], -arm[1], -arm[2]}, of_unit.angular, result.linear);
  return result;
}

HWY_INLINE Rigid difference(const Rigid& x, const Rigid& y) {
  return each(x, y, [](V a, V b) HWY_ATTR { return hn::Sub(a, b); });
}

// Rigid part of each block's acceleration, M'^-1 net less net/(s_b m). Damping of rigid motion, gamma |a| sgn(v), acts
// separately on the motion of the unit and on the relative motion of its halves.
struct RigidStep {
  Rigid extra[kUnitBlocks];    // m/s2, 1/s2
  Rigid damping[kUnitBlocks];  // acceleration by damping, with true inertia
};
template <Brake kBrake>
HWY_INLINE RigidStep rigid_step(const UnitData& unit) {
  const D d;
  const StepData& step = unit.step;
  const double of_deformation = 1.0 / step.deformation_inertia, of_unit = 1.0 / step.unit_inertia;
  const auto damped = [gamma = hn::Set(d, step.local_damping)](V a, V v)
                          HWY_ATTR { return local_damping(gamma, a, v); };
  const auto plus = [&](V x, V y) HWY_ATTR { return hn::Add(x, y); };
  const auto plus_times = [d](double factor) HWY_ATTR {
    return [f = hn::Set(d, factor)](V x, V y) HWY_ATTR { return hn::MulAdd(f, y, x); };
  };

  Rigid force[kUnitBlocks], momentum[kUnitBlocks], acceleration[kUnitBlocks], velocity[kUnitBlocks];
  for (int b = 0; b < unit.count; ++b) {
    const GroupData& g = unit.blocks[b];
    force[b] = rigid_sums(g, g.scratch.net, [](int, int, int, V f) HWY_ATTR { return f; });
    acceleration[b] = over_inertia(*g.motion, force[b]);
    if (kBrake != Brake::rigid_motion) continue;
    momentum[b] = rigid_sums(g, g.v, [&](int n, int c, int, V v) HWY_ATTR {
      const V against_ground = hn::Sub(v, hn::Set(d, step.ground_velocity[static_cast<std::size_t>(c)]));
      return hn::Mul(hn::Set(d, g.shape.node_mass[static_cast<std::size_t>(n)]), against_ground);
    });
    velocity[b] = over_inertia(*g.motion, momentum[b]);
  }

  RigidStep result;
  const auto times_factor = [d](double factor, const Rigid& x) HWY_ATTR {
    return each(x, x, [f = hn::Set(d, factor)](V y, V) HWY_ATTR { return hn::Mul(f, y); });
  };
  if (unit.count == 1) {
    result.extra[0] = times_factor(1.0 - of_deformation, acceleration[0]);
    if (kBrake == Brake::rigid_motion) {
      result.damping[0] = each(acceleration[0], velocity[0], damped);
      result.extra[0] = difference(result.extra[0], result.damping[0]);
    }
  } else {
    const Rigid whole = motion_of_unit(unit, force);
    Rigid whole_damping, beside_damping[kUnitBlocks], beside_force[kUnitBlocks], leak;
    if (kBrake == Brake::rigid_motion) {
      const Rigid whole_velocity = motion_of_unit(unit, momentum);
      whole_damping = each(whole, whole_velocity, damped);
      for (int b = 0; b < kUnitBlocks; ++b) {
        beside_damping[b] = each(difference(acceleration[b], at_block(unit, b, whole)),
                                 difference(velocity[b], at_block(unit, b, whole_velocity)), damped);
        beside_force[b] = times_inertia(*unit.blocks[b].motion, beside_damping[b]);
      }
      // Damping of the relative motion of halves must have no resultant on the unit.
      leak = motion_of_unit(unit, beside_force);
    }
    for (int b = 0; b < kUnitBlocks; ++b) {
      result.extra[b] = each(times_factor(of_unit - of_deformation, acceleration[b]), at_block(unit, b, whole),
                             plus_times(1.0 - of_unit));
      if (kBrake != Brake::rigid_motion) continue;
      const Rigid of_whole = at_block(unit, b, whole_damping);
      const Rigid beside = difference(beside_damping[b], at_block(unit, b, leak));
      result.damping[b] = each(of_whole, beside, plus);
      result.extra[b] = each(difference(result.extra[b], of_whole), beside, plus_times(-of_unit));
    }
  }
  return result;
}

// Central differences: v += dt M'^-1 (F - Fd), u += dt v.
template <Brake kBrake>
HWY_INLINE void integrate_group(const UnitData& unit, int b, const Rigid* extra) {
  const D d;
  const GroupData& g = unit.blocks[b];
  const V dt = hn::Set(d, g.step.time_step);
  // The part alpha m v of viscous damping needs no mass: alpha m v dt/m = alpha dt v.
  const V decay = hn::Set(d, g.step.mass_damping * g.step.time_step);
  const double* net = g.scratch.net;
  const auto move = [&](int n, int c, int p, V more) HWY_ATTR {
    const int i = n * kLine + c * kLanes + p * kWidth;
    V before = hn::Load(d, g.v + i);
    if (kBrake == Brake::mass) {
      const V ground =
          hn::Mul(hn::Set(d, g.step.ground_velocity[static_cast<std::size_t>(c)]), hn::Load(d, g.in_use + p * kWidth));
      before = hn::NegMulAdd(decay, hn::Sub(before, ground), before);
    }
    const V after = hn::MulAdd(hn::Load(d, net + i), dt_over_mass(g, n, c, p), hn::Add(before, more));
    hn::Store(after, d, g.v + i);
    hn::Store(hn::MulAdd(after, dt, hn::Load(d, g.u + i)), d, g.u + i);
  };
  if (!extra) {
    for (int n = 0; n < g.shape.node_count; ++n) {
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) move(n, c, p, hn::Zero(d));
      }
    }
    return;
  }
  Rigid gain;  // change of velocity in the step, in lanes with a block
  for (int p = 0; p < kParts; ++p) {
    const V factor = hn::Mul(hn::Load(d, g.in_use + p * kWidth), dt);
    for (int c = 0; c < 3; ++c) {
      gain.linear[c][p] = hn::Mul(extra->linear[c][p], factor);
      gain.angular[c][p] = hn::Mul(extra->angular[c][p], factor);
    }
  }
  for (int n = 0; n < g.shape.node_count; ++n) {
    const Vec3& at = g.shape.node[static_cast<std::size_t>(n)];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
      const V r_next = hn::Set(d, at[next] - g.motion->centre[next]);
      const V r_last = hn::Set(d, at[last] - g.motion->centre[last]);
      for (int p = 0; p < kParts; ++p) {
        const V turn = hn::NegMulAdd(gain.angular[last][p], r_next, hn::Mul(gain.angular[next][p], r_last));
        move(n, static_cast<int>(c), p, hn::Add(gain.linear[c][p], turn));
      }
    }
  }
}

// Sums of a measured step by lane, from the scratch of the passes.
struct LaneSums {
  V unbalanced[kParts], kinetic[kParts], moment[kParts], strain[kParts], damping_before[kParts], damping_after[kParts],
      weight_before[kParts], weight_after[kParts];
  V along_before[kParts], along_after[kParts];  // momentum times velocity of the ground, for viscous damping
};

template <Brake kBrake>
HWY_INLINE void measure_group(const GroupData& g, LaneSums* sums) {
  const D d;
  const StepData& step = g.step;
  const V zero = hn::Zero(d), half = hn::Set(d, 0.5), dt = hn::Set(d, step.time_step), half_dt = hn::Mul(half, dt);
  const GroupScratch& s = g.scratch;
  for (int n = 0; n < g.shape.node_count; ++n) {
    const double mass = g.shape.node_mass[static_cast<std::size_t>(n)];
    V squared[kParts];
    for (int p = 0; p < kParts; ++p) squared[p] = zero;
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) {
        const int i = n * kLine + c * kLanes + p * kWidth;
        V weight = hn::Set(d, mass * step.gravity[static_cast<std::size_t>(c)]);
        if (g.load) weight = hn::MulAdd(hn::Set(d, mass), hn::Load(d, g.load + c * kLanes + p * kWidth), weight);
        const V before = hn::Load(d, s.velocity + i), after = hn::Load(d, g.v + i), inertia = inertia_at(g, n, c, p);
        const V damping = hn::Load(d, s.damping + i);
        // The net force contains local damping, the internal force beta K v.
        const V force = kBrake == Brake::gridpoints ? hn::Add(hn::Load(d, s.net + i), damping) : hn::Load(d, s.net + i);
        const V free_force = hn::IfThenElseZero(hn::Ne(inertia, zero), force);
        squared[p] = hn::MulAdd(free_force, free_force, squared[p]);
        sums->kinetic[p] = hn::MulAdd(inertia, hn::Mul(before, after), sums->kinetic[p]);
        if (!step.energies) continue;
        if (kBrake == Brake::mass) {
          const V along = hn::Mul(hn::IfThenElseZero(hn::Ne(inertia, zero), hn::Set(d, mass)),
                                  hn::Set(d, step.ground_velocity[static_cast<std::size_t>(c)]));
          sums->along_before[p] = hn::MulAdd(along, before, sums->along_before[p]);
          sums->along_after[p] = hn::MulAdd(along, after, sums->along_after[p]);
        }
        sums->moment[p] = hn::MulAdd(inertia, hn::Mul(before, before), sums->moment[p]);
        // K u is that of the displacements before this step.
        const V displacement = hn::NegMulAdd(after, dt, hn::Load(d, g.u + i));
        sums->strain[p] = hn::MulAdd(hn::Mul(half, hn::Load(d, s.elastic + i)), displacement, sums->strain[p]);
        if (kBrake != Brake::nothing || step.stiffness_damping != 0.0) {
          sums->damping_before[p] = hn::MulAdd(damping, hn::Mul(before, half_dt), sums->damping_before[p]);
          sums->damping_after[p] = hn::MulAdd(damping, hn::Mul(after, half_dt), sums->damping_after[p]);
        }
        sums->weight_before[p] = hn::MulAdd(weight, hn::Mul(before, half_dt), sums->weight_before[p]);
        sums->weight_after[p] = hn::MulAdd(weight, hn::Mul(after, half_dt), sums->weight_after[p]);
      }
    }
    for (int p = 0; p < kParts; ++p) sums->unbalanced[p] = larger_of(sums->unbalanced[p], squared[p]);
  }
}

// Adds factor x . y to the sum: force times velocity.
HWY_INLINE void add_product(double factor, const Rigid& x, const Rigid& y, V (&sum)[kParts]) {
  const V f = hn::Set(D(), factor);
  for (int p = 0; p < kParts; ++p) {
    for (int c = 0; c < 3; ++c) {
      sum[p] = hn::MulAdd(hn::Mul(x.linear[c][p], f), y.linear[c][p], sum[p]);
      sum[p] = hn::MulAdd(hn::Mul(x.angular[c][p], f), y.angular[c][p], sum[p]);
    }
  }
}

// Adds the last two terms of v M' w to energies; measure_group has summed the first one. Also adds the work of damping
// of rigid motion.
//   v M' w = s_b v M w - (s_b - s_u) (P_b v) M (P_b w) - (s_u - 1) (P_u v) M (P_u w)
template <Brake kBrake>
HWY_INLINE void measure_rigid_motion(const UnitData& unit, const RigidStep& rigid, LaneSums* sums) {
  const StepData& step = unit.step;
  const double half_dt = 0.5 * step.time_step;
  const double s_b = step.deformation_inertia, s_u = unit.count == 1 ? 1.0 : step.unit_inertia;
  // The momenta below contain the factor s_b.
  const double over_b = (s_b - s_u) / (s_b * s_b), over_u = (s_u - 1.0) / (s_b * s_b);
  Rigid before[kUnitBlocks], after[kUnitBlocks];
  for (int b = 0; b < unit.count; ++b) {
    const GroupData& g = unit.blocks[b];
    const auto momentum = [&](int n, int c, int p, V velocity)
                              HWY_ATTR { return hn::Mul(inertia_at(g, n, c, p), velocity); };
    before[b] = rigid_sums(g, g.scratch.velocity, momentum);
    after[b] = rigid_sums(g, g.v, momentum);
    const Rigid motion = over_inertia(*g.motion, before[b]);
    add_product(-over_b, motion, after[b], sums->kinetic);
    add_product(-over_b, motion, before[b], sums->moment);
    if (kBrake == Brake::rigid_motion) {
      const Rigid force = times_inertia(*g.motion, rigid.damping[b]);
      add_product(half_dt / s_b, force, motion, sums->damping_before);
      add_product(half_dt / s_b, force, over_inertia(*g.motion, after[b]), sums->damping_after);
    }
  }
  if (unit.count == 1) return;
  const Rigid motion = motion_of_unit(unit, before);
  for (int b = 0; b < unit.count; ++b) {
    add_product(-over_u, at_block(unit, b, motion), after[b], sums->kinetic);
    add_product(-over_u, at_block(unit, b, motion), before[b], sums->moment);
  }
}

template <Brake kBrake>
HWY_INLINE void measure_unit(const UnitData& unit, const RigidStep& rigid, Measured* measured) {
  const D d;
  LaneSums sums;
  for (int p = 0; p < kParts; ++p) {
    sums.unbalanced[p] = sums.kinetic[p] = sums.moment[p] = sums.strain[p] = sums.damping_before[p] =
        sums.damping_after[p] = sums.weight_before[p] = sums.weight_after[p] = sums.along_before[p] =
            sums.along_after[p] = hn::Zero(d);
  }
  for (int b = 0; b < unit.count; ++b) measure_group<kBrake>(unit.blocks[b], &sums);
  if (unit.motion) measure_rigid_motion<kBrake>(unit, rigid, &sums);
  if (kBrake == Brake::mass) {  // the part alpha M' (v - v of the ground)
    const V factor = hn::Set(d, unit.step.mass_damping * 0.5 * unit.step.time_step);
    for (int p = 0; p < kParts; ++p) {
      sums.damping_before[p] =
          hn::MulAdd(factor, hn::Sub(sums.moment[p], sums.along_before[p]), sums.damping_before[p]);
      sums.damping_after[p] = hn::MulAdd(factor, hn::Sub(sums.kinetic[p], sums.along_after[p]), sums.damping_after[p]);
    }
  }
  alignas(64) double lane[kLanes];
  for (int p = 0; p < kParts; ++p) hn::Store(sums.unbalanced[p], d, lane + p * kWidth);
  measured->unbalanced_squared = 0.0;
  for (double x : lane) measured->unbalanced_squared = larger(measured->unbalanced_squared, x);
  measured->kinetic = 0.5 * sum_lanes(sums.kinetic);
  measured->strain = sum_lanes(sums.strain);
  measured->damping_before = sum_lanes(sums.damping_before);
  measured->damping_after = sum_lanes(sums.damping_after);
  measured->external_before = sum_lanes(sums.weight_before);
  measured->external_after = sum_lanes(sums.weight_after);
}

template <Brake kBrake, bool kMeasure>
HWY_NOINLINE void AdvanceUnitsAs(const Model& model, const UnitGroup& units, const StepData& step, double* scratch,
                                 Measured* measured) {
  const UnitData unit(model, units, step, scratch);
  const bool congruent = unit.count == 2 && &unit.blocks[0].shape == &unit.blocks[1].shape;
  if (congruent && !forces_by_zone(unit.blocks[0])) {
    group_forces<kBrake, kMeasure, 2>(unit.blocks);
  } else {
    for (int b = 0; b < unit.count; ++b) group_forces<kBrake, kMeasure, 1>(&unit.blocks[b]);
  }
  RigidStep rigid;
  if (unit.motion) rigid = rigid_step<kBrake>(unit);
  for (int b = 0; b < unit.count; ++b) integrate_group<kBrake>(unit, b, unit.motion ? &rigid.extra[b] : nullptr);
  if (kMeasure) measure_unit<kBrake>(unit, rigid, measured);
}

void AdvanceUnits(const Model& model, const UnitGroup& units, const StepData& step, double* scratch,
                  Measured* measured) {
  switch (brake_of(step)) {
    case Brake::nothing:
      return measured ? AdvanceUnitsAs<Brake::nothing, true>(model, units, step, scratch, measured)
                      : AdvanceUnitsAs<Brake::nothing, false>(model, units, step, scratch, measured);
    case Brake::gridpoints:
      return measured ? AdvanceUnitsAs<Brake::gridpoints, true>(model, units, step, scratch, measured)
                      : AdvanceUnitsAs<Brake::gridpoints, false>(model, units, step, scratch, measured);
    case Brake::mass:
      return measured ? AdvanceUnitsAs<Brake::mass, true>(model, units, step, scratch, measured)
                      : AdvanceUnitsAs<Brake::mass, false>(model, units, step, scratch, measured);
    case Brake::rigid_motion:
      return measured ? AdvanceUnitsAs<Brake::rigid_motion, true>(model, units, step, scratch, measured)
                      : AdvanceUnitsAs<Brake::rigid_motion, false>(model, units, step, scratch, measured);
  }
}

void InternalForce(const Model& model, const UnitGroup& units, const StepData& step, double* force) {
  const UnitData unit(model, units, step, nullptr);
  if (unit.count == 2) return stiffness_times_u<2>(unit.blocks, force);
  stiffness_times_u<1>(unit.blocks, force);
}

const char* InstructionSet() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin {

HWY_EXPORT(ContactJumps);
HWY_EXPORT(ContactForces);
HWY_EXPORT(AdvanceUnits);
HWY_EXPORT(InternalForce);
HWY_EXPORT(InstructionSet);

void contact_jumps(const Model& model, const ContactChunk& chunk, const StepData& step, ChunkJumps* jumps) {
  HWY_DYNAMIC_DISPATCH(ContactJumps)(model, chunk, step, jumps);
}
void contact_forces(const Model& model, const ContactChunk& chunk, const StepData& step, const double* const* viscous) {
  HWY_DYNAMIC_DISPATCH(ContactForces)(model, chunk, step, viscous);
}
void advance_units(const Model& model, const UnitGroup& units, const StepData& step, double* scratch,
                   Measured* measured) {
  HWY_DYNAMIC_DISPATCH(AdvanceUnits)(model, units, step, scratch, measured);
}
void internal_force(const Model& model, const UnitGroup& units, const StepData& step, double* force) {
  HWY_DYNAMIC_DISPATCH(InternalForce)(model, units, step, force);
}
const char* kernel_instruction_set() { return HWY_DYNAMIC_DISPATCH(InstructionSet)(); }

}  // namespace quoin
#endif
