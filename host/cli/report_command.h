// `quoin report`: the page of a run.
#pragma once

namespace CLI {
class App;
}

namespace quoin {

void add_report_command(CLI::App& app);

}  // namespace quoin
