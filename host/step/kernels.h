// The inner loops of a step, compiled for every instruction set of Highway and chosen at run time. Every lane
// does the same operations in the same order whatever the vector length.
#pragma once

#include "model/model.h"
#include "model/rigid_motion.h"
#include "scene/scene.h"

namespace quoin {

// Data of one step beside the model. Pointers are to whole arrays of the simulation.
struct StepData {
  double time_step = 0.0;  // s
  InternalForces internal_forces = InternalForces::automatic;
  // Measured steps also record strain energy and work, which costs a second internal force.
  bool energies = false;
  Eq1 eq1 = Eq1::nothing;
  double local_damping = 0.0;      // gamma of eq. 1
  double mass_damping = 0.0;       // alpha, 1/s; with gamma = 0
  double stiffness_damping = 0.0;  // beta, s
  Vec3 gravity{};                  // m/s2
  // Velocity of the ground, m/s, from which damping takes velocities: at t - dt/2 with eq. 1, at t with mass_damping.
  Vec3 ground_velocity{};

  double* displacement = nullptr;        // lane layout, at t, m
  double* velocity = nullptr;            // lane layout, at t - dt/2, m/s
  const double* dt_over_mass = nullptr;  // lane layout, s/kg; 0 for held components
  // dt_over_mass by gridpoint and component, by block group where all of its blocks share it: a third less memory to
  // read. Null: they differ.
  const double* const* shared_dt_over_mass = nullptr;
  double deformation_inertia = 1.0;           // s_b of model/rigid_motion.h; included in dt_over_mass
  double unit_inertia = 1.0;                  // s_u
  const RigidMotion* block_motion = nullptr;  // by block group; null: not needed
  const RigidMotion* unit_motion = nullptr;   // by unit group; null: not needed
  std::size_t scratch_doubles = 0;            // doubles for each block of a unit
  // Acceleration by loads on blocks, by block group: [component][lane], m/s2; null: none of its blocks is loaded.
  const double* const* load = nullptr;
  const double* normal_shift = nullptr;  // by contact point, added to the opening; null: none
  const double* traction[3] = {};        // sigma, tau_s, tau_t by contact point, Pa
  double* force[3] = {};                 // x, y, z on side a by contact point, then a dummy that stays 0, N
};

// Motion on which damping acts: kernels are compiled for each.
enum class Brake { nothing, gridpoints, rigid_motion, mass };
inline Brake brake_of(const StepData& step) {
  if (step.eq1 == Eq1::nothing) return step.mass_damping > 0.0 ? Brake::mass : Brake::nothing;
  return step.eq1 == Eq1::gridpoints ? Brake::gridpoints : Brake::rigid_motion;
}

// Measurements of a unit group or a rigid body in a step. Work is split into the half step that ends at the time of the
// displacements and the one that begins there. So all energies are of one time.
struct Measured {
  double unbalanced_squared = 0.0;  // square of the largest unbalanced force of a gridpoint, N2
  double kinetic = 0.0;             // J, m v(-1/2) v(+1/2) / 2, which central differences conserve
  // J, in block groups with StepData::energies alone:
  double strain = 0.0;
  double damping_before = 0.0, damping_after = 0.0;
  double external_before = 0.0, external_after = 0.0;
};

// Jumps of the points of a chunk, m: total opening, slip increments of the last step.
struct ChunkJumps {
  alignas(64) double normal[kChunk];
  alignas(64) double slip_s[kChunk];
  alignas(64) double slip_t[kChunk];
  alignas(64) double old_traction[3][kChunk];  // Pa, with impact damping
};

void contact_jumps(const Model& model, const ContactChunk& chunk, const StepData& step, ChunkJumps* jumps);
// viscous: tractions of damping, added to those of the law, by contact point, Pa; null: none.
void contact_forces(const Model& model, const ContactChunk& chunk, const StepData& step,
                    const double* const* viscous = nullptr);

// Advances the blocks of a unit group by a step: internal forces, contact forces, weight, damping, central differences.
// scratch has kUnitBlocks times scratch_doubles. These are kScratchColumns times the doubles of the largest group.
// measured may be null.
inline constexpr int kScratchColumns = 7;
void advance_units(const Model& model, const UnitGroup& units, const StepData& step, double* scratch,
                   Measured* measured);

// K u alone, computed as in advance_units from the assembled stiffness, N. Lane layout, the groups of the unit one
// after the other; they must have one template. For benchmarks.
void internal_force(const Model& model, const UnitGroup& units, const StepData& step, double* force);

const char* kernel_instruction_set();  // "AVX2"

}  // namespace quoin
