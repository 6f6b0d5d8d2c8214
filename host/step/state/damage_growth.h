// How damage of the joints has grown, with output.frames_at_damage. Passes over them (step/damage_growth.h) change it,
// and stages begin to count their frames. All of it is saved.
#pragma once

namespace quoin {

struct DamageGrowth {
  double sound_at_start = -1.0;  // sound area of the joints at the first pass; -1: there was none
  double now = 0.0;              // share of it that was lost at the last pass
  double at_frame = 0.0;         // the same at the last frame
  long frames = 0;               // frames of the stage so far
  long next_pass = 0;            // step of the next pass
};

}  // namespace quoin
