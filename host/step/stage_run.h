// The run of one stage: steps until its end, and between them rows, frames, warnings, checkpoints and progress.
#pragma once

#include <vector>

#include "step/simulation.h"
#include "step/state.h"

namespace quoin {

// Continues the stage that the simulation is in, or begins the next one. All ranks call it together.
class StageRun {
 public:
  StageRun(Simulation& simulation, Simulation::Impl& impl, Observer& observer, int stage);

  bool advance();  // by one step; whether the stage has ended with it
  void end();

 private:
  // Outputs and checks that are due at the next step.
  struct Due {
    bool stop = false, check = false;   // check: of equilibrium
    bool planned = false, row = false;  // planned: by the interval of the stage; row: that, or at a stop
    bool frame = false;
  };

  template <class Act>
  void report_promotion(const Act& act);
  void begin(bool was_in_stage);
  Due look_ahead();
  bool has_ended(const Due& due);
  void follow_motion(bool done);
  void show_frame();
  void write_row(bool done);
  void pause(bool last);
  void require_steps_left() const;
  void report_progress();
  void warn();

  // Time of writing counts as output.
  template <class Write>
  void write(const Write& what) {
    const auto before = Clock::now();
    what();
    s_.timing.phases[Phase::output] += seconds_since(before);
  }

  Simulation& simulation_;
  Simulation::Impl& s_;
  Observer& observer_;
  int index_;
  const Stage& settings_;
  int frames_;
  bool frames_follow_damage_;
  std::vector<Warning> warnings_;                // found, not yet reported
  bool gone_over_ = false;                       // whether the run was promoted to large motion in this step
  bool frame_due_ = false, damage_due_ = false;  // by the way of the stage; as damage has grown
  // At the last report of progress:
  Clock::time_point reported_at_;
  long reported_steps_ = 0;
  double reported_fraction_ = 0.0;
};

}  // namespace quoin
