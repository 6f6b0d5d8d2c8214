// Rigid bodies of a group, one a lane: the same equations as in rigid_bodies.cpp.
#include "step/rigid_bodies.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/body_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/larger.h"
#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {

struct Vector {
  V x[3][kParts];
};

HWY_INLINE void set_zero(Vector& v) {
  for (auto& component : v.x) {
    for (V& part : component) part = hn::Zero(D());
  }
}

// Slots of one face of a group. Either all bodies of the group have contact points there, or none.
struct FaceSlots {
  HWY_INLINE FaceSlots(const Model& model, const BodyGroup& group, std::size_t face) {
    const BodySlots& slots = model.body_slots[static_cast<std::size_t>(group.slots)];
    const std::size_t first = static_cast<std::size_t>(face == 0 ? 0 : slots.face[face - 1].slot_end);
    run = model.slot_run.data() + static_cast<std::size_t>(group.first_slot) + first;
    point = model.slot_point.data() + (static_cast<std::size_t>(group.first_slot) + first) * kLanes;
    arm = slots.arm.data() + first;
    first_value = (static_cast<std::size_t>(group.first_line) + first) * kLine;
    count = slots.face[face].slot_end - static_cast<int>(first);
    if (count > 0 && *run == Model::kEmptySlot) count = 0;
    normal_arm = slots.face[face].normal_arm;
  }
  const std::int32_t* run;
  const std::int32_t* point;
  const std::array<double, 2>* arm;
  std::size_t first_value;  // index of the first value of the first slot, lane layout
  int count;
  double normal_arm;
};

// Adds the force and the moment about the centre of one face's contact points, in the order of the slots.
template <std::size_t kAxis>
HWY_INLINE void add_face(const Model& model, const BodyGroup& group, const StepData& step, bool side_a,
                         Vector* force_sum, Vector* moment_sum) {
  constexpr std::size_t n = kAxis, s = (n + 1) % 3, t = (n + 2) % 3;
  const D d;
  const FaceSlots slots(model, group, 2 * n + (side_a ? 1 : 0));
  if (slots.count == 0) return;
  const double* const force[3] = {step.force[0], step.force[1], step.force[2]};
  Vector f, m;
  set_zero(f);
  set_zero(m);
  for (int i = 0; i < slots.count; ++i) {
    const V arm_s = hn::Set(d, slots.arm[i][0]), arm_t = hn::Set(d, slots.arm[i][1]);
    const auto add = [&](int p, V f_n, V f_s, V f_t) HWY_ATTR {
      f.x[n][p] = hn::Add(f.x[n][p], f_n);
      f.x[s][p] = hn::Add(f.x[s][p], f_s);
      f.x[t][p] = hn::Add(f.x[t][p], f_t);
      m.x[n][p] = hn::NegMulAdd(arm_t, f_s, hn::MulAdd(arm_s, f_t, m.x[n][p]));
      m.x[s][p] = hn::MulAdd(arm_t, f_n, m.x[s][p]);
      m.x[t][p] = hn::NegMulAdd(arm_s, f_n, m.x[t][p]);
    };
    const std::int32_t run = slots.run[i];
    if (run >= 0) {
      for (int p = 0; p < kParts; ++p) {
        const std::ptrdiff_t at = run + p * kWidth;
        add(p, hn::LoadU(d, force[n] + at), hn::LoadU(d, force[s] + at), hn::LoadU(d, force[t] + at));
      }
    } else {
      for (int p = 0; p < kParts; ++p) {
        const std::int32_t* point = slots.point + i * kLanes + p * kWidth;
        add(p, gather(d, force[n], point), gather(d, force[s], point), gather(d, force[t], point));
      }
    }
  }
  const V arm_n = hn::Set(d, slots.normal_arm), side = hn::Set(d, side_a ? 1.0 : -1.0);
  for (int p = 0; p < kParts; ++p) {
    m.x[s][p] = hn::NegMulAdd(arm_n, f.x[t][p], m.x[s][p]);
    m.x[t][p] = hn::MulAdd(arm_n, f.x[s][p], m.x[t][p]);
    for (std::size_t c = 0; c < 3; ++c) {
      force_sum->x[c][p] = hn::MulAdd(side, f.x[c][p], force_sum->x[c][p]);
      moment_sum->x[c][p] = hn::MulAdd(side, m.x[c][p], moment_sum->x[c][p]);
    }
  }
}

