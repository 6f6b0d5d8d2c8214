// Ranges of a scene's keys for which the errors of the qualities were measured. They are those of the walls of
// benchmarks/error_against_cost, listed in host/scenes/README.md. Outside of them errors are not measured.
#pragma once

#include <string>

#include "scene/scene.h"

namespace quoin {

// First key outside of its measured range, with value and range; empty when all are within.
std::string outside_measured(const Scene& scene);

}  // namespace quoin
