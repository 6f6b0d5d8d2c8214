#pragma once

namespace CLI {
class App;
}

namespace quoin {

// Adds `quoin models`; its help describes it. Throws errors; otherwise sets exit_code.
void add_models_command(CLI::App& app, int& exit_code);

}  // namespace quoin
