#include "cli/reproduce_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <thread>

#include "base/error.h"
#include "files/file.h"
#include "files/notice.h"
#include "files/result_folder.h"
#include "reproduce/page.h"
#include "reproduce/run_cache.h"
#include "reproduce/study.h"
#include "reproduce/verdict_file.h"

namespace quoin {

namespace {

namespace fs = std::filesystem;
using namespace reproduce;

struct ReproduceOptions {
  std::vector<std::string> studies, overrides;
  std::string out = "out/reproduce", quality = "standard";
  bool list = false, again = false, slow = false, beyond = false;
  int jobs = 0;
};

// The last line, of all studies. failed: studies without an evaluation.
std::string outcome_text(int missed, int failed, std::size_t studies) {
  std::vector<std::string> parts;
  if (missed > 0) parts.push_back(fmt::format("{} claims not reproduced", missed));
  if (failed > 0) parts.push_back(fmt::format("{} of {} studies not evaluated, as runs are missing", failed, studies));
  return parts.empty() ? "every claim reproduced" : fmt::format("{}", fmt::join(parts, "; "));
}

void reproduce_studies(const ReproduceOptions& options, int& exit_code) {
  if (options.list) {
    for (const Study& s : studies()) fmt::print("{:<15} {} ({})\n", s.id, s.title, s.figures);
    return;
  }
  std::vector<const Study*> chosen;
  for (const Study& s : studies()) {
    const bool named = std::find(options.studies.begin(), options.studies.end(), s.id) != options.studies.end();
    if (named || (s.beyond ? options.beyond : options.studies.empty())) chosen.push_back(&s);
  }
  Quality quality;
  for (const Quality& q : qualities()) {
    if (q.name == options.quality) quality = q;
  }
  quality.slow_runs = quality.slow_runs || options.slow;

  CacheSettings settings;
  settings.root = options.out;
  settings.scenes = find_scenes();
  settings.overrides = options.overrides;
  settings.jobs = options.jobs > 0 ? options.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  settings.again = options.again;
  RunCache cache(settings);

  // All runs of all studies together: shared ones run once, and cores are in use to the end.
  std::vector<RunSpec> specs;
  for (const Study* study : chosen) {
    for (RunSpec& spec : study->runs(quality)) specs.push_back(std::move(spec));
  }
  if (specs.empty() && !options.overrides.empty())
    throw Error(Exit::usage, "--set: without effect, as these studies run no scene; leave it out");
  refuse_folder_of_run(settings.root);
  list_own_files(settings.root, {"index.html", "verdict.json", "beyond.json"});
  const FolderLock lock(settings.root);
  const int code = cache.compute(specs);

  int missed = 0, failed = 0;
  for (const Study* study : chosen) {
    std::map<std::string, RunResult> runs;
    for (const RunSpec& spec : study->runs(quality)) runs[spec.name] = cache.result(spec);
    const Findings findings(settings.root, study->id, quality, std::move(runs));
    make_folder(findings.folder());
    StudyReport report;
    try {
      report = study->report(findings);
    } catch (const Error& error) {
      report.notices.push_back(error.what());
      ++failed;
    }
    write_section(settings.root, *study, quality, report);
    write_verdicts(verdict_file(settings.root, *study), study->id, report);
    for (const Verdict& v : report.verdicts) {
      fmt::print("{}\n", verdict_line(study->id, v));
      missed += !v.reproduced;
    }
    for (const std::string& notice : report.notices) quoin::notice(fmt::format("quoin: {}: {}", study->id, notice));
  }
  write_page(settings.root);
  fmt::print("{}; read {}\n", outcome_text(missed, failed, chosen.size()), (settings.root / "index.html").string());
  if (failed > 0) exit_code = code != 0 ? code : static_cast<int>(Exit::numerical);
}

}  // namespace

void add_reproduce_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("reproduce", "Run the studies of the paper, and hold them against it");
  auto options = std::make_shared<ReproduceOptions>();
  std::vector<std::string> ids, qualities_known;
  for (const Study& s : studies()) ids.push_back(s.id);
  for (const Quality& q : qualities()) qualities_known.push_back(q.name);
  command->add_option("study", options->studies, "Studies (default: all of the paper)")
      ->type_name("STUDY...")
      ->check(CLI::IsMember(ids));
  command->add_option("--out", options->out, "Folder for results (default: out/reproduce)")->type_name("DIR");
  command
      ->add_option("--quality", options->quality, "fast, standard (default) or reference: walls at 40, 20 or 2.5 mm/s")
      ->type_name("QUALITY")
      ->check(CLI::IsMember(qualities_known));
  command->add_option("--jobs", options->jobs, "Runs side by side (default: one a core)")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  command
      ->add_option("--set", options->overrides, "Set a key in every scene; for trials, the verdicts mean nothing then")
      ->type_name("dotted.key=value")
      ->allow_extra_args(false);
  command->add_flag("--slow", options->slow, "The run at 0.1 mm/s too (half an hour on one core)");
  command->add_flag("--again", options->again, "Compute runs that are done once more");
  command->add_flag("--beyond", options->beyond,
                    "Studies beyond the paper too, with their verdicts in DIR/beyond.json");
  command->add_flag("--list", options->list, "Name the studies");
  command->footer(
      "DIR/index.html is the report, DIR/verdict.json its verdicts, DIR/STUDY the data and plots of a study, DIR/runs\n"
      "the runs. Runs that are done are not computed again; after Ctrl-C the same command goes on.\n"
      "Examples:\n"
      "  quoin reproduce --list\n"
      "  quoin reproduce walls brittle --quality fast\n"
      "  quoin reproduce --out /tmp/paper                   everything, less than 30 minutes on two cores");
  command->callback([options, &exit_code] { reproduce_studies(*options, exit_code); });
}

}  // namespace quoin
