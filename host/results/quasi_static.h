// Check that a run is quasi-static, by its forces, energies and displacements.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// Findings about stages that drive a body: by a velocity, or until a displacement is reached.
struct QuasiStatic {
  // Root mean square of the dynamic force over the peak force. The dynamic force is the sum of supports and loads along
  // the loading direction, which accelerates the wall. The larger value counts, with or without the ramps. Empty when
  // no body is driven.
  std::optional<double> dynamic_force_ratio;
  // The same at the largest force alone, or the inertia force of the monitor beside that direction where it is larger.
  std::optional<double> dynamic_force_at_peak;
  // Largest kinetic energy over the total work. Empty when no work was done.
  std::optional<double> kinetic_energy_ratio;
  // Displacement beyond a stage's criterion, over that criterion: the largest of all stages that ended by displacement.
  double overshoot_ratio = 0.0;
  std::string not_judged;  // reason why there are too few rows for the check; empty when there are enough

  bool driven = false;  // whether a stage drives a body
  bool quasi_static() const;
  std::string reason() const;   // reason why quasi_static() is false; empty when it is true
  std::string warning() const;  // the reason and a remedy; empty when quasi-static, or when no body is driven

  static constexpr double kAllowed = 0.05, kAllowedAtPeak = 0.1, kAllowedOvershoot = 0.01;
};

QuasiStatic check_quasi_static(const std::vector<HistoryRow>& rows, const Scene& scene);

}  // namespace quoin
