// Sums of a step, of one block and of the model, and energies since the start.
#pragma once

#include <vector>

#include "geometry/vector.h"
#include "model/energies.h"
#include "model/lanes.h"

namespace quoin::blocks {

using geometry::Vector;

// Work of forces in the half step before their time and in the one after it, J.
struct HalfWorks {
  double before = 0.0, after = 0.0;
};

// Sums of the step of one block.
struct BlockSums {
  double unbalanced = 0.0;             // largest net force on a body or gridpoint, free components only, N; NaN is kept
  Vector net;                          // sum of these net forces, N
  double positions = 0.0;              // sum of coordinates, which is not finite when one of them is not
  double kinetic = 0.0, strain = 0.0;  // J, kinetic: by the product of the velocities before and after
  HalfWorks damping, external;
  double deformation = 0.0;  // largest |u| in the frame, from the first gridpoint, m
  bool deviates = false;     // whether it deviates from the motion of its last check
  Vector moved;              // displacement since the start, for a row of the history, m
  double turned = 0.0;       // rotation since the start, for such a row, rad
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
