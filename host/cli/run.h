// A run of a scene, from its options to its results.
#pragma once

#include "cli/run_options.h"

namespace quoin {

// Where mpirun has started several of us: rank 0 runs as one process does, the others help. What stops one rank ends
// all: those that fail together are spoken for by rank 0, and one that fails alone says so.
void run_on_ranks(const RunOptions& options, int& exit_code);

}  // namespace quoin
