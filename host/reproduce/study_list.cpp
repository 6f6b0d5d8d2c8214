#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "reproduce/study.h"
#include "scene/quality.h"

namespace quoin::reproduce {

const std::vector<Quality>& qualities() {
  static const std::vector<Quality> all = [] {
    std::vector<Quality> list;
    for (const quoin::Quality& q : quoin::qualities())
      list.push_back({q.name, q.velocity, fmt::format("{:g} % on peaks", 100 * q.peak_error), q.name == "reference"});
    return list;
  }();
  return all;
}

const std::vector<Study>& studies() {
  static const std::vector<Study> all{
      {"law", "The law of a joint", "Figure 3",
       "Tension, shear and compression soften linearly; the areas under the curves are the fracture energies; shear "
       "keeps its friction.",
       no_runs, report_law},
      {"walls", "Solid walls at three pressures", "Figures 5 and 6",
       "The model predicts strength and behaviour of the solid walls within an acceptable accuracy. At low pressure "
       "the "
       "first cracks are bending cracks at top and bottom, then a full diagonal stair-step crack; at higher pressure "
       "units crack too, and the strength grows.",
       wall_runs, report_walls},
      {"rate", "Loading rate", "Figure 7",
       "At 1.21 MPa, 10 mm/s oscillates, 1 and 0.1 mm/s agree; the ratio of unbalanced to total force is smoother for "
       "slower loading.",
       rate_runs, report_rate},
      {"brittle", "Brittle and softening joints", "Figure 8",
       "The brittle law, standard in 3DEC, underestimates the capacity and gives an irregular response.", brittle_runs,
       report_brittle},
      {"envelope", "Shear strength against normal stress", "Figures 9 and 10, equation 6",
       "With the normal stress at the peak the tests give a wall cohesion of 0.25 MPa and a friction of 0.36 (with the "
       "initial one 0.45 MPa and 0.24); Mann and Mueller's line 0.22 MPa and 0.52.",
       wall_runs, report_envelope},
      {"hollow", "Wall with an opening", "Figures 11 and 12",
       "Stair-step cracks run from the corners of the opening to the edges of the wall; the force-displacement curve "
       "is "
       "in line with the tests.",
       hollow_runs, report_hollow},
      {"contact_points", "Number of contact points", "Figure 13",
       "Moderate and fine discretisation agree; too few contact points overestimate the capacity.", contact_point_runs,
       report_contact_points},
      {"stiffness", "Stiffness of the joint inside a unit", "Figure 14",
       "Curves become identical when the joint inside a unit is more than four times as stiff as the mortar joint.",
       stiffness_runs, report_stiffness},
      {"block_size", "Size of the blocks", "Figure 15",
       "A 2 m wall of 60 to 576 blocks: the capacity varies by less than 6 % and falls with the number of blocks, with "
       "the same failure; 16 and 140 minutes on one 2.1 GHz core.",
       block_size_runs, report_block_size},
      {"energy", "Fracture energies", "Figure 16",
       "Higher fracture energies of the joints make the wall more ductile; its capacity changes by less than 10 %.",
       energy_runs, report_energy},
      {"building", "The Pavia building", "Figures 17 to 20, Tables 2 and 3",
       "The capacity of the door wall is met, that of the window wall with its transverse walls overestimated by about "
       "15 %; diagonal cracks in spandrels and piers.",
       building_runs, report_building},
      {"blind", "Two piers predicted blindly", "not in the paper: Ispra piers ISP1 and ISP3",
       "Nothing: these tests are not in the paper. The scenes were written from the reference data, run, and reported "
       "as "
       "they fell.",
       blind_runs, report_blind},
      {"cyclic", "Cyclic loading", "not in the paper: named there as future work",
       "Future studies should implement contact models for the cyclic response of walls.", cyclic_runs, report_cyclic},
      {"cyclic_wall", "Solid wall in cycles, two laws", "beyond the paper",
       "Loops, dissipated energy, equivalent damping, stiffness and residual drift of the wall at 1.21 MPa.",
       cyclic_wall_runs, report_cyclic_wall, true},
      {"cyclic_piers", "Ispra piers in cycles, two laws", "beyond the paper",
       "ISP1 sheared at 81.4 and 84.2 kN, ISP3 rocked at 71.9 and 72.2 kN, both in cycles.", cyclic_pier_runs,
       report_cyclic_piers, true},
      {"cyclic_building", "The Pavia building in cycles, two laws", "beyond the paper",
       "Wall D in cycles of growing drift to 0.43 %, with a base shear of about 150 kN to both sides.",
       cyclic_building_runs, report_cyclic_building, true},
      {"restrained_dilation", "A pier that is held apart", "beyond the paper",
       "Restrained dilation raises the apparent cohesion; uplift comes down again when slip comes back.",
       restrained_runs, report_restrained, true},
  };
  return all;
}

const Study* find_study(const std::string& id) {
  const auto found = std::find_if(studies().begin(), studies().end(), [&](const Study& s) { return s.id == id; });
  return found == studies().end() ? nullptr : &*found;
}

const char* kind_tag(Kind kind) {
  static constexpr const char* tags[] = {"[P]", "[D]", "[S]", "[R]"};
  return tags[static_cast<std::size_t>(kind)];
}

bool all_reproduced(const StudyReport& report) {
  return std::all_of(report.verdicts.begin(), report.verdicts.end(), [](const Verdict& v) { return v.reproduced; });
}

const char* kind_word(Kind kind) {
  static constexpr const char* words[] = {"printed", "derived", "seen", "recalled"};
  return words[static_cast<std::size_t>(kind)];
}

const RunResult& Findings::outcome(const std::string& name) const {
  const auto found = runs_.find(name);
  if (found == runs_.end()) throw Error(Exit::numerical, fmt::format("the study {} has no run {}", study_, name));
  if (found->second.steps == 0)
    throw Error(Exit::numerical, fmt::format("the run '{}' was not made: {}; see {}", name, found->second.message,
                                             (found->second.folder / "log.txt").string()));
  return found->second;
}

const RunResult& Findings::run(const std::string& name) const {
  const RunResult& result = outcome(name);
  if (!result.complete)
    throw Error(Exit::numerical, fmt::format("the run '{}' is not complete: {}; see {}", name, result.message,
                                             (result.folder / "log.txt").string()));
  return result;
}

bool Findings::has(const std::string& name) const {
  const auto found = runs_.find(name);
  return found != runs_.end() && found->second.complete;
}

void Findings::add_cracks(StudyReport& report, const std::string& name, const std::string& caption) const {
  report.pictures.push_back({relative(run(name).folder / "cracks.png"), caption});
}

std::vector<RunSpec> no_runs(const Quality&) { return {}; }

RunSpec shear_run(const Quality& quality, const std::string& name, const std::string& scene,
                  std::vector<std::string> overrides, double cost) {
  RunSpec spec{name, scene, std::move(overrides), "", cost};
  spec.overrides.push_back(quality.setting());
  return spec;
}

RunSpec printed_run(const std::string& name, const std::string& scene, double velocity, double displacement,
                    double fraction, std::vector<std::string> overrides, double cost) {
  constexpr double kGamma = 0.8;
  RunSpec spec{name, scene, std::move(overrides), "", cost};
  for (const std::string& o :
       {std::string("solver.damping=local"), fmt::format("solver.local_damping={}", kGamma),
        fmt::format("solver.time_step_fraction={}", fraction), fmt::format("stage.shear.velocity={}", velocity),
        fmt::format("stage.shear.displacement={}", displacement), std::string("stage.shear.ramp_time=0")})
    spec.overrides.push_back(o);
  if (fraction > 1.0 / std::sqrt(1.0 + kGamma)) {
    spec.overrides.insert(spec.overrides.end(), {"stage.precompression.duration=0.03", "output.plots=false"});
    spec.may_fail = true;
  }
  return spec;
}

std::string outcome_text(const RunResult& run) {
  if (run.complete) return fmt::format("peak {:.1f} kN at {:.2f} mm", run.curve.peak(), run.curve.peak_displacement());
  return fmt::format("numerical failure at step {}", run.steps);
}

std::string drop_text(const Curve& curve) {
  const double at = curve.displacement_after_peak(0.9);
  return at < 0 ? "none" : fmt::format("{:.3f} mm", at);
}

double curve_distance(const Curve& a, const Curve& b, double from, double to) {
  double worst = 0.0;
  for (double d = from; d <= to; d += 0.01) worst = std::max(worst, std::abs(a.force_at(d) - b.force_at(d)));
  return 100.0 * worst / b.peak();
}

}  // namespace quoin::reproduce
