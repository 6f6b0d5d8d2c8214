// Rigid bodies that are alike, one a lane: the same equations as in rigid_bodies.cpp.
#include "step/state.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/body_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "step/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {

struct Vector {
  V x[3];
};

HWY_INLINE Vector zero_vector() { return {{hn::Zero(D()), hn::Zero(D()), hn::Zero(D())}}; }

// What one part of the lanes of a group works on.
struct Part {
  const BodyGroup& group;
  const BodySlots& slots;
  const BodyGroupLanes& lanes;
  const StepData& step;
  BodyState* bodies;
  int first_lane;

  HWY_INLINE V in_lanes(const double (&value)[kLanes]) const { return hn::Load(D(), value + first_lane); }

  HWY_INLINE Vector read(Vec3 BodyState::*quantity) const {
    Vector v;
    for (std::size_t c = 0; c < 3; ++c)
      v.x[c] = gather(D(), (bodies->*quantity).data() + c, lanes.state_offset + first_lane);
    return v;
  }

  HWY_INLINE void write(const Vector& v, Vec3 BodyState::*quantity) const {
    alignas(64) double x[3][kWidth];
    for (int c = 0; c < 3; ++c) hn::Store(v.x[c], D(), x[c]);
    for (int i = 0; i < kWidth && first_lane + i < group.body_count; ++i)
      bodies[group.body[static_cast<std::size_t>(first_lane + i)]].*quantity = {x[0][i], x[1][i], x[2][i]};
  }
};

// Force of the contact points and its moment about the centre, in the order of the slots.
HWY_INLINE void sum_contact_forces(const Model& model, const Part& part, Vector* force_sum, Vector* moment_sum) {
  const D d;
  const double* force[3] = {part.step.force[0], part.step.force[1], part.step.force[2]};
  const std::int32_t* point = model.slot_point.data() + part.group.first_slot * kLanes + part.first_lane;
  const std::int32_t* run = model.slot_run.data() + part.group.first_slot;
  const double* sign = part.slots.sign.data();
  const Vec3* arm = part.slots.arm.data();
  Vector sum = zero_vector(), moment = zero_vector();
  const int slot_count = part.slots.slot_count();
  for (int i = 0; i < slot_count; ++i, point += kLanes) {
    if (run[i] == Model::kEmptySlot) continue;
    Vector f;
    for (int c = 0; c < 3; ++c)
      f.x[c] = run[i] >= 0 ? hn::LoadU(d, force[c] + run[i] + part.first_lane) : gather(d, force[c], point);
    const V side = hn::Set(d, sign[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
      const V turning = hn::MulSub(hn::Set(d, arm[i][next]), f.x[last], hn::Mul(hn::Set(d, arm[i][last]), f.x[next]));
      sum.x[c] = hn::MulAdd(side, f.x[c], sum.x[c]);
      moment.x[c] = hn::MulAdd(side, turning, moment.x[c]);
    }
  }
  *force_sum = sum;
  *moment_sum = moment;
}

// translation + rotation x arm, at every slot into the lane layout.
HWY_INLINE void move_slaves(const Model& model, const Part& part, const Vector& translation, const Vector& rotation,
                            double* field) {
  const D d;
  double* line = field + static_cast<std::size_t>(part.group.first_line) * kLine + part.first_lane;
  const std::int32_t* run = model.slot_run.data() + part.group.first_slot;
  const Vec3* arm = part.slots.arm.data();
  const int slot_count = part.slots.slot_count();
  for (int i = 0; i < slot_count; ++i, line += kLine) {
    if (run[i] == Model::kEmptySlot) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
      const V turn = hn::NegMulAdd(rotation.x[last], hn::Set(d, arm[i][next]),
                                   hn::MulAdd(rotation.x[next], hn::Set(d, arm[i][last]), translation.x[c]));
      hn::Store(turn, d, line + c * kLanes);
    }
  }
}

// Equation 1: the damping force of one degree of freedom.
HWY_INLINE V damping_force(const StepData& step, V force, V inertia, V velocity) {
  const D d;
  switch (step.damping) {
    case DampingKind::local:
    case DampingKind::block:
      return local_damping(hn::Set(d, step.local_damping), force, velocity);
    case DampingKind::viscous:
      return hn::Mul(hn::Mul(hn::Set(d, step.mass_damping), inertia), velocity);
    case DampingKind::none:
      break;
  }
  return hn::Zero(d);
}

