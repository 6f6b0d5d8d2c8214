// Was the run slow enough to be quasi-static? Judged from its own forces and energies.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

struct QuasiStatic {
  // Stages that end by displacement, after their ramps. What supports and loads give in all along the loading direction
  // is force that moves the wall in place of straining it: root of the mean square, over the peak force.
  double dynamic_force_ratio = 0.0;
  double kinetic_energy_ratio = 0.0;  // largest kinetic energy over the work done until the end
  bool quasi_static() const { return dynamic_force_ratio <= kAllowed && kinetic_energy_ratio <= kAllowed; }
  std::string warning() const;  // empty when quasi-static

  static constexpr double kAllowed = 0.05;
};

QuasiStatic check_quasi_static(const std::vector<HistoryRow>& rows, const Scene& scene);

}  // namespace quoin
