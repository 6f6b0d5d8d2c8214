// `quoin limit`: limit analysis of an assembly of rigid blocks under a horizontal load, without a run.
#pragma once

#include <CLI/CLI.hpp>

namespace quoin {

// Registers the command. Its callback throws Error.
void add_limit_command(CLI::App& app);

}  // namespace quoin
