// `quoin path`: one contact point along a path, from a table of jumps or from path tests as data.
#pragma once

#include <CLI/CLI.hpp>

namespace quoin {

// Registers the command. Its callback sets exit_code (5 when an expectation of a path file fails) or throws Error.
void add_path_command(CLI::App& app, int& exit_code);

}  // namespace quoin
