#include "step/kernels.h"

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

// Adds the columns of one run: each displacement is loaded once and serves the rows that the mask names.
template <unsigned kMask>
HWY_INLINE void add_run(const std::int32_t*& column, const std::int32_t* end, const double*& coefficient,
                        const double* w, V (&f)[3][kParts]) {
  const D d;
  for (; column < end; ++column) {
    V x[kParts];
    for (int p = 0; p < kParts; ++p) x[p] = hn::Load(d, w + *column + p * kWidth);
    for (unsigned c = 0; c < 3; ++c) {
      if (!(kMask >> c & 1u)) continue;
      const V k = hn::Set(d, *coefficient++);
      for (int p = 0; p < kParts; ++p) f[c][p] = hn::MulAdd(k, x[p], f[c][p]);
    }
  }
}

// Walks the rows of a template: next() gives K w of the next gridpoint.
struct StiffnessRows {
  explicit StiffnessRows(const BrickTemplate& shape)
      : columns(shape.column.data()),
        column(columns),
        run_end(shape.run_end.data()),
        coefficient(shape.coefficient.data()) {}

  HWY_INLINE void next(const double* w, V (&f)[3][kParts]) {
    for (auto& row : f) {
      for (V& part : row) part = hn::Zero(D());
    }
    add_run<1>(column, columns + run_end[0], coefficient, w, f);
    add_run<2>(column, columns + run_end[1], coefficient, w, f);
    add_run<3>(column, columns + run_end[2], coefficient, w, f);
    add_run<4>(column, columns + run_end[3], coefficient, w, f);
    add_run<5>(column, columns + run_end[4], coefficient, w, f);
    add_run<6>(column, columns + run_end[5], coefficient, w, f);
    add_run<7>(column, columns + run_end[6], coefficient, w, f);
    run_end += 7;
  }

  const std::int32_t* columns;
  const std::int32_t* column;
  const std::int32_t* run_end;
  const double* coefficient;
};

// Sums lanes 0 .. 7 in this order.
HWY_INLINE double sum_lanes(const V (&x)[kParts]) {
  alignas(64) double lane[kLanes];
  for (int p = 0; p < kParts; ++p) hn::Store(x[p], D(), lane + p * kWidth);
  double sum = 0.0;
  for (double value : lane) sum += value;
  return sum;
}

