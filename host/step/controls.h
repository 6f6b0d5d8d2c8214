// Controls of bodies and blocks in a stage: prescribed velocities, forces, gravity, the whiffletree.
#pragma once

#include "step/state.h"

namespace quoin {

void apply_controls(Simulation::Impl& s);
// Mean velocity over the coming step of a body in cycles, m/s, from that at the beginning of the stage. The
// displacements add up to the closed form of the cycles.
double velocity_in_cycles(const Simulation::Impl& s, double initial_velocity);
void find_monitor(Simulation::Impl& s, const Stage& settings);
// Sets controls of bodies, loads and the monitor when a stage begins. previous: the stage before; null: there is none.
void control_bodies(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void bind_controls(Simulation::Impl& s);  // lists that follow from ramps and prescribed components
void find_bodies_at_rest(Simulation::Impl& s);

}  // namespace quoin
