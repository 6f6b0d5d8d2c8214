// Start of MPI where mpirun or srun has started this process.
#pragma once

#include <memory>
#include <string>

#include "base/ranks.h"

namespace quoin {

// Ranks of this run. Null: the process was started alone; no MPI library is loaded. Throws Error(bad_input) for a
// process started with others by a program without MPI, or with an MPI library that does not load.
std::unique_ptr<Ranks> join_ranks();

}  // namespace quoin
