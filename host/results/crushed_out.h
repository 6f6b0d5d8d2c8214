// Contact points that are crushed out. With a residual compressive strength of 0 they carry nothing, and blocks sink
// into each other there (contact_models/fracture_energy/LAW.md).
#pragma once

#include <string>

#include "step/simulation.h"

namespace quoin {

struct CrushedOut {
  long points = 0;
  double overlap = 0.0;         // overlap of the blocks at the deepest of them, m
  std::string warning() const;  // text of the warning; empty: there is nothing to warn of
};

// By all ranks at the same moment, after run().
CrushedOut find_crushed_out(const Simulation& simulation);

}  // namespace quoin
