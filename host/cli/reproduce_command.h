// `quoin reproduce`: the studies of the paper, one command.
#pragma once

namespace CLI {
class App;
}

namespace quoin {
void add_reproduce_command(CLI::App& app, int& exit_code);
}