HWY_INLINE void sum_contact_forces(const Model& model, const BodyGroup& group, const StepData& step, Vector* force,
                                   Vector* moment) {
  set_zero(*force);
  set_zero(*moment);
  for (const bool side_a : {false, true}) {
    add_face<0>(model, group, step, side_a, force, moment);
    add_face<1>(model, group, step, side_a, force, moment);
    add_face<2>(model, group, step, side_a, force, moment);
  }
}

// Sets the motion of the slots of one face, translation + rotation x arm: displacement along the normal, velocity
// across it.
template <std::size_t kAxis>
HWY_INLINE void move_face(const Model& model, const BodyGroup& group, const StepData& step, bool side_a,
                          const BodyLanes& body) {
  constexpr std::size_t n = kAxis, s = (n + 1) % 3, t = (n + 2) % 3;
  const D d;
  const FaceSlots slots(model, group, 2 * n + (side_a ? 1 : 0));
  if (slots.count == 0) return;
  const V arm_n = hn::Set(d, slots.normal_arm);
  for (int p = 0; p < kParts; ++p) {
    const auto lanes = [p](const double(&value)[kLanes]) HWY_ATTR { return hn::Load(D(), value + p * kWidth); };
    const V spin_n = lanes(body.spin[n]);
    const V velocity_s = hn::MulAdd(lanes(body.spin[t]), arm_n, lanes(body.velocity[s]));
    const V velocity_t = hn::NegMulAdd(lanes(body.spin[s]), arm_n, lanes(body.velocity[t]));
    const V rotation_s = lanes(body.rotation[s]), rotation_t = lanes(body.rotation[t]);
    const V displacement_n = lanes(body.displacement[n]);
    double* moved = step.displacement + slots.first_value + p * kWidth;
    double* moving = step.velocity + slots.first_value + p * kWidth;
    for (int i = 0; i < slots.count; ++i, moved += kLine, moving += kLine) {
      const V arm_s = hn::Set(d, slots.arm[i][0]), arm_t = hn::Set(d, slots.arm[i][1]);
      const V turned = hn::NegMulAdd(rotation_t, arm_s, hn::MulAdd(rotation_s, arm_t, displacement_n));
      hn::Store(turned, d, moved + n * kLanes);
      hn::Store(hn::NegMulAdd(spin_n, arm_t, velocity_s), d, moving + s * kLanes);
      hn::Store(hn::MulAdd(spin_n, arm_s, velocity_t), d, moving + t * kLanes);
    }
  }
}

HWY_INLINE void move_slaves(const Model& model, const BodyGroup& group, const StepData& step, const BodyLanes& body) {
  for (const bool side_a : {false, true}) {
    move_face<0>(model, group, step, side_a, body);
    move_face<1>(model, group, step, side_a, body);
    move_face<2>(model, group, step, side_a, body);
  }
}

// Equation 1: the damping force of one degree of freedom.
template <Brake kBrake>
HWY_INLINE V damping_force(const StepData& step, V force, V inertia, V velocity) {
  const D d;
  if (kBrake == Brake::gridpoints) return local_damping(hn::Set(d, step.local_damping), force, velocity);
  if (kBrake == Brake::mass) return hn::Mul(hn::Mul(hn::Set(d, step.mass_damping), inertia), velocity);
  return hn::Zero(d);
}

// Fields of Measured, by lane.
struct LaneWork {
  V unbalanced[kParts], kinetic[kParts];
  V damping_before[kParts], damping_after[kParts], external_before[kParts], external_after[kParts];
};

