#include "cli/modes_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/modes.h"
#include "analysis/state_modes.h"
#include "base/error.h"
#include "cli/prepare.h"
#include "cli/print_results.h"
#include "files/file.h"
#include "files/notice.h"
#include "files/result_folder.h"
#include "results/json_file.h"
#include "results/virtual_motion.h"
#include "scene/stage_named.h"

namespace quoin {
namespace {

struct Options {
  SceneOptions scene;
  ModesSettings settings;
  std::string stage, state = "undamaged", out;
};

void warn_of_zero_modes(const std::string& file, const Vibrating& v, const Modes& modes) {
  constexpr std::size_t kNamed = 5;
  if (modes.zero == 0) return;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(kNamed, modes.loose.size()); ++i)
    names.push_back(v.label[static_cast<std::size_t>(modes.loose[i])]);
  notice(
      fmt::format("quoin: {}: {} modes without stiffness, of block {}{}: no joint or support holds what moves in them",
                  file, modes.zero, fmt::join(names, ", "),
                  modes.loose.size() > kNamed ? fmt::format(" and {} more", modes.loose.size() - kNamed) : ""));
}

void print(const Vibrating& v, const Modes& modes) {
  fmt::print("supports: {}\n", v.held.empty() ? "none" : fmt::format("{}", fmt::join(v.held, "; ")));
  if (v.symmetry_factor != 1.0)
    fmt::print("half of the thickness is modelled: modes are those that are symmetric about the middle plane\n");
  fmt::print("mode  frequency   effective mass, % of what can move along\n");
  fmt::print("             Hz        x        y        z\n");
  for (std::size_t i = 0; i < modes.mode.size(); ++i) {
    const Mode& mode = modes.mode[i];
    fmt::print("{:4}  {:9.4g}", i + 1, mode.frequency);
    for (std::size_t c = 0; c < 3; ++c)
      fmt::print("  {:7.2f}", modes.free_mass[c] > 0.0 ? 100.0 * mode.effective_mass[c] / modes.free_mass[c] : 0.0);
    fmt::print("\n");
  }
  const Rayleigh& r = modes.rayleigh;
  if (r.frequencies[0] > 0.0)
    fmt::print(
        "Rayleigh damping of {:g} at {:.4g} Hz and {:g} at {:.4g} Hz: mass_damping = {:.6g}, stiffness_damping = "
        "{:.6g}\n",
        r.ratios[0], r.frequencies[0], r.ratios[1], r.frequencies[1], r.mass_damping, r.stiffness_damping);
}

std::string name_of_shape(const Modes& modes, std::size_t m) {
  return fmt::format("mode_{}_{:.4g}_Hz", m + 1, modes.mode[m].frequency);
}

void write_shapes(const std::filesystem::path& file, const Vibrating& v, const Modes& modes) {
  std::vector<StillBlock> blocks;
  for (const DrawnBlock& b : v.drawn) blocks.push_back({b.point, b.zone, b.face});
  std::vector<VirtualMotion> motions;
  for (std::size_t m = 0; m < modes.mode.size(); ++m) {
    VirtualMotion& motion = motions.emplace_back();
    motion.name = name_of_shape(modes, m);
    for (std::size_t b = 0; b < v.drawn.size(); ++b)
      motion.displacement.push_back(shape_of_block(v, modes, static_cast<int>(b), static_cast<int>(m)));
  }
  write_motions(file, blocks, motions);
}

void write_page(const std::filesystem::path& shapes, const Scene& scene, const Modes& modes) {
  std::vector<ShownMotion> motions;
  for (std::size_t m = 0; m < modes.mode.size(); ++m) {
    const Mode& mode = modes.mode[m];
    std::string label = fmt::format("mode {}: {:.4g} Hz; effective mass", m + 1, mode.frequency);
    for (std::size_t c = 0; c < 3; ++c)
      label +=
          fmt::format("{} {:.1f} % along {}", c > 0 ? "," : "",
                      modes.free_mass[c] > 0.0 ? 100.0 * mode.effective_mass[c] / modes.free_mass[c] : 0.0, "xyz"[c]);
    motions.push_back({name_of_shape(modes, m), label});
  }
  print_motion_report(shapes, "Natural modes", scene, motions, false);
}

void run(const Options& options) {
  const std::vector<std::string> files{"modes.json", "modes.vtu"};
  if (!options.out.empty()) refuse_folder_of_run(options.out), refuse_files_of_others(options.out, files);
  const bool undamaged = options.state == "undamaged";
  SceneOptions asked = options.scene;
  asked.runs = !undamaged;
  const Scene scene = prepare_scene(asked);
  const auto begin = std::chrono::steady_clock::now();
  const Vibrating v = undamaged ? vibrating(scene, stage_named(scene, options.stage))
                                : vibrating_about(scene, options.state, options.stage);
  const auto assembled = std::chrono::steady_clock::now();
  const Modes modes = find_modes(v, options.settings);
  const auto end = std::chrono::steady_clock::now();
  const auto seconds = [](auto from, auto to) { return std::chrono::duration<double>(to - from).count(); };
  fmt::print("{}: {} blocks, {} contact points, {} degrees of freedom; {:.2g} s to set up, {:.2g} s to solve\n",
             scene.file, v.drawn.size() - v.members, v.points, v.unknown.size(), seconds(begin, assembled),
             seconds(assembled, end));
  if (!undamaged) fmt::print("{} of {} contact points carry nothing\n", v.open, v.points);
  warn_of_zero_modes(scene.file, v, modes);
  print(v, modes);
  if (options.out.empty()) return;
  const std::filesystem::path folder = options.out;
  list_own_files(folder, files);
  write_json(folder / "modes.json", json_of(scene.file, v, modes));
  write_shapes(folder / "modes.vtu", v, modes);
  fmt::print("{}\n", (folder / "modes.json").string());
  write_page(folder / "modes.vtu", scene, modes);
}

}  // namespace

