// `quoin validate`: predictions of tested walls, compared with the measurements.
#pragma once

namespace CLI {
class App;
}

namespace quoin {
void add_validate_command(CLI::App& app, int& exit_code);
}
