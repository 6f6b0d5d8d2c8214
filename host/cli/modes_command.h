// `quoin modes`: natural frequencies and mode shapes of a scene, without a run.
#pragma once

#include <CLI/CLI.hpp>

namespace quoin {

// Registers the command. Its callback throws Error.
void add_modes_command(CLI::App& app);

}  // namespace quoin
