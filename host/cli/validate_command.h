// `quoin validate`: walls that were tested, predicted and compared with what was measured.
#pragma once

namespace CLI {
class App;
}

namespace quoin {
void add_validate_command(CLI::App& app, int& exit_code);
}
