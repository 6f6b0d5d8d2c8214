// `quoin limit`: the multiplier of a horizontal load at which an assembly of rigid blocks falls, without a run.
#pragma once

#include <CLI/CLI.hpp>

namespace quoin {

// Registers the command. Its callback throws Error.
void add_limit_command(CLI::App& app);

}  // namespace quoin
