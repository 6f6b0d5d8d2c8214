// Studies of the paper: their runs, and the evaluation of the results. study_list.cpp lists them all.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reproduce/curve.h"

namespace quoin::reproduce {

// Effort of the studies: a quality of scenes (scene/quality.h), and the settings that follow from it.
struct Quality {
  std::string name;
  double velocity;         // velocity of the top of a wall, m/s
  std::string error;       // expected, against converged runs
  bool slow_runs = false;  // whether the run at 0.1 mm/s is included
  std::string setting() const { return "solver.quality=" + name; }
};
const std::vector<Quality>& qualities();

// A simulation: a shipped scene with overrides, as for `quoin run`.
struct RunSpec {
  std::string name;   // name of the run within its study
  std::string scene;  // without .toml
  std::vector<std::string> overrides;
  std::string law;        // law of all joints in place of the scene's; empty: none
  double cost = 1.0;      // approximate, in solid walls of standard quality: long runs start first
  bool may_fail = false;  // whether a numerical failure is a result too
};

struct RunResult {
  RunSpec spec;
  std::filesystem::path folder;
  bool complete = false;
  std::string message;  // reason why it is not complete
  Curve curve;
  std::optional<Cycles> cycles;  // cycles of its first stage with any
  double wall_clock = 0.0, time_step = 0.0, critical_time_step = 0.0, bed_area = 0.0;  // s, s, s, m2
  long blocks = 0, beams = 0, zones = 0, points = 0, steps = 0;
};

// Source of a reference value.
enum class Kind { printed, derived, seen, recalled };
const char* kind_tag(Kind kind);   // "[P]"
const char* kind_word(Kind kind);  // "printed in the paper"

struct Verdict {
  std::string claim;
  double number = 0.0;
  std::optional<double> reference;
  std::string unit;
  Kind kind = Kind::printed;
  bool reproduced = false;
  std::string text;  // the numbers in words, for readers
};

struct Picture {
  std::filesystem::path file;  // relative to the folder of all results
  std::string caption;
};

struct Table {
  std::string caption;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

struct StudyReport {
  std::vector<Verdict> verdicts;
  std::vector<Picture> pictures;
  std::vector<Table> tables;
  std::vector<std::string> agrees, differs, notes;
  std::vector<std::string> seen;     // observations in pictures and curves of standard quality, not computed
  std::vector<std::string> notices;  // pictures that could not be drawn, failed runs
};

// Results of the runs of a study.
class Findings {
 public:
  Findings(std::filesystem::path root, std::string study, Quality quality, std::map<std::string, RunResult> runs)
      : root_(std::move(root)), study_(std::move(study)), quality_(std::move(quality)), runs_(std::move(runs)) {}

  const Quality& quality() const { return quality_; }
  const RunResult& run(const std::string& name) const;  // throws Error(numerical) when the run is not complete
  bool has(const std::string& name) const;              // whether the run is complete
  // Complete or not. Throws Error(numerical) for a run that the study does not have, or without results.
  const RunResult& outcome(const std::string& name) const;
  std::filesystem::path folder() const { return root_ / study_; }
  std::filesystem::path relative(const std::filesystem::path& file) const { return file.lexically_relative(root_); }
  // Adds the run's picture of cracks and deformed shape.
  void add_cracks(StudyReport& report, const std::string& run, const std::string& caption) const;

 private:
  std::filesystem::path root_;
  std::string study_;
  Quality quality_;
  std::map<std::string, RunResult> runs_;
};

struct Study {
  std::string id, title, figures, claim;
  std::vector<RunSpec> (*runs)(const Quality&);
  StudyReport (*report)(const Findings&);
  bool beyond = false;  // whether it is beyond the paper: run only if requested, with a verdict file of its own
};
const std::vector<Study>& studies();
const Study* find_study(const std::string& id);

// Studies by theme, for study_list.cpp.
StudyReport report_law(const Findings&);
std::vector<RunSpec> no_runs(const Quality&);
std::vector<RunSpec> wall_runs(const Quality&);
StudyReport report_walls(const Findings&);
std::vector<RunSpec> rate_runs(const Quality&);
StudyReport report_rate(const Findings&);
std::vector<RunSpec> brittle_runs(const Quality&);
StudyReport report_brittle(const Findings&);
StudyReport report_envelope(const Findings&);
std::vector<RunSpec> hollow_runs(const Quality&);
StudyReport report_hollow(const Findings&);
std::vector<RunSpec> contact_point_runs(const Quality&);
StudyReport report_contact_points(const Findings&);
std::vector<RunSpec> stiffness_runs(const Quality&);
StudyReport report_stiffness(const Findings&);
std::vector<RunSpec> block_size_runs(const Quality&);
StudyReport report_block_size(const Findings&);
std::vector<RunSpec> energy_runs(const Quality&);
StudyReport report_energy(const Findings&);
std::vector<RunSpec> building_runs(const Quality&);
StudyReport report_building(const Findings&);
std::vector<RunSpec> blind_runs(const Quality&);
StudyReport report_blind(const Findings&);
std::vector<RunSpec> cyclic_runs(const Quality&);
StudyReport report_cyclic(const Findings&);
std::vector<RunSpec> cyclic_wall_runs(const Quality&);
StudyReport report_cyclic_wall(const Findings&);
std::vector<RunSpec> cyclic_pier_runs(const Quality&);
StudyReport report_cyclic_piers(const Findings&);
std::vector<RunSpec> cyclic_building_runs(const Quality&);
StudyReport report_cyclic_building(const Findings&);
std::vector<RunSpec> restrained_runs(const Quality&);
StudyReport report_restrained(const Findings&);

// Whether all verdicts agree with the paper, or with the test.
bool all_reproduced(const StudyReport& report);

// A run of a single wall at the given quality.
RunSpec shear_run(const Quality& quality, const std::string& name, const std::string& scene,
                  std::vector<std::string> overrides = {}, double cost = 1.0);

// A run as the paper's equations read: eq. 1 with gamma = 0.8 at every gridpoint, and true inertia. The top beam has
// its velocity (m/s) without a ramp, up to `displacement` (m). fraction: time step over 2/omega_max. Eq. 1 acts as up
// to gamma times additional stiffness, so that a step above 1/sqrt(1 + gamma) = 0.745 does not converge. The pressure
// stage then lasts 30 ms in place of equilibrium, and the run may fail.
RunSpec printed_run(const std::string& name, const std::string& scene, double velocity, double displacement,
                    double fraction, std::vector<std::string> overrides = {}, double cost = 1.0);
// Outcome of a run: its peak, or the step of its failure.
std::string outcome_text(const RunResult& run);
// Displacement at which the force has fallen to 90 % of the peak: "2.046 mm", or "none".
std::string drop_text(const Curve& curve);
// Largest distance of two curves between two displacements in mm, % of the peak of the second.
double curve_distance(const Curve& a, const Curve& b, double from, double to);

}  // namespace quoin::reproduce