// Sums of a measured step by lane; the fields of Measured.
struct LaneWork {
  alignas(64) double unbalanced[kLanes], kinetic[kLanes];
  alignas(64) double damping_before[kLanes], damping_after[kLanes], external_before[kLanes], external_after[kLanes];
};

struct PartWork {
  V unbalanced, kinetic;
  V damping_before, damping_after, external_before, external_after;
};

// A degree of freedom through a step: its new velocity, and the work if somebody asks.
HWY_INLINE V advance_component(const Part& part, std::size_t dof, V joint_force, V given, V before, V prescribed,
                               hn::Mask<D> is_prescribed, PartWork* work) {
  const D d;
  const V zero = hn::Zero(d), inertia = part.in_lanes(part.lanes.inertia[dof]);
  const V dt_over_inertia = part.in_lanes(part.lanes.dt_over_inertia[dof]);  // 0 where held
  const V net = hn::Add(joint_force, given);
  const V damping = damping_force(part.step, net, inertia, before);
  const V free = hn::MulAdd(hn::Sub(net, damping), dt_over_inertia, before);
  const V after = hn::IfThenElse(is_prescribed, prescribed, free);
  if (!work) return after;

  // A support does the work that the joints take from it.
  const V half_dt = hn::Set(d, 0.5 * part.step.time_step);
  const auto is_free = hn::AndNot(is_prescribed, hn::Ne(dt_over_inertia, zero));
  const V external =
      hn::Mul(half_dt, hn::IfThenElse(is_prescribed, hn::Neg(joint_force), hn::IfThenElseZero(is_free, given)));
  const V damped = hn::Mul(half_dt, hn::IfThenElseZero(is_free, damping));
  work->external_before = hn::MulAdd(external, before, work->external_before);
  work->external_after = hn::MulAdd(external, after, work->external_after);
  work->damping_before = hn::MulAdd(damped, before, work->damping_before);
  work->damping_after = hn::MulAdd(damped, after, work->damping_after);
  const V momentum = hn::Mul(hn::Mul(hn::Set(d, 0.5), inertia), before);
  work->kinetic = hn::MulAdd(hn::IfThenElseZero(is_free, momentum), after, work->kinetic);
  const V unbalanced = hn::IfThenElseZero(is_free, net);
  if (dof < 3) work->unbalanced = hn::MulAdd(unbalanced, unbalanced, work->unbalanced);
  return after;
}

// 1 in the lanes whose control prescribes a degree of freedom.
struct ControlLanes {
  alignas(64) double prescribed[6][kLanes];
  bool any = false;

  ControlLanes(const BodyGroup& group, const BodyState* bodies) {
    for (int body : group.body) {
      for (bool on : bodies[body].prescribed) any = any || on;
    }
    if (!any) return;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      for (std::size_t dof = 0; dof < 6; ++dof)
        prescribed[dof][lane] = bodies[group.body[lane]].prescribed[dof] ? 1.0 : 0.0;
    }
  }
};

