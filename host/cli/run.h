// A run of a scene, from its options to its results.
#pragma once

#include "cli/run_options.h"

namespace quoin {

// Runs as one of several processes that mpirun has started. Rank 0 prints and writes as a single process does. An error
// on one rank ends all. Rank 0 reports errors of all ranks together; a rank that fails alone reports its own.
void run_on_ranks(const RunOptions& options, int& exit_code);

}  // namespace quoin
