// A stage of the loading: its beginning, its progress, its end.
#pragma once

#include <string>

#include "step/state.h"

namespace quoin {

inline const Stage& current_stage(const Simulation::Impl& s) { return s.scene.stages[s.progress.at_stage()]; }
inline const SolverSettings& solver_in_use(const Simulation::Impl& s) {
  return s.progress.stage >= 0 ? s.scene.solver_in(s.progress.at_stage()) : s.scene.solver;
}
double time_now(const Simulation::Impl& s);    // time since the start, s
double stage_time(const Simulation::Impl& s);  // time since the beginning of the stage, s
void begin_stage(Simulation::Impl& s, int index);
void choose_damping(Simulation::Impl& s);  // sets the damping of the stage
bool force_lost(Simulation::Impl& s);      // whether the last half cycle has lost the force at which the stage ends
// Share that is done, 0 to 1, by duration, displacement or multiplier.
double stage_fraction(const Simulation::Impl& s);
bool equilibrium_reached(Simulation::Impl& s, const Stage& settings);
bool is_calm(const Simulation::Impl& s);  // whether the last checks of equilibrium have found it
void swap_law(Simulation::Impl& s, const std::string& name, const std::string& law);

}  // namespace quoin
