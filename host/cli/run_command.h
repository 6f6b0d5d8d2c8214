#pragma once

namespace CLI {
class App;
}

namespace quoin {

// `quoin run`: see its help text. Errors are thrown; exit_code is set otherwise.
void add_run_command(CLI::App& app, int& exit_code);

// Adds --law-seconds to a command.
void add_law_seconds(CLI::App& command, double& seconds);

}  // namespace quoin
