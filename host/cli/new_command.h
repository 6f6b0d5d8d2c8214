// `quoin new`: commented templates of scenes and laws.
#pragma once

namespace CLI {
class App;
}

namespace quoin {

void add_new_command(CLI::App& app);

}  // namespace quoin
