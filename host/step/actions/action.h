// What acts on blocks from outside in stages: one file each in this folder, and one line each in actions.cpp. Their
// keys are read in scene/read_actions.cpp.
#pragma once

#include <functional>
#include <string>

#include "step/state.h"

namespace quoin {

// An action on blocks in large motion. Functions that it does not have are null.
struct Action {
  const char* name;
  // Blocks that a stage names: looked up before anything runs, and known to all ranks when the stage begins.
  void (*names)(const Stage& stage, const std::function<void(const std::string& block)>& visit);
  // When a stage begins. previous: null: it is the first.
  void (*bind)(Simulation::Impl& s, const Stage& stage, const Stage* previous);
  // Before a step. ramp: how far that of the stage has come, 0 to 1.
  void (*apply)(Simulation::Impl& s, const Stage& stage, double ramp);
};

void bind_drives(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void drive_blocks(Simulation::Impl& s, const Stage& settings, double ramp);
void bind_ground(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void follow_ground(Simulation::Impl& s, const Stage& settings, double ramp);
void bind_forces(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void scale_forces(Simulation::Impl& s, const Stage& settings, double ramp);
void bind_pressures(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void scale_pressures(Simulation::Impl& s, const Stage& settings, double ramp);
void apply_gravity(Simulation::Impl& s, const Stage& settings, double ramp);
void jack_members(Simulation::Impl& s, const Stage& settings, double ramp);
void bind_collapse(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void apply_collapse(Simulation::Impl& s, const Stage& settings, double ramp);

}  // namespace quoin
