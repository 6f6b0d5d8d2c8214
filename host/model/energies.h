// Energies of a model.
#pragma once

#include <array>

#include "law/law_library.h"

namespace quoin {

// As computed (not multiplied by the symmetry factor), J. Closure:
//   kinetic + strain + contact_stored + members_stored
//     + dissipated + members_dissipated + damping + detection = external + energy at the start
struct Energies {
  double kinetic = 0.0;         // of components that are free to move
  double strain = 0.0;          // elastic energy of zones
  double contact_stored = 0.0;  // elastic energy of joints
  // Dissipated in joints since the start: tension, cohesion, friction, crushing.
  std::array<double, QUOIN_DISSIPATED_COUNT> dissipated{};
  double damping = 0.0;   // work taken by damping since the start
  double external = 0.0;  // work of weight, loads, supports and prescribed velocities since the start
  // Stored energy lost (> 0) or gained when contact points are placed again, or take another law. Also the kinetic
  // energy of halves' added inertia that is lost when a unit comes apart.
  double detection = 0.0;
  double members_stored = 0.0, members_dissipated = 0.0;  // energies of host/members

  double dissipated_total() const { return dissipated[0] + dissipated[1] + dissipated[2] + dissipated[3]; }
  // Energy that has appeared (> 0) or vanished without a cause since the start.
  double balance_error(double at_start = 0.0) const {
    return kinetic + strain + contact_stored + members_stored + dissipated[0] + dissipated[1] + dissipated[2] +
           dissipated[3] + members_dissipated + damping + detection - external - at_start;
  }
};

}  // namespace quoin
