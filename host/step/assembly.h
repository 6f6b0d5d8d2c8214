// The blocks of a run as shapes: its own, or its bricks turned into them.
#pragma once

#include "scene/from_bricks.h"
#include "step/large_motion.h"
#include "step/simulation.h"

namespace quoin {

inline blocks::Assembly assembly_of(const Simulation& simulation) {
  const blocks::Model* const shapes = simulation.large_motion();
  return shapes ? shapes->assembly : blocks::from_bricks(simulation.assembly());
}

}  // namespace quoin
