// What the ranks beside rank 0 do in a run.
#pragma once

#include "base/ranks.h"
#include "cli/run_options.h"

namespace quoin {

void follow(RunOptions options, Ranks& ranks, int& exit_code);

}  // namespace quoin
