#include "cli/rest_command.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/run.h"
#include "scene/rest_scene.h"

namespace quoin {

namespace fs = std::filesystem;

void add_rest_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("rest", "The state at rest under weight and constant loads");
  auto options = std::make_shared<RunOptions>();
  auto stage = std::make_shared<std::string>();
  command->add_option("scene", options->scene.scene, "Scene file")->type_name("SCENE.toml")->required();
  command->add_option("--out", options->out, "Folder for the results (default: out/<name of the scene>_rest)")
      ->type_name("DIR");
  command
      ->add_option("--stage", *stage,
                   "Whose weight, forces, pressures and supports; else the first that has a weight or a load")
      ->type_name("NAME");
  command->add_option("--threads", options->threads, "Threads (default: all of the machine)")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  command->add_option("--law", options->scene.law, "Law for all joints in place of the scene's");
  command->add_option("--set", options->scene.overrides, "dotted.key=value: set a key of the scene; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--report", options->report, "Write report.html too, a page of the state");
  command->add_flag("--force", options->scene.force, "Go on where the model seems too large for this machine");
  command->footer(
      "A stage of kind rest in place of all of the scene's: equilibrium is found by Newton's method and settled by "
      "steps.\n"
      "What the stage moves, shakes or lets grow is left out. Results are those of a run; end_state.bin is where\n"
      "scenes with start = \"DIR\" begin, whose first stage is that one, and quoin modes --state DIR.\n"
      "Examples:\n"
      "  quoin rest host/scenes/arch.toml --out out/arch_rest\n"
      "  quoin modes host/scenes/arch.toml --state weight");
  command->callback([options, stage, &exit_code] {
    if (options->out.empty()) options->out = "out/" + fs::path(options->scene.scene).stem().string() + "_rest";
    options->scene.overrides.push_back(std::string(kRestAsked) + *stage);
    run_on_ranks(*options, exit_code);
  });
}

}  // namespace quoin
