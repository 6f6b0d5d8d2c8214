// Rigid bodies of small rotations, alone or eight of a group side by side.
#pragma once

#include "model/model.h"
#include "model/time_step.h"
#include "step/kernels.h"

namespace quoin {

// Rigid bodies in motion, one a lane: those of a group, or a lone one in lane 0. Rotations are small: a vector.
struct BodyLanes {
  using Quantity = double[3][kLanes];
  alignas(64) Quantity displacement = {}, rotation = {};  // m, rad
  Quantity velocity = {}, spin = {};                      // m/s, rad/s; of half a step ago

  // What controls impose in this step.
  Quantity applied_force = {};        // N
  Quantity prescribed_velocity = {};  // m/s
  double prescribed[6][kLanes] = {};  // 1: translations have this velocity, rotations are held; else 0
  bool any_prescribed = false;
  bool at_rest = false;  // whether it is at rest and held: a step changes nothing
};

// What does not change about the bodies of a group, by lane.
struct BodyGroupInertia {
  alignas(64) double weighing_mass[kLanes];       // kg, without scaling
  alignas(64) double inertia[6][kLanes];          // kg, kg m2
  alignas(64) double dt_over_inertia[6][kLanes];  // 0 where held, and in lanes without a body
};
BodyGroupInertia inertia_of(const BodyGroup& group, const Model& model, const Inertia& inertia, double time_step);

// Moves the body of lane 0 by a step: sums, control or free motion, gridpoints. Fixed order throughout.
void advance_body(const RigidBody& body, double mass, const Vec3& inertia, const StepData& step, BodyLanes* state,
                  Measured* measured);
// The same for the bodies of a group, side by side. Of the gridpoints it writes what the joints of their faces need:
// displacement along the normal, velocity across.
void advance_bodies(const Model& model, const BodyGroup& group, const BodyGroupInertia& inertia, const StepData& step,
                    BodyLanes* state, Measured* measured);

}  // namespace quoin
