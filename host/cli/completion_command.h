#pragma once

namespace CLI {
class App;
}

namespace quoin {

// Adds `quoin completion bash|zsh|fish|man`, whose texts follow from the registered commands, as --help does.
void add_completion_command(CLI::App& app);

}  // namespace quoin
