// `quoin fit`: properties of a law from measured couplet, triplet and prism curves.
#pragma once

#include <CLI/CLI.hpp>

namespace quoin {

// Registers the command. Its callback throws Error.
void add_fit_command(CLI::App& app, int& exit_code);

}  // namespace quoin