template <DampingKind kDamping, bool kMeasure>
HWY_NOINLINE void AdvanceGroupAs(const Model& model, const BlockGroup& group, const StepData& step, double* scratch,
                                 Measured* measured) {
  const D d;
  const std::size_t first = static_cast<std::size_t>(group.first_line) * kLine;
  const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
  const ContactSlots& slots = model.slots[static_cast<std::size_t>(group.brick_template)];
  const std::int32_t* slot_point = model.slot_point.data() + static_cast<std::size_t>(group.first_slot) * kLanes;
  const std::int32_t* slot_run = model.slot_run.data() + group.first_slot;
  double* HWY_RESTRICT u = step.displacement + first;
  double* HWY_RESTRICT v = step.velocity + first;
  const double* HWY_RESTRICT dt_over_mass = step.dt_over_mass + first;
  const int doubles = shape.node_count * kLine;
  const V dt = hn::Set(d, step.time_step), zero = hn::Zero(d), half = hn::Set(d, 0.5);

  // Stiffness-proportional damping acts like the stiffness on u + beta v.
  const bool stiffness_damping = kDamping == DampingKind::viscous && step.stiffness_damping != 0.0;
  const double* w = u;
  if (stiffness_damping) {
    const V beta = hn::Set(d, step.stiffness_damping);
    for (int i = 0; i < doubles; i += kWidth) {
      hn::Store(hn::MulAdd(beta, hn::Load(d, v + i), hn::Load(d, u + i)), d, scratch + i);
    }
    w = scratch;
  }

  V unbalanced[kParts], kinetic[kParts], strain[kParts], damping_before[kParts], damping_after[kParts],
      weight_before[kParts], weight_after[kParts];
  if (kMeasure) {
    for (int p = 0; p < kParts; ++p) {
      unbalanced[p] = kinetic[p] = strain[p] = damping_before[p] = damping_after[p] = weight_before[p] =
          weight_after[p] = zero;
    }
  }

  StiffnessRows rows(shape), elastic_rows(shape);
  int slot = 0;
  for (int n = 0; n < shape.node_count; ++n) {
    V f[3][kParts];
    rows.next(w, f);
    V elastic[3][kParts], damped[3][kParts];  // K u alone, and beta K v
    if (kMeasure) {
      elastic_rows.next(u, elastic);
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) damped[c][p] = hn::Sub(f[c][p], elastic[c][p]);
      }
    }

    // Nodal forces: - K u, contact points in the order of the slots, weight.
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) f[c][p] = hn::Neg(f[c][p]);
    }
    for (; slot < slots.slot_end[static_cast<std::size_t>(n)]; ++slot) {
      const V sign = hn::Set(d, slots.sign[static_cast<std::size_t>(slot)]);
      const std::int32_t* point = slot_point + slot * kLanes;
      const std::int32_t run = slot_run[slot];
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p) {
          const double* force = step.force[c];
          const V along = run >= 0 ? hn::LoadU(d, force + run + p * kWidth) : gather(d, force, point + p * kWidth);
          f[c][p] = hn::MulAdd(sign, along, f[c][p]);
        }
      }
    }
    const double mass = shape.node_mass[static_cast<std::size_t>(n)];
    for (int c = 0; c < 3; ++c) {
      const V weight = hn::Set(d, mass * step.gravity[static_cast<std::size_t>(c)]);
      for (int p = 0; p < kParts; ++p) f[c][p] = hn::Add(f[c][p], weight);
    }

    // Equation 1: v += (F - Fd) dt/m.
    V squared[kParts];
    for (int p = 0; kMeasure && p < kParts; ++p) squared[p] = zero;
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < kParts; ++p) {
        const int i = n * kLine + c * kLanes + p * kWidth;
        const V before = hn::Load(d, v + i), scale = hn::Load(d, dt_over_mass + i);
        V force = f[c][p], damping = zero, after;
        if (kDamping == DampingKind::local) {
          // Fd = gamma |F| sgn(v), sgn(0) = +1
          const V amount = hn::Mul(hn::Set(d, step.local_damping), hn::Abs(force));
          damping = hn::IfThenElse(hn::Lt(before, zero), hn::Neg(amount), amount);
          after = hn::MulAdd(hn::Sub(force, damping), scale, before);
        } else if (kDamping == DampingKind::viscous) {
          // The part alpha m v needs no mass: alpha m v dt/m = alpha dt v.
          after = hn::MulAdd(force, scale, hn::NegMulAdd(hn::Mul(hn::Set(d, step.mass_damping), dt), before, before));
        } else {
          after = hn::MulAdd(force, scale, before);
        }
        hn::Store(after, d, v + i);

        if (kMeasure) {
          const auto moves = hn::Ne(scale, zero);
          if (kDamping == DampingKind::viscous) {
            const V inertia = hn::IfThenElseZero(moves, hn::Div(dt, scale));
            damping = hn::MulAdd(hn::Mul(hn::Set(d, step.mass_damping), inertia), before, damped[c][p]);
          }
          const V free_force = hn::IfThenElseZero(moves, force);
          squared[p] = hn::MulAdd(free_force, free_force, squared[p]);
          const V mass_in_use = hn::IfThenElseZero(moves, hn::Div(dt, scale));
          kinetic[p] = hn::MulAdd(hn::Mul(half, mass_in_use), hn::Mul(before, after), kinetic[p]);
          strain[p] = hn::MulAdd(hn::Mul(half, elastic[c][p]), hn::Load(d, u + i), strain[p]);
          const V half_dt = hn::Mul(half, dt);
          const V weight = hn::Set(d, mass * step.gravity[static_cast<std::size_t>(c)]);
          damping_before[p] = hn::MulAdd(damping, hn::Mul(before, half_dt), damping_before[p]);
          damping_after[p] = hn::MulAdd(damping, hn::Mul(after, half_dt), damping_after[p]);
          weight_before[p] = hn::MulAdd(weight, hn::Mul(before, half_dt), weight_before[p]);
          weight_after[p] = hn::MulAdd(weight, hn::Mul(after, half_dt), weight_after[p]);
        }
      }
    }
    for (int p = 0; kMeasure && p < kParts; ++p) unbalanced[p] = hn::Max(unbalanced[p], squared[p]);
  }

  for (int i = 0; i < doubles; i += kWidth) hn::Store(hn::MulAdd(hn::Load(d, v + i), dt, hn::Load(d, u + i)), d, u + i);

  if (kMeasure) {
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