void add_modes_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("modes", "Natural frequencies and mode shapes, without a run");
  const auto options = std::make_shared<Options>();
  command->add_option("scene", options->scene.scene, "Scene file")->type_name("SCENE.toml")->required();
  command->add_option("--count", options->settings.count, "How many modes, from the lowest frequency")
      ->capture_default_str();
  command->add_option("--stage", options->stage, "Whose supports hold the blocks; else the first")->type_name("NAME");
  command
      ->add_option("--state", options->state,
                   "undamaged; weight: at rest under the loads of the stage; or the folder of a run of this scene with "
                   "output.end_state = true, at whose end open joints are open")
      ->type_name("STATE")
      ->capture_default_str();
  command->add_option("--ratios", options->settings.ratios, "Of critical damping, for Rayleigh's alpha and beta")
      ->type_name("Z1 Z2")
      ->capture_default_str();
  command->add_option("--at", options->settings.at_frequencies, "Hz, where these ratios hold; else first and last mode")
      ->type_name("F1 F2");
  command->add_option("--law", options->scene.law, "Law for all joints in place of the scene's");
  command->add_option("--set", options->scene.overrides, "dotted.key=value: set a key of the scene; may be repeated");
  command->add_option("--out", options->out, "Folder for modes.json, modes.vtu and report.html, where the shapes swing")
      ->type_name("DIR");
  command->footer(
      "Of the scene as it is at the start, undamaged and without stress: joints closed, with the stiffness of their "
      "laws,\n"
      "blocks elastic or rigid, supports those that quoin check lists for the stage. Of a state: joints as they answer "
      "a\n"
      "small motion there, and what forces add to stiffness as they turn.\n"
      "Examples:\n"
      "  quoin modes host/scenes/pavia_door.toml --out out/modes\n"
      "  quoin modes host/scenes/arch.toml --state weight\n"
      "  quoin modes host/scenes/arch.toml --count 4 --ratios 0.05 0.02");
  command->callback([options] { run(*options); });
}

}  // namespace quoin
