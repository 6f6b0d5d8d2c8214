// Contact points that have crushed completely. With a residual compressive strength of 0 they carry no force, and
// blocks penetrate each other there (contact_models/fracture_energy/LAW.md).
#pragma once

#include <string>

#include "step/simulation.h"

namespace quoin {

struct CrushedOut {
  long points = 0;
  double overlap = 0.0;         // largest overlap of the blocks at such a point, m
  std::string warning() const;  // text of the warning; empty: there is none
};

// Collective, after run().
CrushedOut find_crushed_out(const Simulation& simulation);

}  // namespace quoin
