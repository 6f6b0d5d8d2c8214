// `quoin spectrum`: elastic response spectra and measures of a record.
#pragma once

#include <CLI/CLI.hpp>

namespace quoin {

// Registers the command. Its callback throws Error.
void add_spectrum_command(CLI::App& app);

}  // namespace quoin
