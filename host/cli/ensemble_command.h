#pragma once

namespace CLI {
class App;
}

namespace quoin {

// Adds `quoin ensemble`; its help describes it. Throws errors; otherwise sets exit_code.
void add_ensemble_command(CLI::App& app, int& exit_code);

// Adds `quoin sensitivity`: a study that varies one input at a time.
void add_sensitivity_command(CLI::App& app, int& exit_code);

}  // namespace quoin
