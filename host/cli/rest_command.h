#pragma once

namespace CLI {
class App;
}

namespace quoin {

// `quoin rest`: see its help text. Errors are thrown; exit_code is set otherwise.
void add_rest_command(CLI::App& app, int& exit_code);

}  // namespace quoin
