#include "cli/report_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <vector>

#include "results/report.h"

namespace quoin {

namespace {

// Progress over frames, of which large models take seconds each.
class FrameProgress {
 public:
  void operator()(const std::filesystem::path& folder, std::size_t frame, std::size_t frames) {
    const auto now = Clock::now();
    if (now - reported_ < std::chrono::seconds(2)) return;
    reported_ = now;
    fmt::print(stderr, "{}: frame {} of {}\n", folder.string(), frame, frames);
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point reported_ = Clock::now();
};

}  // namespace

void add_report_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("report", "Write a page of a run, to be opened in a browser");
  auto folders = std::make_shared<std::vector<std::string>>();
  command->add_option("folders", *folders, "Folder of results; a second one is shown beside it")
      ->type_name("DIR")
      ->required()
      ->expected(1, 2);
  command->footer(
      "Writes DIR/report.html: one file, opened from the disk, without network. It shows the model from the front, "
      "side,\n"
      "top or obliquely, coloured by damage, opening, slip, stress or displacement; numbers of what is under the "
      "pointer;\n"
      "the curve that goes with the stage; energies; settings, warnings, known error. It saves what it shows as PNG.\n"
      "Examples:\n"
      "  quoin report out/solid_wall_030\n"
      "  quoin report out/solid_wall_030 /tmp/brittle        two runs side by side\n"
      "  quoin run host/scenes/arch.toml --report            at the end of a run");
  command->callback([folders] {
    fmt::print("{}\n", write_report({folders->begin(), folders->end()}, FrameProgress()).string());
  });
}

}  // namespace quoin
