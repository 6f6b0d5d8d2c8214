// Was the run slow enough to be quasi-static? Judged from its own forces, energies and displacements.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// Findings of the stages that drive a body: by a velocity, or until a displacement is reached.
struct QuasiStatic {
  // The sum of supports and loads along the loading direction is force that moves the wall in place of straining it.
  // Its measure is the root of the mean square, with or without the ramps, whichever is larger, over the peak force.
  // Empty when nothing was driven.
  std::optional<double> dynamic_force_ratio;
  // Largest kinetic energy over the work done until the end. Empty when no work was done.
  std::optional<double> kinetic_energy_ratio;
  // Displacement beyond the one that a stage requests, over it: the largest of the stages that ended by displacement.
  double overshoot_ratio = 0.0;
  std::string not_judged;  // why the record is too short to be judged; empty when it is not

  bool driven = false;  // the scene has a stage to be judged
  bool quasi_static() const;
  std::string reason() const;   // why quasi_static() is false; empty when it is true
  std::string warning() const;  // the reason and what to do; empty when quasi-static, or when nothing is driven

  static constexpr double kAllowed = 0.05, kAllowedOvershoot = 0.01;
};

QuasiStatic check_quasi_static(const std::vector<HistoryRow>& rows, const Scene& scene);

}  // namespace quoin
