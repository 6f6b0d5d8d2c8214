// Weight, which follows the ramp of a stage.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "scene/generate_blocks.h"
#include "step/actions/action.h"

namespace quoin {

using geometry::Vector;

void Simulation::Impl::apply_gravity(const Stage&, double) {
  large_motion->set_gravity(geometry::vector(data.gravity));
}

}  // namespace quoin
