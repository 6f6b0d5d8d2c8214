#pragma once

namespace CLI {
class App;
}

namespace quoin {

// `quoin run`: see its help text. Errors are thrown; exit_code is set otherwise.
void add_run_command(CLI::App& app, int& exit_code);

}  // namespace quoin
