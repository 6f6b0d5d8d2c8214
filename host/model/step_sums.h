// Sums of a step, of one block and of the model, and energies since the start.
#pragma once

#include <vector>

#include "geometry/vector.h"
#include "law/law_library.h"
#include "model/lanes.h"

namespace quoin::blocks {

using geometry::Vector;

// Sums of the step of one block.
struct BlockSums {
  double unbalanced = 0.0;  // largest net force on a body or gridpoint, free components only, N; NaN is kept
  Vector net;               // sum of these net forces, N
  double positions = 0.0;   // sum of coordinates, which is not finite when one of them is not
  double kinetic = 0.0, strain = 0.0, damping = 0.0, external = 0.0;  // J
  double deformation = 0.0;  // largest |u| in the frame, from the first gridpoint, m
  bool deviates = false;     // whether it deviates from the motion of its last check
  Vector moved;              // displacement since the start, for a row of the history, m
  double turned = 0.0;       // rotation since the start, for such a row, rad
};

struct Energies {        // J
  double kinetic = 0.0;  // kinetic energy of components that are free to move
  double strain = 0.0, contact_stored = 0.0;
  double dissipated[QUOIN_DISSIPATED_COUNT] = {};  // tension, cohesion, friction, crushing
  double damping = 0.0;                            // energy dissipated by damping
  double external = 0.0;  // work of weight, loads and supports on joints, independent of inertia scaling
  // Energy lost (> 0) or gained when contact points were placed again. Also the kinetic energy of halves' added inertia
  // that is lost when a unit comes apart.
  double detection = 0.0;
  double members_stored = 0.0, members_dissipated = 0.0;  // energies of host/members
  double dissipated_total() const { return dissipated[0] + dissipated[1] + dissipated[2] + dissipated[3]; }
  // Energy that has appeared (> 0) or vanished without a cause since the start, J.
  double balance_error(double at_start) const {
    return kinetic + strain + contact_stored + members_stored + dissipated_total() + members_dissipated + damping +
           detection - external - at_start;
  }
};

// Energies that are booked in the next step: work of forces in the second half of a step, and losses at its end. These
// losses come from contact points that are placed again and from units that come apart.
struct HalfStep {
  double damping = 0.0, external = 0.0, detection = 0.0;  // J
};

// Steps write these sums; changes of loads and supports between steps add their work.
struct StepSums {
  std::vector<BlockSums> of_block;
  LaneVector<Vector> contact_force;  // by block, N
  double unbalanced = 0.0;           // largest of all blocks, N
  Vector net;                        // net force on all free components, N
  Energies energies;
  HalfStep later;
  double dissipated = 0.0;  // by laws and members in the last step, J
};

}  // namespace quoin::blocks
