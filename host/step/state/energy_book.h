// Energies since the start, J. Measured steps add to them. Sums and the kinetic energy are saved.
#pragma once

#include <array>
#include <optional>

#include "step/simulation.h"

namespace quoin {

struct EnergyBook {
  bool wanted = false;                   // output.energy: energies are measured in every step
  bool sampled = false;                  // whether the energies of this step are measured for Watch
  std::array<double, 4> dissipated{};    // energy dissipated in joints of the lattice, by mode
  double damping = 0.0, external = 0.0;  // work on the lattice up to the last half step
  double lost_at_changes = 0.0;          // energy lost where a stage takes less added inertia or another law
  double kinetic = 0.0;                  // kinetic energy of the last measured step
  std::optional<Energies> now;           // energies of the last measured step
};

}  // namespace quoin
