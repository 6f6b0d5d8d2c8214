#include "cli/validate_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/printable.h"
#include "files/file.h"
#include "files/notice.h"
#include "files/result_folder.h"
#include "reproduce/run_cache.h"
#include "validate/page.h"

namespace quoin {

namespace {

namespace fs = std::filesystem;
using namespace validate;

// Rows of brick_walls.csv for --short: diagonal, rocking, a cantilever, unfilled head joints.
const std::set<std::string> kShort{"2", "25", "26", "35"};

struct ValidateOptions {
  std::string walls, out = "out/validate";
  std::vector<std::string> overrides;
  bool cyclic = false, short_run = false;
  int jobs = 0, samples = 0;
};

void validate_walls(const ValidateOptions& options, int& exit_code) {
  const std::string file = options.walls.empty()
                               ? (reproduce::find_scenes().parent_path() / "validate" / "brick_walls.csv").string()
                               : options.walls;
  WallTable table = read_wall_table(file);
  if (options.short_run) {
    std::erase_if(table.rows, [](const WallRow& row) { return !kShort.contains(row.number); });
  }
  for (const std::string& fault : table.faults) notice("quoin: " + fault + "; the row is left out");

  CampaignSettings settings;
  settings.out = options.out, settings.cyclic = options.cyclic, settings.overrides = options.overrides;
  settings.samples = options.samples;
  settings.jobs = options.jobs > 0 ? options.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  refuse_folder_of_run(settings.out);
  list_own_files(settings.out, {"validation.csv", "bands.csv", "index.html"});
  const FolderLock lock(settings.out);
  const Campaign campaign = run_campaign(table, settings);
  for (std::size_t i = table.faults.size(); i < campaign.faults.size(); ++i) notice("quoin: " + campaign.faults[i]);
  write_file(settings.out / "validation.csv", validation_csv(campaign));
  if (!campaign.bands.empty()) write_file(settings.out / "bands.csv", bands_csv(campaign));
  write_file(settings.out / "index.html", page_of(campaign, settings));
  for (const Prediction& p : campaign.done)
    fmt::print("{:>4} {:<32} predicted {:7.1f} kN, measured {:7.1f} kN, ratio {:.2f}, mode {} ({})\n",
               printable(p.row.number), printable(p.row.name()), p.outcome.peak, p.row.peak(), p.ratio(),
               p.outcome.mode, p.mode_known() ? printable(p.row.failure_mode) : "not given");
  for (const Prediction& p : campaign.done) {
    if (const auto& along = p.outcome.along_envelope)
      fmt::print("{:>4} {:<32} force over the envelope's from 1 to 10 mm: {:.2f} to {:.2f}\n", printable(p.row.number),
                 printable(p.row.name()), (*along)[0], (*along)[1]);
  }
  for (const Band& b : campaign.bands)
    fmt::print("{:>4} {:<32} {} samples: peak {:.1f} to {:.1f} kN (16 to 84 %), median {:.1f}; measured {:.1f}\n",
               printable(b.row.number), printable(b.row.name()), b.peaks.size(), b.quantile(0.16), b.quantile(0.84),
               b.quantile(0.5), b.row.peak());
  const auto [met, known] = modes_met(campaign);
  fmt::print("peaks: {}\n", statistics_text(statistics_of(ratios_of(campaign, false))));
  fmt::print("without walls more than 15 % above rigid equilibrium: {}\n",
             statistics_text(statistics_of(ratios_of(campaign, true))));
  fmt::print("failure mode right: {} of {}; {} rows left out; read {}\n", met, known, campaign.faults.size(),
             (settings.out / "index.html").string());
  if (campaign.done.empty()) exit_code = static_cast<int>(Exit::bad_input);
}

}  // namespace

void add_validate_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("validate", "Predict walls that were tested, and hold them against the tests");
  auto options = std::make_shared<ValidateOptions>();
  command->add_option("--walls", options->walls, "Table of walls, columns as in brick_walls.csv (default: that one)")
      ->type_name("FILE.csv");
  command->add_option("--out", options->out, "Folder for results (default: out/validate)")->type_name("DIR");
  command->add_flag("--cyclic", options->cyclic, "In cycles of growing drift, with the law cyclic_joint");
  command->add_flag("--short", options->short_run, "Four walls of brick_walls.csv only: numbers 2, 25, 26, 35");
  command->add_option("--jobs", options->jobs, "Runs side by side (default: one a core)")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  command
      ->add_option("--bands", options->samples,
                   "Samples of each of three walls (2, 25, 33, or the first three), with properties that scatter as "
                   "the rule says: bands.csv")
      ->type_name("N")
      ->check(CLI::Range(1, 10000));
  command->add_option("--set", options->overrides, "Set a key in every scene; for trials")
      ->type_name("dotted.key=value")
      ->allow_extra_args(false);
  command->footer(
      "DIR/index.html is the report, DIR/validation.csv its numbers, DIR/scenes the scenes, which `quoin run` takes "
      "too,\n"
      "DIR/runs the runs. Walls that are done are not computed again; after Ctrl-C the same command goes on.\n"
      "Rows at fault are named with line and column and left out. Exit code 0 if any row ran, else 3.\n"
      "Example:\n"
      "  quoin validate --walls my_walls.csv --out out/my_walls");
  command->callback([options, &exit_code] { validate_walls(*options, exit_code); });
}

}  // namespace quoin
