// The time limit of laws on the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "law/law_calls.h"

namespace quoin {

// Check of an option: a finite number. CLI::Range lets NaN pass, as it is not outside of any.
std::string is_number(const std::string& text);

// Adds --law-seconds to a command.
void add_law_seconds(CLI::App& command, double& seconds);

// Watches laws while the object lives: a call that lasts longer ends the program, or the load of a library.
LawWatchdog limit_laws(double seconds);

}  // namespace quoin
