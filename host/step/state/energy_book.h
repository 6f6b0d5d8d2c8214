// Energies since the start, J. Measured steps add to them; sums and kinetic are saved.
#pragma once

#include <array>
#include <optional>

#include "step/simulation.h"

namespace quoin {

struct EnergyBook {
  bool wanted = false;                   // by the scene: in every step
  bool sampled = false;                  // whether this step alone has energies, for the watch
  std::array<double, 4> dissipated{};    // joints on the lattice, by mode
  double damping = 0.0, external = 0.0;  // energies of the lattice up to the last half step
  double lost_inertia = 0.0;             // kinetic, of added inertia where stages take less of it
  double kinetic = 0.0;                  // kinetic energy of the last measured step
  std::optional<Energies> now;
};

}  // namespace quoin
