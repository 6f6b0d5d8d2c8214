#include "cli/ensemble_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <thread>

#include "base/error.h"
#include "base/input_file.h"
#include "cli/prepare.h"
#include "ensemble/kept_study.h"
#include "ensemble/page.h"
#include "ensemble/pool.h"
#include "ensemble/sensitivity.h"
#include "ensemble/shake.h"
#include "ensemble/slurm.h"
#include "ensemble/sobol_table.h"
#include "ensemble/suite_page.h"
#include "files/notice.h"
#include "law/law_library.h"
#include "results/provenance.h"

namespace quoin {

namespace {

namespace fs = std::filesystem;
using namespace ensemble;

struct EnsembleOptions {
  std::string study, out;
  std::uint64_t samples = 0;  // 0: number of the study
  std::uint64_t rows = 0;     // rows of Sobol's indices; 0: not requested
  int jobs = 0, tasks = 32;
  bool slurm = false, detach = false, gather = false, worker = false, no_pictures = false;
  std::vector<std::string> overrides;
};

Scene scene_with(const Study& study, const std::vector<std::string>& overrides) {
  SceneOptions options;
  options.scene = study.scene;
  options.overrides = overrides;
  options.runs = true;
  return prepare_scene(options);
}
Scene scene_of(const Study& study, std::uint64_t sample) { return scene_with(study, study.overrides_of(sample)); }

// Scene with all quantities at their means, and the first record.
Scene scene_of_means(const Study& study) {
  std::vector<std::string> overrides = study.overrides_of(0);
  if (study.suite.any()) {
    const std::vector<std::string> shaken = overrides_for(study.suite, 0, motion_of(study.suite, 0), 1.0);
    overrides.insert(overrides.end(), shaken.begin(), shaken.end());
  }
  return scene_with(study, overrides);
}

// A study with all its input, read once, so that later changes of files do not affect its samples.
struct ReadStudy {
  StudyRequest request;
  fs::path folder;  // folder of its results
  Study study;
  Scene scene;            // all quantities at their means: finds faults common to all samples
  std::vector<Law> laws;  // laws of the samples, loaded
};

// suffix: of the default folder of results.
ReadStudy read(const EnsembleOptions& options, Trials trials = Trials::drawn, const std::string& suffix = "") {
  ReadStudy all;
  all.request = {options.study, options.overrides};
  all.folder = options.out.empty() ? fs::path("out") / (fs::path(options.study).stem().string() + suffix)
                                   : fs::path(options.out);
  if (is_kept_study(options.study)) {
    all.folder = fs::absolute(options.study);
    std::error_code unknown;
    if (!options.out.empty() && !fs::equivalent(options.out, options.study, unknown))
      throw Error(Exit::usage, fmt::format("--out {}: not with a folder in place of the study, which is where its "
                                           "samples are: {}",
                                           options.out, options.study));
    all.request = take_kept_study(all.folder);
    all.request.overrides.insert(all.request.overrides.end(), options.overrides.begin(), options.overrides.end());
  }
  kept_inputs().begin();
  all.study = read_study(all.request.study);
  all.study.overrides.insert(all.study.overrides.end(), all.request.overrides.begin(), all.request.overrides.end());
  all.study.trials = trials;
  if (options.samples > 0) all.study.samples = options.samples;
  all.scene = scene_of_means(all.study);
  add_scatter_of(all.scene, all.study);
  for (const std::string& file : all.scene.inputs) read_input_file(file);
  for (const HashedFile& law : law_files(all.scene)) all.laws.push_back(Law::find(law.name));
  kept_inputs().end();
  check_study(all.study, all.scene);
  if (!all.scene.start.empty()) {
    all.study.start = (fs::path(all.scene.start) / "end_state.bin").string();
    all.study.start_sha256 = sha256_of_file(all.study.start);
  }
  return all;
}

void report(const Gathered& gathered, const StudyFolder& folder, std::uint64_t samples) {
  fmt::print("{} of {} samples finished, {} of them failed", gathered.finished, samples, gathered.failed);
  if (std::isfinite(gathered.peak)) {
    fmt::print("; peak {:.2f} kN on average", gathered.peak / 1e3);
    if (std::isfinite(gathered.scatter)) fmt::print(", scatter {:.2f} kN", gathered.scatter / 1e3);  // of two at least
    if (std::isfinite(gathered.of_means))  // else its run has not ended
      fmt::print("; with everything at its mean {:.2f} kN", gathered.of_means / 1e3);
  }
  fmt::print("; results in {}\n", (folder.path() / "index.html").string());
}

// Writes results and prints their places. Returns the number of samples in them.
std::uint64_t gather_and_report(const StudyFolder& folder, const Study& study, bool pictures) {
  if (!study.suite.any()) {
    const Gathered gathered = gather(folder, study, study.samples, pictures);
    report(gathered, folder, study.samples);
    return gathered.finished;
  }
  const SuiteResults results = gather_suite(folder, study, pictures);
  fmt::print("{} of {} finished (records times walls), {} of them failed, {} runs\n{}results in {}\n", results.finished,
             study.tasks(), results.failed, results.runs, results.text, (folder.path() / "index.html").string());
  return results.finished;
}

// Waits for the tasks of a job. Ctrl-C ends the wait, not the tasks.
void wait_for(const std::string& job, const StudyFolder& folder, const Study& study) {
  const std::uint64_t all = study.tasks() + 1 - study.first_task();
  std::uint64_t reported = 0;
  for (int quiet = 0; quiet < 2;) {
    std::uint64_t done = 0;
    for (std::uint64_t i = study.first_task(); i <= study.tasks(); ++i) done += is_finished(folder.sample(i)) ? 1 : 0;
    if (done >= all) return;
    if (done >= reported + std::max<std::uint64_t>(1, all / 10))
      notice(fmt::format("{}/{} samples", reported = done, all));
    quiet = is_queued(job) ? 0 : quiet + 1;
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
}

void compute_by_slurm(const EnsembleOptions& options, const StudyFolder& folder, const Study& study) {
  const std::uint64_t samples = study.samples;
  // The folder replaces the study: tasks may begin long after its files have been edited.
  const std::vector<std::string> words{fs::read_symlink("/proc/self/exe").string(),
                                       "ensemble",
                                       fs::absolute(folder.path()).string(),
                                       "--samples",
                                       std::to_string(samples),
                                       "--jobs",
                                       "1",
                                       "--worker"};
  const int tasks = static_cast<int>(
      std::min<std::uint64_t>(static_cast<std::uint64_t>(options.tasks), study.tasks() + 1 - study.first_task()));
  const std::string job = submit(folder.path(), words, tasks);
  notice(
      fmt::format("job {} of Slurm: {} workers; results, also before the end: quoin ensemble {} --samples {} --gather",
                  job, tasks, folder.path().string(), samples));
  if (!options.detach) wait_for(job, folder, study);
}

void compute_here(const EnsembleOptions& options, const StudyFolder& folder, const Study& study) {
  PoolSettings settings;
  settings.first = study.first_task(), settings.samples = study.tasks();
  settings.jobs = options.jobs > 0 ? options.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  settings.wait_for_others = !options.worker;
  study.draw();
  compute_samples(folder, settings,
                  {[&](std::uint64_t sample, const fs::path& place) {
                     if (study.suite.any())
                       return shake_sample(
                           study, sample, [&](const std::vector<std::string>& set) { return scene_with(study, set); },
                           place);
                     run_sample(
                         study, sample, [&] { return scene_of(study, sample); }, place);
                   },
                   [&](std::uint64_t sample, const fs::path& place, const std::string& reason) {
                     write_failed(study, sample, place, reason);
                   },
                   is_finished});
}

// Throws if all samples from `first` on have failed. says: prints how many runs failed, whose rows are left out.
// Sample 0 has all inputs at their means.
void require_results(const StudyFolder& folder, std::uint64_t first, std::uint64_t last, bool says) {
  std::uint64_t failed = 0;
  bool done = false;
  std::string reason;
  for (std::uint64_t i = first; i <= last && (says || !done); ++i) {
    if (!is_finished(folder.sample(i))) continue;
    const Sample sample = read_sample(folder.sample(i));
    if (sample.status == "done")
      done = done || i > 0;
    else if (++failed == 1)
      reason = fmt::format("sample {}: {}", i, sample.reason);
  }
  const std::uint64_t runs = last + 1 - first;
  if (says && failed > 0)
    notice(fmt::format("quoin: {} of {} runs failed, and what depends on them is left out; {}", failed, runs, reason));
  if (!done && failed > 0)
    throw Error(Exit::numerical, fmt::format("all samples failed, {} of {} until now; {}", failed, runs, reason));
}

void run_ensemble(const EnsembleOptions& options) {
  ReadStudy read_once = read(options);
  Study& study = read_once.study;
  const std::uint64_t samples = study.tasks();
  const StudyFolder folder(read_once.folder, study, read_once.scene, read_once.request);
  if (options.slurm) {
    compute_by_slurm(options, folder, study);
    if (options.detach) return;
  } else if (!options.gather) {
    compute_here(options, folder, study);
    if (options.worker) return;
  }
  const std::uint64_t finished = gather_and_report(folder, study, !options.no_pictures);
  require_results(folder, 1, samples, false);
  if (finished < samples && !options.gather)
    throw Error(Exit::numerical,
                fmt::format("{} samples are missing, as their workers have ended: {}/slurm-*.log may say why; "
                            "the same command computes them",
                            samples - finished, folder.path().string()));
}

void run_sensitivity(const EnsembleOptions& options) {
  ReadStudy read_once = options.rows > 0 ? read(options, Trials::exchanged, "_sobol")
                                         : read(options, Trials::one_at_a_time, "_sensitivity");
  Study& study = read_once.study;
  const std::size_t inputs = study.inputs().size();
  if (study.suite.any())
    throw Error(
        Exit::bad_input,
        fmt::format("{}: a study with [[record]]; give it to quoin ensemble, or remove [shaking] and the records",
                    options.study));
  if (inputs == 0)
    throw Error(Exit::bad_input,
                fmt::format("{}: nothing scatters; add [[quantity]], or distributions below [set]", options.study));
  const auto is_correlated = [](const auto& family) { return !family.second.correlation.empty(); };
  if (!study.correlation.empty() || std::ranges::any_of(read_once.scene.joints, is_correlated))
    notice(
        fmt::format("quoin: {}: correlation is left out, as inputs are independent in a sensitivity study; quoin "
                    "ensemble draws with it",
                    options.study));
  if (options.rows == 0) {
    study.samples = 2 * inputs;
    const StudyFolder folder(read_once.folder, study, read_once.scene, read_once.request);
    compute_here(options, folder, study);
    fmt::print("{}", write_sensitivity(folder, study, !options.no_pictures));
    fmt::print("results in {}\n", (folder.path() / "sensitivity.csv").string());
    return require_results(folder, 0, study.samples, true);
  }
  if (2 * inputs > random::kMostSobolDimensions)
    throw Error(Exit::bad_input, fmt::format("{}: {} inputs; --sobol takes at most {}; leave some at their means",
                                             options.study, inputs, random::kMostSobolDimensions / 2));
  study.samples = options.rows * (inputs + 2);
  const StudyFolder folder(read_once.folder, study, read_once.scene, read_once.request);
  compute_here(options, folder, study);
  fmt::print("{}", write_sobol_table(folder, study, options.rows));
  fmt::print("results in {}\n", (folder.path() / "sobol.csv").string());
  require_results(folder, 1, study.samples, true);
}

// Adds the options of both commands. Returns the option --jobs.
CLI::Option* add_study_options(CLI::App* command, EnsembleOptions* options, const std::string& suffix) {
  command->add_option("study", options->study, "Study file; host/ensemble/README.md lists its keys")
      ->required()
      ->type_name("STUDY.toml");
  command
      ->add_option("--out", options->out,
                   fmt::format("Folder for runs and results (default: out/<name of the study>{})", suffix))
      ->type_name("DIR");
  command->add_flag("--no-pictures", options->no_pictures, "Results without pictures");
  command->add_option("--set", options->overrides, "Set a key of the scene in all runs; may be repeated")
      ->type_name("dotted.key=value")
      ->allow_extra_args(false);
  return command->add_option("--jobs", options->jobs, "Runs side by side, one thread each (default: one a core)")
      ->type_name("J")
      ->check(CLI::Range(1, 4096));
}

}  // namespace

void add_sensitivity_command(CLI::App& app, int&) {
  CLI::App* command =
      app.add_subcommand("sensitivity", "Which property matters: every input of a study tried by itself");
  auto options = std::make_shared<EnsembleOptions>();
  add_study_options(command, options.get(), "_sensitivity");
  command
      ->add_option("--sobol", options->rows,
                   "Sobol's indices in its place, from N rows of as many runs as there are inputs and two more")
      ->type_name("N")
      ->check(CLI::Range(8, 100000));
  command->footer(
      "Each input at its 16 % and 84 % quantile, the others at their means; two runs an input and one of the means.\n"
      "With --sobol all inputs scatter, and their shares of the variance are told with their intervals.\n"
      "Examples:\n"
      "  quoin sensitivity host/studies/solid_wall_030.toml --out out/which\n"
      "  quoin sensitivity host/studies/solid_wall_030.toml --out out/shares --sobol 64");
  command->callback([options] { run_sensitivity(*options); });
}

void add_ensemble_command(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand("ensemble", "Many walls with scattered properties: a distribution of results");
  auto options = std::make_shared<EnsembleOptions>();
  CLI::Option* jobs = add_study_options(command, options.get(), "");
  command->add_option("--samples", options->samples, "Number of samples, in place of the study's")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000));
  CLI::Option* slurm =
      command->add_flag("--slurm", options->slurm, "Compute by a job array of Slurm, and wait for it")->excludes(jobs);
  command->add_option("--tasks", options->tasks, "Tasks of the array (default: 32)")
      ->type_name("K")
      ->check(CLI::Range(1, 100000))
      ->needs(slurm);
  command->add_flag("--detach", options->detach, "Do not wait for the job array")->needs(slurm);
  CLI::Option* gather = command->add_flag("--gather", options->gather, "Compute nothing; results of what is finished")
                            ->excludes(slurm, jobs);
  command
      ->add_flag("--worker", options->worker,
                 "Compute what no other process has claimed, and leave the results to others")
      ->excludes(slurm, gather);
  command->footer(
      "Any number of these commands may work on one DIR at once, also on several machines. Finished samples are never\n"
      "computed again: after Ctrl-C or a crash the same command goes on.\n"
      "Examples:\n"
      "  quoin ensemble host/studies/solid_wall_030.toml --out out/scatter\n"
      "  quoin ensemble host/studies/solid_wall_030.toml --out out/scatter --samples 1000     goes on from there\n"
      "  quoin ensemble host/studies/facade_ida.toml        records, each scaled up until the facade collapses\n"
      "  quoin ensemble out/scatter                         the same, with study, scene and laws as they were then\n"
      "  quoin ensemble host/studies/solid_wall_030.toml --out /shared/scatter --slurm --tasks 64\n"
      "  parallel -N0 quoin ensemble host/studies/solid_wall_030.toml --out out/scatter --jobs 1 --worker ::: 1 2 3 4");
  command->callback([options] { run_ensemble(*options); });
}

}  // namespace quoin
