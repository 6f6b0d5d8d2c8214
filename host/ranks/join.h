// The ranks that mpirun or srun has started this process with.
#pragma once

#include <memory>
#include <string>

#include "base/ranks.h"

namespace quoin {

// Null: this process was started alone, and no library of MPI has been touched. Throws Error(bad_input): it was started
// with others, but this program was built without MPI, or the library does not load.
std::unique_ptr<Ranks> join_ranks();

}  // namespace quoin
