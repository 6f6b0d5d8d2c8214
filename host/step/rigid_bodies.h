// Rigid bodies in small rotations: lone ones, and groups of up to eight, one a lane.
#pragma once

#include <cstdint>

#include "model/model.h"
#include "model/time_step.h"
#include "step/kernels.h"

namespace quoin {

// State of rigid bodies, one a lane: those of a group, or a lone one in lane 0. Rotations are small: a vector.
struct BodyLanes {
  using Quantity = double[3][kLanes];
  alignas(64) Quantity displacement = {}, rotation = {};  // m, rad
  Quantity velocity = {}, spin = {};                      // at t - dt/2, m/s, rad/s

  // Controls of this step.
  Quantity applied_force = {};        // N
  Quantity applied_moment = {};       // about the centre of mass, N m
  Quantity prescribed_velocity = {};  // m/s
  double prescribed[6][kLanes] = {};  // 1: prescribed velocity of a translation, or `spin` of a rotation; else 0
  std::uint64_t any_prescribed = 0;   // 1: some components are prescribed
  std::uint64_t at_rest = 0;          // 1: all are held at rest: a step changes nothing
  std::uint64_t unused[6] = {};       // see base/archive.h
};

// Constants of the bodies of a group, by lane.
struct BodyGroupInertia {
  alignas(64) double weighing_mass[kLanes];       // kg, without scaling
  alignas(64) double inertia[6][kLanes];          // kg, kg m2
  alignas(64) double dt_over_inertia[6][kLanes];  // 0 where held, and in lanes without a body
};
BodyGroupInertia inertia_of(const BodyGroup& group, const Model& model, const Inertia& inertia, double time_step);

// Advances the body of lane 0 by a step: sums of contact forces, prescribed or free motion, then its gridpoints. All
// sums have a fixed order.
void advance_body(const RigidBody& body, double mass, const Vec3& inertia, const StepData& step, BodyLanes* state,
                  Measured* measured);
// Advances the bodies of a group, one a lane. Of gridpoints it writes only what the joints of their faces read:
// displacement along the normal, velocity across it.
void advance_bodies(const Model& model, const BodyGroup& group, const BodyGroupInertia& inertia, const StepData& step,
                    BodyLanes* state, Measured* measured);

}  // namespace quoin
