// What acts on bodies and blocks in a stage: imposed velocities, forces, gravity, the whiffletree.
#pragma once

#include "step/state.h"

namespace quoin {

void apply_controls(Simulation::Impl& s);
// Over the coming step, of what moved at this velocity when the cycles of the stage began, m/s. Its displacements add
// up to the closed form.
double velocity_in_cycles(const Simulation::Impl& s, double initial_velocity);
void find_monitor(Simulation::Impl& s, const Stage& settings);
// When a stage begins: bodies, loads and the monitor. previous: null: it is the first.
void control_bodies(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void bind_controls(Simulation::Impl& s);  // lists that follow from ramps and prescribed components
void find_bodies_at_rest(Simulation::Impl& s);

}  // namespace quoin
