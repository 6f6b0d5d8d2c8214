// Displacement in cycles, in closed form: from 0 to an amplitude, to its opposite and so on, at the end back to 0.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace quoin {

// Cycles as a scene gives them. SI units.
struct Cycles {
  std::vector<double> amplitudes;  // m, > 0
  std::vector<int> counts;         // cycles of each amplitude
  double velocity = 0.0;           // m/s, not 0; < 0: the first half cycle goes to -amplitude
  double ramp_time = 0.0;          // s, > 0; of every half cycle, at its start and at its end
  // Fraction of the largest force of an earlier half cycle to the same side. A half cycle of at least that amplitude
  // with a smaller largest force ends the stage when the motion reverses.
  std::optional<double> stop_at_force_loss;
};
std::string text_of(const Cycles& cycles);  // "2 cycles of 1 mm, 3 of 2 mm"

// Motion whose half cycles start and end at rest and are never faster than |velocity|. A half cycle that is too short
// for its ramps is slower: it takes two of them.
class CyclicMotion {
 public:
  explicit CyclicMotion(const Cycles& cycles);

  double duration() const { return way_.back().start + way_.back().duration; }  // s
  // Displacement at `time` since the start, s; in m. An initial velocity, m/s, dies out in the first ramp without a
  // displacement that remains. So the amplitudes are the same with it.
  double position(double time, double initial_velocity = 0.0) const;
  // Index of the half cycle at `time`, from 0; the last one returns to 0.
  int half_cycle(double time) const;
  double shortest_half_cycle() const;  // s
  int half_cycles() const { return static_cast<int>(way_.size()); }
  double target(int half_cycle) const { return way_[static_cast<std::size_t>(half_cycle)].to; }  // m, where it ends

 private:
  struct HalfCycle {
    double from, to;         // m
    double start, duration;  // s
    double velocity;         // between the ramps, m/s
  };
  std::vector<HalfCycle> way_;
  double ramp_time_;
};

// Detects loss of force from half cycle to half cycle. Trivially copyable: part of a checkpoint.
class ForceLoss {
 public:
  // Adds a force in N, > 0 against a motion towards the positive side. half_cycle: the current one, with its target in
  // m. Returns true when the half cycle that has just ended lost force.
  bool see(double force, int half_cycle, double target, double allowed_fraction);

  // Index of the half cycle that ended last.
  int half_cycle() const { return ended_; }
  double force() const { return of_ended_; }     // its largest force, N
  double largest() const { return reference_; }  // force that it was compared with, N

 private:
  int now_ = 0, ended_ = -1;
  double target_ = 0.0, of_now_ = 0.0, of_ended_ = 0.0, reference_ = 0.0;
  struct Side {
    double force, amplitude;  // N, m; of the half cycle with the largest force
  };
  Side sides_[2] = {};
};

}  // namespace quoin
