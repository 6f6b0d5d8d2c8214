// Progress of a run. A stage sets it when it begins; steps, and checks between them, change it. All of it is saved.
#pragma once

#include <cstddef>

#include "scene/cyclic_motion.h"

namespace quoin {

constexpr long kCheckInterval = 20;  // steps between two checks of equilibrium, or of a loss of force

struct RunProgress {
  long step = 0;              // number of steps since the start
  double clock_start = 0.0;   // time at which the lattice's time step was last chosen, s
  long clock_start_step = 0;  // step at which it was last chosen
  int stage = -1;             // -1: none has begun
  bool in_stage = false;
  long stage_step = 0;
  double stage_start = 0.0;       // time at which the stage began, s
  double unbalanced_ratio = 0.0;  // unbalanced ratio of the last measured step
  int calm_checks = 0;            // equilibrium checks passed in a row
  int next_frame = 0;
  long next_row = 0;      // stage_step of the next history row
  long row_interval = 1;  // steps between rows, chosen at the beginning of the stage
  ForceLoss force_loss;   // for stages of cycles

  std::size_t at_stage() const { return static_cast<std::size_t>(stage); }
};

}  // namespace quoin