HWY_INLINE void advance_part(const Model& model, const Part& part, const ControlLanes& controls, LaneWork* lane_work) {
  const D d;
  const V zero = hn::Zero(d);
  PartWork sums{zero, zero, zero, zero, zero, zero};
  PartWork* const work = lane_work ? &sums : nullptr;
  const auto controlled = [&](std::size_t dof) HWY_ATTR {
    return controls.any ? hn::Ne(part.in_lanes(controls.prescribed[dof]), zero) : hn::Ne(zero, zero);
  };

  Vector force, moment;
  sum_contact_forces(model, part, &force, &moment);
  part.write(force, &BodyState::joint_force);

  Vector velocity = part.read(&BodyState::velocity), spin = part.read(&BodyState::spin);
  const Vector applied = part.read(&BodyState::applied_force);
  const Vector driven = controls.any ? part.read(&BodyState::prescribed_velocity) : zero_vector();
  const V mass = part.in_lanes(part.lanes.weighing_mass);
  for (std::size_t c = 0; c < 3; ++c) {
    const V given = hn::MulAdd(mass, hn::Set(d, part.step.gravity[c]), applied.x[c]);
    velocity.x[c] = advance_component(part, c, force.x[c], given, velocity.x[c], driven.x[c], controlled(c), work);
    spin.x[c] = advance_component(part, 3 + c, moment.x[c], zero, spin.x[c], zero, controlled(3 + c), work);
  }
  Vector displacement = part.read(&BodyState::displacement), rotation = part.read(&BodyState::rotation);
  const V dt = hn::Set(d, part.step.time_step);
  for (int c = 0; c < 3; ++c) {
    displacement.x[c] = hn::MulAdd(dt, velocity.x[c], displacement.x[c]);
    rotation.x[c] = hn::MulAdd(dt, spin.x[c], rotation.x[c]);
  }
  part.write(velocity, &BodyState::velocity);
  part.write(spin, &BodyState::spin);
  part.write(displacement, &BodyState::displacement);
  part.write(rotation, &BodyState::rotation);
  move_slaves(model, part, velocity, spin, part.step.velocity);
  move_slaves(model, part, displacement, rotation, part.step.displacement);

  if (!lane_work) return;
  hn::Store(sums.unbalanced, d, lane_work->unbalanced + part.first_lane);
  hn::Store(sums.kinetic, d, lane_work->kinetic + part.first_lane);
  hn::Store(sums.damping_before, d, lane_work->damping_before + part.first_lane);
  hn::Store(sums.damping_after, d, lane_work->damping_after + part.first_lane);
  hn::Store(sums.external_before, d, lane_work->external_before + part.first_lane);
  hn::Store(sums.external_after, d, lane_work->external_after + part.first_lane);
}

void AdvanceBodies(const Model& model, const BodyGroup& group, const BodyGroupLanes& lanes, const StepData& step,
                   BodyState* bodies, Measured* measured) {
  const BodySlots& slots = model.body_slots[static_cast<std::size_t>(group.slots)];
  const ControlLanes controls(group, bodies);
  LaneWork work;
  for (int lane = 0; lane < group.body_count; lane += kWidth)
    advance_part(model, {group, slots, lanes, step, bodies, lane}, controls, measured ? &work : nullptr);
  if (!measured) return;
  *measured = {};
  for (int lane = 0; lane < group.body_count; ++lane) {
    // Written so that a NaN stays.
    if (!(work.unbalanced[lane] <= measured->unbalanced_squared)) measured->unbalanced_squared = work.unbalanced[lane];
    measured->kinetic += work.kinetic[lane];
    measured->damping_before += work.damping_before[lane];
    measured->damping_after += work.damping_after[lane];
    measured->external_before += work.external_before[lane];
    measured->external_after += work.external_after[lane];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin {

HWY_EXPORT(AdvanceBodies);

void advance_bodies(const Model& model, const BodyGroup& group, const BodyGroupLanes& lanes, const StepData& step,
                    BodyState* bodies, Measured* measured) {
  HWY_DYNAMIC_DISPATCH(AdvanceBodies)(model, group, lanes, step, bodies, measured);
}

BodyGroupLanes lanes_of(const BodyGroup& group, const Model& model, const Inertia& inertia, double time_step) {
  static_assert(sizeof(BodyState) % sizeof(double) == 0, "the same component of all bodies is a whole number apart");
  BodyGroupLanes lanes;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const auto b = static_cast<std::size_t>(group.body[lane]);
    lanes.weighing_mass[lane] = model.bodies[b].mass;
    for (std::size_t dof = 0; dof < 6; ++dof) {
      lanes.inertia[dof][lane] = dof < 3 ? inertia.body_mass[b] : inertia.body_inertia[b][dof - 3];
      lanes.dt_over_inertia[dof][lane] = model.bodies[b].held[dof] ? 0.0 : time_step / lanes.inertia[dof][lane];
    }
    lanes.state_offset[lane] = group.body[lane] * static_cast<std::int32_t>(sizeof(BodyState) / sizeof(double));
  }
  return lanes;
}

}  // namespace quoin
#endif
