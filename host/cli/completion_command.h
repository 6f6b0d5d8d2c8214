#pragma once

namespace CLI {
class App;
}

namespace quoin {

// `quoin completion bash|zsh|fish|man`: made of the commands that the program has when it runs, as --help is.
void add_completion_command(CLI::App& app);

}  // namespace quoin
