// A run on ranks other than 0.
#pragma once

#include "base/ranks.h"
#include "cli/run_options.h"

namespace quoin {

void follow(RunOptions options, Ranks& ranks, int& exit_code);

}  // namespace quoin
