// What a step adds up to: of one block, of the model, and energies since the start.
#pragma once

#include <vector>

#include "geometry/vector.h"
#include "law/law_library.h"
#include "model/lanes.h"

namespace quoin::blocks {

using geometry::Vector;

// What the step of one block adds up to.
struct BlockSums {
  double unbalanced = 0.0;  // largest net force on a body or gridpoint, of its free components, N; NaN stays
  Vector net;               // their sum, N
  double positions = 0.0;   // sum of coordinates; its only use is that it is not finite when one of them is not
  double kinetic = 0.0, strain = 0.0, damping = 0.0, external = 0.0;  // J
  double deformation = 0.0;          // largest |u| in a frame, beside the first gridpoint, m
  bool deviates = false;             // moves otherwise than it was seen to
  double moved = 0.0, turned = 0.0;  // displacement and rotation since the start, for a row of the history, m, rad
};

struct Energies {        // J
  double kinetic = 0.0;  // kinetic energy of components that are free to move
  double strain = 0.0, contact_stored = 0.0;
  double dissipated[QUOIN_DISSIPATED_COUNT] = {};  // tension, cohesion, friction, crushing
  double damping = 0.0;                            // taken by damping
  double external = 0.0;  // done by weight, loads and supports: what joints take from these, whatever their inertia
  // Energy lost (> 0) or gained when contact points were placed again, and lost with the inertia of halves on each
  // other when a unit came apart.
  double detection = 0.0;
  double members_stored = 0.0, members_dissipated = 0.0;  // energies of host/members
  double dissipated_total() const { return dissipated[0] + dissipated[1] + dissipated[2] + dissipated[3]; }
  // what has appeared from nowhere (> 0) or vanished since the start
  double balance_error(double at_start) const {
    return kinetic + strain + contact_stored + members_stored + dissipated_total() + members_dissipated + damping +
           detection - external - at_start;
  }
};

// What belongs to the energies of the next step. It is the work of forces in the second half of their own, and what is
// lost at its end. That is lost with points that are placed again and with units that come apart.
struct HalfStep {
  double damping = 0.0, external = 0.0, detection = 0.0;  // J
};

// Written by each step; loads and supports that change between steps book their work.
struct StepSums {
  std::vector<BlockSums> of_block;
  LaneVector<Vector> contact_force;  // by block, N
  double unbalanced = 0.0;           // the largest of all blocks, N
  Vector net;                        // force on all that is free to move, N
  Energies energies;
  HalfStep later;
  double dissipated = 0.0;  // by laws and members, in the last step, J
};

}  // namespace quoin::blocks
