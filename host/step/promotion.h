// Promotion: a run continues in large motion when blocks leave small displacements. Gridpoints, bodies and contact
// points are kept, with their velocities, tractions and states.
//
// Small displacements turn blocks by the linear field theta x r, which stretches them by theta^2/2. Blocks that have
// turned little keep small displacements in a fixed frame, the others turn (model/fixed_frames.h). The reference from
// which a contact point measures its opening absorbs the change of its gap.
#pragma once

#include "step/state.h"

namespace quoin {

double added_kinetic_energy(const Simulation::Impl& s);  // kinetic energy of the added inertia, s_b and s_u, J
// stage: the one that goes over, from 0; as it begins, that of the run is still the one before.
void promote(Simulation::Impl& s, const std::string& why, int stage);
void leave_lattice(Simulation::Impl& s);  // builds the blocks in large motion at rest, and removes the lattice
void return_to_lattice(Simulation::Impl& s);

}  // namespace quoin
