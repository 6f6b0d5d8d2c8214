#include "cli/run_command.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>

#include "cli/law_seconds.h"
#include "cli/process_seconds.h"
#include "cli/run.h"

namespace quoin {

namespace {

std::string is_given(const std::string& text) { return text.empty() ? "the name is empty" : ""; }

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  process_seconds();  // starts the clock
  CLI::App* command = app.add_subcommand("run", "Run a scene and write its results");
  auto options = std::make_shared<RunOptions>();
  CLI::Option* scene =
      command->add_option("scene", options->scene.scene, "Scene file; host/scenes/README.md lists its keys")
          ->type_name("SCENE.toml");
  CLI::Option* out =
      command->add_option("--out", options->out, "Folder for the results (default: out/<name of the scene>)")
          ->type_name("DIR");
  command->add_option("--threads", options->threads, "Threads (default: all of the machine)")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  CLI::Option* law =
      command
          ->add_option("--law", options->scene.law, "Law for all joints in place of the scene's: a name or a library")
          ->type_name("NAME_OR_PATH")
          ->check(is_given);
  CLI::Option* set = command->add_option("--set", options->scene.overrides, "Set a key of the scene; may be repeated")
                         ->type_name("dotted.key=value")
                         ->allow_extra_args(false);
  command->add_flag("--report", options->report, "Write report.html too, a page of the run (quoin report --help)");
  command->add_flag("--histories", options->histories,
                    "Write histories.png: displacements, forces and energies over time; in earthquakes base_shear.png, "
                    "with monitors that have `below` drifts.png");
  command->add_flag("--svg", options->svg, "Write each picture as SVG too, beside its PNG");
  command->add_flag(
      "--live", [options](std::int64_t) { options->serve = 0; },
      "Show the run in a browser while it goes on, at an address of this machine that is printed");
  command->add_option("--serve", options->serve, "The same at this port; 0: any that is free")
      ->type_name("PORT")
      ->check(CLI::Range(0, 65535));
  command->add_flag("--compressed", options->compressed, "Compress the files for ParaView");
  command->add_flag("--force", options->scene.force, "Go on where the model seems too large for this machine");
  command->add_flag("--isolate-law", options->isolate_law,
                    "Evaluate each law in a process of its own: its crash costs the law and keeps the results; slower");
  add_law_seconds(*command, options->law_seconds);
  command
      ->add_option("--checkpoint-every", options->checkpoint_every,
                   "Seconds between two checkpoints, from which --resume goes on; 0: none (default: 60)")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 1e9))
      ->check(is_number);
  CLI::Option* resume =
      command
          ->add_option("--resume", options->resume,
                       "Go on with the run in this folder, which was stopped or killed, from its last checkpoint")
          ->type_name("DIR")
          ->excludes(scene, out, law, set);
  command
      ->add_option(
          "--again", options->again,
          "Repeat the run in this folder, as its summary.json has it, and say whether the bits agree (results to "
          "DIR-again)")
      ->type_name("DIR")
      ->excludes(scene, law, set, resume);
  command->footer(
      "Results: history.csv, summary.json, curve.png, cracks.png, blocks.pvd, joints.pvd and forces.pvd (for "
      "ParaView).\n"
      "Ctrl-C stops a run and keeps its results; a second one leaves out pictures, a third one ends at once.\n"
      "Examples:\n"
      "  quoin run host/scenes/solid_wall_030.toml\n"
      "  quoin run host/scenes/solid_wall_030.toml --live        in a browser while it goes on\n"
      "  quoin run host/scenes/solid_wall_030.toml --out /tmp/brittle --law coulomb_slip\n"
      "  quoin run host/scenes/solid_wall_030.toml --law ./my_law.so --threads 2\n"
      "  quoin run host/scenes/solid_wall_030.toml --set solver.quality=fast       or reference: slower, smaller "
      "error\n"
      "  quoin run host/scenes/wall_2m_576.toml --out /tmp/long --checkpoint-every 300\n"
      "  quoin run --resume /tmp/long      after a crash, kill or Ctrl-C: the results are those of one run\n"
      "  quoin run --again /tmp/long       the same run once more: are the bits the same?\n"
      "  quoin run host/scenes/solid_wall_121.toml --set stage.shear.velocity=0.01 --set "
      "joints.mortar.cohesion=0.35e6");
  command->callback([options, scene, &exit_code] {
    if (options->resume.empty() && options->again.empty() && scene->count() == 0)
      throw CLI::RequiredError("SCENE.toml, --resume DIR or --again DIR");
    run_on_ranks(*options, exit_code);
  });
}

}  // namespace quoin