// Advances a degree of freedom by a step. Returns its new velocity, and adds the work in measured steps.
template <Brake kBrake, bool kMeasure>
HWY_INLINE V advance_component(const BodyGroupInertia& lanes, const StepData& step, std::size_t dof, int p,
                               V joint_force, V given, V before, V prescribed, hn::Mask<D> is_prescribed,
                               LaneWork* work) {
  const D d;
  const V zero = hn::Zero(d), inertia = hn::Load(d, lanes.inertia[dof] + p * kWidth);
  const V dt_over_inertia = hn::Load(d, lanes.dt_over_inertia[dof] + p * kWidth);  // 0 where held
  const V net = hn::Add(joint_force, given);
  const V ground = hn::Set(d, dof < 3 ? step.ground_velocity[dof] : 0.0);
  const V damping = damping_force<kBrake>(step, net, inertia, hn::Sub(before, ground));
  const V free = hn::MulAdd(hn::Sub(net, damping), dt_over_inertia, before);
  const V after = hn::IfThenElse(is_prescribed, prescribed, free);
  if (!kMeasure) return after;

  // A support does the work that the joints take from it.
  const V half_dt = hn::Set(d, 0.5 * step.time_step);
  const auto is_free = hn::AndNot(is_prescribed, hn::Ne(dt_over_inertia, zero));
  const V external =
      hn::Mul(half_dt, hn::IfThenElse(is_prescribed, hn::Neg(joint_force), hn::IfThenElseZero(is_free, given)));
  const V damped = hn::Mul(half_dt, hn::IfThenElseZero(is_free, damping));
  work->external_before[p] = hn::MulAdd(external, before, work->external_before[p]);
  work->external_after[p] = hn::MulAdd(external, after, work->external_after[p]);
  work->damping_before[p] = hn::MulAdd(damped, before, work->damping_before[p]);
  work->damping_after[p] = hn::MulAdd(damped, after, work->damping_after[p]);
  const V momentum = hn::Mul(hn::Mul(hn::Set(d, 0.5), inertia), before);
  work->kinetic[p] = hn::MulAdd(hn::IfThenElseZero(is_free, momentum), after, work->kinetic[p]);
  const V unbalanced = hn::IfThenElseZero(is_free, net);
  if (dof < 3) work->unbalanced[p] = hn::MulAdd(unbalanced, unbalanced, work->unbalanced[p]);
  return after;
}

template <Brake kBrake, bool kMeasure>
HWY_NOINLINE void AdvanceBodiesAs(const Model& model, const BodyGroup& group, const BodyGroupInertia& inertia,
                                  const StepData& step, BodyLanes* state, LaneWork* work) {
  const D d;
  const V zero = hn::Zero(d), dt = hn::Set(d, step.time_step);
  BodyLanes& bodies = *state;
  Vector force, moment;
  sum_contact_forces(model, group, step, &force, &moment);
  for (std::size_t c = 0; c < 3; ++c) {
    for (int p = 0; p < kParts; ++p) {
      const int lane = p * kWidth;
      const auto prescribed = [&](std::size_t dof) HWY_ATTR {
        return bodies.any_prescribed ? hn::Ne(hn::Load(d, bodies.prescribed[dof] + lane), zero) : hn::Ne(zero, zero);
      };
      const auto advance = [&](std::size_t dof, V joint_force, V given, V driven, double* velocity,
                               double* displacement) HWY_ATTR {
        const V after = advance_component<kBrake, kMeasure>(inertia, step, dof, p, joint_force, given,
                                                            hn::Load(d, velocity), driven, prescribed(dof), work);
        hn::Store(after, d, velocity);
        hn::Store(hn::MulAdd(dt, after, hn::Load(d, displacement)), d, displacement);
      };
      const V mass = hn::Load(d, inertia.weighing_mass + lane),
              driven = hn::Load(d, bodies.prescribed_velocity[c] + lane);
      const V given = hn::MulAdd(mass, hn::Set(d, step.gravity[c]), hn::Load(d, bodies.applied_force[c] + lane));
      advance(c, force.x[c][p], given, driven, bodies.velocity[c] + lane, bodies.displacement[c] + lane);
      const V spin = hn::Load(d, bodies.spin[c] + lane);  // where it is prescribed, it is set before the step
      const V turning = hn::Load(d, bodies.applied_moment[c] + lane);
      advance(3 + c, moment.x[c][p], turning, spin, bodies.spin[c] + lane, bodies.rotation[c] + lane);
    }
  }
  move_slaves(model, group, step, bodies);
}

