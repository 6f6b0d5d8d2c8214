// The inner loops of a step, compiled for every instruction set of Highway and chosen at run time. Every lane
// does the same operations in the same order whatever the vector length.
#pragma once

#include "model/model.h"
#include "model/rigid_motion.h"
#include "scene/scene.h"

namespace quoin {

// What one step needs besides the model. Pointers are to whole arrays of the simulation.
struct StepData {
  double time_step = 0.0;  // s
  InternalForces internal_forces = InternalForces::automatic;
  bool energies = false;  // measured steps record strain energy and work too, which costs a second internal force
  Eq1 eq1 = Eq1::nothing;
  double local_damping = 0.0;      // gamma of eq. 1
  double mass_damping = 0.0;       // alpha, 1/s; with gamma = 0
  double stiffness_damping = 0.0;  // beta, s
  Vec3 gravity{};                  // m/s2
  Vec3 ground_velocity{};          // m/s, against which damping brakes: signs of half a step ago, viscous forces of now

  double* displacement = nullptr;        // lane layout
  double* velocity = nullptr;            // lane layout, of half a step ago
  const double* dt_over_mass = nullptr;  // lane layout, s/kg; 0 for held components
  // By block group: the same by gridpoint and component where all blocks of the group share it, a third less to read.
  // Else null.
  const double* const* shared_dt_over_mass = nullptr;
  double deformation_inertia = 1.0;           // s_b of model/rigid_motion.h; dt_over_mass has its factor
  double unit_inertia = 1.0;                  // s_u
  const RigidMotion* block_motion = nullptr;  // by block group; null: not needed
  const RigidMotion* unit_motion = nullptr;   // by unit group; null: not needed
  std::size_t scratch_doubles = 0;            // doubles for each block of a unit
  // By block group: acceleration that loads give its blocks, [component][lane], m/s2; null: none of them is loaded.
  const double* const* load = nullptr;
  const double* normal_shift = nullptr;  // by contact point, added to the opening; null: none
  const double* traction[3] = {};        // sigma, tau_s, tau_t by contact point
  double* force[3] = {};                 // x, y, z on side a by contact point, then a dummy that stays 0
};

// What damping brakes: kernels are compiled for each.
enum class Brake { nothing, gridpoints, rigid_motion, mass };
inline Brake brake_of(const StepData& step) {
  if (step.eq1 == Eq1::nothing) return step.mass_damping > 0.0 ? Brake::mass : Brake::nothing;
  return step.eq1 == Eq1::gridpoints ? Brake::gridpoints : Brake::rigid_motion;
}

// What a measured step records of a unit group or a rigid body. Work is split into the half step that ends at the time
// of the displacements and the half step that begins there. So energies belong to one time.
struct Measured {
  double unbalanced_squared = 0.0;  // largest over gridpoints, N2
  double kinetic = 0.0;             // m v(-1/2) v(+1/2) / 2, which is what central differences conserve
  // Energies of block groups, with StepData::energies alone:
  double strain = 0.0;
  double damping_before = 0.0, damping_after = 0.0;
  double external_before = 0.0, external_after = 0.0;
};

// Jumps of a chunk: total opening, sliding over the last step. Room for kChunk each.
struct ChunkJumps {
  alignas(64) double normal[kChunk];
  alignas(64) double slip_s[kChunk];
  alignas(64) double slip_t[kChunk];
  alignas(64) double old_traction[3][kChunk];  // Pa, where impacts are damped
};

void contact_jumps(const Model& model, const ContactChunk& chunk, const StepData& step, ChunkJumps* jumps);
// viscous: by contact point, what is added to the tractions, Pa; null: nothing.
void contact_forces(const Model& model, const ContactChunk& chunk, const StepData& step,
                    const double* const* viscous = nullptr);

// Internal forces, sums of contact forces, weight, damping, central differences. scratch has kUnitBlocks times
// scratch_doubles, which are kScratchColumns times the doubles of the largest group. measured may be null.
inline constexpr int kScratchColumns = 7;
void advance_units(const Model& model, const UnitGroup& units, const StepData& step, double* scratch,
                   Measured* measured);

// K u alone, as advance_units forms it from the assembled stiffness. It is in lane layout, the groups of the unit one
// after the other, which must have one template. For benchmarks.
void internal_force(const Model& model, const UnitGroup& units, const StepData& step, double* force);

const char* kernel_instruction_set();  // "AVX2"

}  // namespace quoin
