// Controls of bodies and blocks in a stage: prescribed velocities, forces, gravity, the whiffletree.
#pragma once

#include "step/state.h"

namespace quoin {

void apply_controls(Simulation::Impl& s);
// Mean velocity over the coming step of a body in cycles, m/s, from that at the beginning of the stage. The
// displacements add up to the closed form of the cycles.
double velocity_in_cycles(const Simulation::Impl& s, double initial_velocity);
// Binds actions and the monitor when a stage begins on the lattice. previous: the stage before; null: there is none.
void control_bricks(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void bind_controls(Simulation::Impl& s);  // what follows from the actions
void find_bodies_at_rest(Simulation::Impl& s);

}  // namespace quoin
