// A run that leaves small displacements goes on in large motion. It keeps gridpoints, bodies and contact points, with
// velocities, tractions and states as they are.
//
// Small displacements turn blocks by the linear field theta x r, which stretches them by theta^2/2. So the displacement
// u of a block is split into its rigid motion U + theta x r about its centre and the rest w. Both are by mass.
// The block goes on at X + U + R(theta) (r + w). Its strain is that of w, as before, up to terms of the order of strain
// squared. What this moves gaps by is taken up by the reference from which every contact point counts its opening.
#pragma once

#include "step/state.h"

namespace quoin {

double added_kinetic_energy(const Simulation::Impl& s);  // energy of the added inertia of deformation and of units, J
void promote(Simulation::Impl& s, const std::string& why);
void leave_lattice(Simulation::Impl& s);  // for large motion, at rest
void return_to_lattice(Simulation::Impl& s);

}  // namespace quoin
