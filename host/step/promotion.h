// Promotion: a run continues in large motion when blocks leave small displacements. Gridpoints, bodies and contact
// points are kept, with their velocities, tractions and states.
//
// Small displacements turn blocks by the linear field theta x r, which stretches them by theta^2/2. So the displacement
// u of a block is split into its rigid motion U + theta x r about its centre and the rest w. Both are by mass. The
// block continues at X + U + R(theta) (r + w). Its strain is that of w, as before, up to terms of the order of strain
// squared. The reference from which a contact point measures its opening absorbs the change of its gap.
#pragma once

#include "step/state.h"

namespace quoin {

double added_kinetic_energy(const Simulation::Impl& s);  // kinetic energy of the added inertia, s_b and s_u, J
void promote(Simulation::Impl& s, const std::string& why);
void leave_lattice(Simulation::Impl& s);  // builds the blocks in large motion at rest, and removes the lattice
void return_to_lattice(Simulation::Impl& s);

}  // namespace quoin
