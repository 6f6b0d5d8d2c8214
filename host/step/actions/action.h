// What acts on blocks from outside in stages: one file each in this folder, and one line each in actions.cpp. Their
// keys are read in scene/read_actions.cpp.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "step/state.h"

namespace quoin {

// Of blocks in large motion. What an action does not have is null.
struct Simulation::Impl::Action {
  const char* name;
  // Blocks that a stage names: looked up before anything runs, and known to all ranks when the stage begins.
  void (*names)(const Stage& stage, const std::function<void(const std::string& block)>& visit);
  // When a stage begins. previous: null: it is the first.
  void (Impl::*bind)(const Stage& stage, const Stage* previous);
  // Before a step. ramp: how far that of the stage has come, 0 to 1.
  void (Impl::*apply)(const Stage& stage, double ramp);

  static std::span<const Action> all();  // in the order in which they act
};

}  // namespace quoin