template <Brake kBrake>
void AdvanceBodiesAndMeasure(const Model& model, const BodyGroup& group, const BodyGroupInertia& inertia,
                             const StepData& step, BodyLanes* state, Measured* measured) {
  if (!measured) return AdvanceBodiesAs<kBrake, false>(model, group, inertia, step, state, nullptr);
  LaneWork work;
  for (V(*sum)[kParts] : {&work.unbalanced, &work.kinetic, &work.damping_before, &work.damping_after,
                          &work.external_before, &work.external_after}) {
    for (V& part : *sum) part = hn::Zero(D());
  }
  AdvanceBodiesAs<kBrake, true>(model, group, inertia, step, state, &work);
  const auto in_lanes = [](const V(&x)[kParts], double(&lanes)[kLanes]) HWY_ATTR {
    for (int p = 0; p < kParts; ++p) hn::StoreU(x[p], D(), lanes + p * kWidth);
  };
  const auto sum = [&](const V(&x)[kParts]) HWY_ATTR {
    double lanes[kLanes], total = 0.0;
    in_lanes(x, lanes);
    for (int i = 0; i < group.body_count; ++i) total += lanes[i];
    return total;
  };
  *measured = {};
  double unbalanced[kLanes];
  in_lanes(work.unbalanced, unbalanced);
  for (int i = 0; i < group.body_count; ++i)
    measured->unbalanced_squared = larger(measured->unbalanced_squared, unbalanced[i]);
  measured->kinetic = sum(work.kinetic);
  measured->damping_before = sum(work.damping_before);
  measured->damping_after = sum(work.damping_after);
  measured->external_before = sum(work.external_before);
  measured->external_after = sum(work.external_after);
}

void AdvanceBodies(const Model& model, const BodyGroup& group, const BodyGroupInertia& inertia, const StepData& step,
                   BodyLanes* state, Measured* measured) {
  switch (brake_of(step)) {
    case Brake::nothing:
      return AdvanceBodiesAndMeasure<Brake::nothing>(model, group, inertia, step, state, measured);
    case Brake::gridpoints:
    case Brake::rigid_motion:
      return AdvanceBodiesAndMeasure<Brake::gridpoints>(model, group, inertia, step, state, measured);
    case Brake::mass:
      return AdvanceBodiesAndMeasure<Brake::mass>(model, group, inertia, step, state, measured);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin {

HWY_EXPORT(AdvanceBodies);

void advance_bodies(const Model& model, const BodyGroup& group, const BodyGroupInertia& inertia, const StepData& step,
                    BodyLanes* state, Measured* measured) {
  HWY_DYNAMIC_DISPATCH(AdvanceBodies)(model, group, inertia, step, state, measured);
}

BodyGroupInertia inertia_of(const BodyGroup& group, const Model& model, const Inertia& inertia, double time_step) {
  BodyGroupInertia lanes;
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane), b = static_cast<std::size_t>(group.body[i]);
    lanes.weighing_mass[i] = model.bodies[b].mass;
    for (std::size_t dof = 0; dof < 6; ++dof) {
      lanes.inertia[dof][i] = dof < 3 ? inertia.body_mass[b] : inertia.body_inertia[b][dof - 3];
      const bool moves = lane < group.body_count && !model.bodies[b].held[dof];
      lanes.dt_over_inertia[dof][i] = moves ? time_step / lanes.inertia[dof][i] : 0.0;
    }
  }
  return lanes;
}

}  // namespace quoin
#endif
