// Ranges of a scene's keys on which the errors of the qualities were measured. They are those of the walls of
// benchmarks/error_against_cost (host/scenes/README.md lists them). Outside nothing is known of them.
#pragma once

#include <string>

#include "scene/scene.h"

namespace quoin {

// The first way in which a scene leaves what was measured, with key, value and range; empty when it stays within.
std::string outside_measured(const Scene& scene);

}  // namespace quoin
