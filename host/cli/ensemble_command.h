#pragma once

namespace CLI {
class App;
}

namespace quoin {

// `quoin ensemble`: see its help text. Errors are thrown; exit_code is set otherwise.
void add_ensemble_command(CLI::App& app, int& exit_code);

// `quoin sensitivity`: the same study, every input tried by itself.
void add_sensitivity_command(CLI::App& app, int& exit_code);

}  // namespace quoin
