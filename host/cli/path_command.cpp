#include "cli/path_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "cli/law_seconds.h"
#include "files/file.h"
#include "files/notice.h"
#include "law/csv_table.h"
#include "law/material_point.h"
#include "law/path_file.h"
#include "law/property_text.h"

namespace quoin {

namespace {

struct Options {
  std::vector<std::string> files;
  std::string law, jumps, out, initial, plot;
  std::vector<std::string> settings;
  bool verbose = false, force = false;
  double law_seconds = kLawSeconds;
};

// Evaluates jumps from a table: one increment per row, from zero.
void run_jumps(const Options& options) {
  const Law law = Law::find(options.law);
  std::vector<PropertySetting> settings;
  for (const std::string& text : options.settings) settings.push_back(parse_setting(*law.law, text, Source{"--set"}));
  const CsvTable table = read_csv(options.jumps);
  const bool pressed = table.column("sigma", "Pa") >= 0;
  const int normal = pressed ? table.column("sigma", "Pa") : table.column("dn", "m");
  const int s = table.column("ds", "m"), t = table.column("dt", "m");
  if (table.columns.size() != 3 || normal < 0 || s < 0 || t < 0) {
    std::string header;
    for (const std::string& column : table.columns) header += (header.empty() ? "" : ",") + column;
    throw Error(Exit::bad_input,
                fmt::format("{}: header '{}': the columns must be dn (m), ds (m), dt (m), or sigma (Pa), ds (m), "
                            "dt (m), with these units or without",
                            options.jumps, header));
  }

  const auto material = std::make_shared<const Material>(law, settings);
  if (!material->warnings().empty()) notice("warning: " + material->warnings());
  MaterialPoint point(material, options.initial);
  std::string output = path_header(*law.law);
  std::size_t clamped = 0;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const std::vector<double>& row = table.rows[i];
    try {
      if (pressed) {
        point.press_to(row[normal], row[s], row[t]);
      } else {
        point.move_to(row[normal], row[s], row[t]);
      }
    } catch (const Error& error) {
      throw Error(error.exit_code, fmt::format("{}:{}: {}", options.jumps, table.lines[i], error.what()));
    }
    clamped += point.now().status == QUOIN_POINT_CLAMPED ? 1 : 0;
    output += path_row(*law.law, point.now());
  }
  if (clamped > 0)
    notice(fmt::format("warning: the law limited its input in {} of {} rows", clamped, table.rows.size()));
  write_named_file(options.out, output);
}

// Runs path tests. Returns whether all expectations hold.
bool run_files(const Options& options) {
  std::size_t failed = 0;
  for (const std::string& file : options.files) {
    const PathFile path = read_path_file(file);
    const PathOutcome outcome = run_path(path, options.law, options.force);
    const bool passed = outcome.failures.empty();
    failed += passed ? 0 : 1;
    fmt::print("{}  {}: {} ({} checks, {} steps, largest error {:.2g} of its tolerance)\n", passed ? "pass" : "FAIL",
               file, path.title, outcome.checks, outcome.rows.size() - 1, outcome.worst);
    // A broken law fails at every step of a curve: the first few failures suffice.
    const std::size_t shown =
        options.verbose ? outcome.failures.size() : std::min<std::size_t>(outcome.failures.size(), 5);
    for (std::size_t i = 0; i < shown; ++i) fmt::print("      {}\n", outcome.failures[i]);
    if (shown < outcome.failures.size()) {
      fmt::print("      and {} more (--verbose shows them)\n", outcome.failures.size() - shown);
    }
    if (!options.plot.empty()) fmt::print("      {}\n", plot_path(path, outcome, options.plot));
    if (!options.out.empty()) {
      const Law law = Law::find(options.law.empty() ? path.law : options.law);
      std::string output = path_header(*law.law);
      for (std::size_t i = 1; i < outcome.rows.size(); ++i) output += path_row(*law.law, outcome.rows[i]);
      write_named_file(options.out, output);
    }
  }
  if (options.files.size() > 1) {
    fmt::print("{} of {} path tests passed\n", options.files.size() - failed, options.files.size());
  }
  return failed == 0;
}

}  // namespace

void add_path_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("path", "Drive one contact point along a path, or run path tests");
  const auto options = std::make_shared<Options>();
  command->add_option("files", options->files, "Path tests (TOML): law, properties, path and expected answers");
  command->add_option("--law", options->law, "Name or path of a law (path tests: instead of the one they name)");
  command->add_option("--set", options->settings, "id=value, for --jumps (softening_table=0:1,0.3:0.5,1:0)")
      ->expected(1)
      ->take_all()
      ->trigger_on_parse(false);
  command->add_option("--jumps", options->jumps,
                      "CSV with the columns dn, ds, dt (m), or sigma (Pa), ds, dt (m): totals, from zero");
  command->add_option("--out", options->out, "CSV to write: one row per increment");
  command->add_option("--initial", options->initial, "Initial state (bonded, dry); default: the law's first");
  command->add_option("--plot", options->plot,
                      "Folder for PNG plots beside the closed forms (path tests; needs gnuplot)");
  command->add_flag("--force", options->force, "Go on where the steps seem too many for the memory here");
  add_law_seconds(*command, options->law_seconds);
  command->add_flag("--verbose", options->verbose, "Show every failed check");
  command->footer(
      "Exit code 5: a check of a path test failed, or the law failed numerically.\n"
      "Formats: host/law/path_file.h; examples: tests/law/paths");
  command->callback([options, &exit_code] {
    const LawWatchdog watchdog = limit_laws(options->law_seconds);
    const bool tests = !options->files.empty();
    if (tests == !options->jumps.empty()) {
      throw Error(Exit::usage, "path: give either path tests (FILE.toml...) or --law, --jumps and --out");
    }
    if (tests) {
      if (!options->settings.empty() || !options->initial.empty()) {
        throw Error(Exit::usage, "path: --set and --initial go with --jumps; a path test holds its own properties");
      }
      if (!options->out.empty() && options->files.size() > 1)
        throw Error(Exit::usage, "path: --out takes one path test");
      refuse_input_as_output(options->out, options->files);
      if (!run_files(*options)) exit_code = static_cast<int>(Exit::numerical);
      return;
    }
    if (options->law.empty()) throw Error(Exit::usage, "path: --law is missing");
    if (options->out.empty()) throw Error(Exit::usage, "path: --out is missing");
    if (!options->plot.empty()) throw Error(Exit::usage, "path: --plot goes with path tests");
    refuse_input_as_output(options->out, {options->jumps});
    run_jumps(*options);
  });
}

}  // namespace quoin
