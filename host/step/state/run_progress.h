// How far a run has come. A stage sets it when it begins, steps and checks between them change it; all of it is
// saved.
#pragma once

#include <cstddef>

#include "scene/cyclic_motion.h"

namespace quoin {

constexpr long kCheckInterval = 20;  // steps between two checks of the unbalanced force, or of a lost force

struct RunProgress {
  long step = 0;              // number of steps since the start
  double clock_start = 0.0;   // s, of the lattice: when its time step was chosen last
  long clock_start_step = 0;  // step at which the clock was started
  int stage = -1;             // -1: none has begun
  bool in_stage = false;
  long stage_step = 0;
  double stage_start = 0.0;       // s
  double unbalanced_ratio = 0.0;  // ratio of the last measured step
  int calm_checks = 0;            // equilibrium checks passed in a row
  int next_frame = 0;
  long next_row = 0;      // stage_step of the next history row
  long row_interval = 1;  // interval of the stage, found at its start, as the step may change later
  ForceLoss force_loss;   // loss of force in cycles

  std::size_t at_stage() const { return static_cast<std::size_t>(stage); }
};

}  // namespace quoin
