// The walls of the benchmark: pressures, loading rate, brittle joints, envelope, opening.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "files/file.h"
#include "reproduce/chart.h"

namespace quoin::reproduce {

namespace {

struct WallReference {
  const char *name, *scene, *tests;
  double pressure;           // MPa
  double peak;               // kN, from the paper's regression times 0.099 m2 [D]
  double stress_at_peak;     // MPa [D]
  double raw_low, raw_high;  // kN, raw tests [R]
};
constexpr std::array<WallReference, 3> kWalls{{{"0.30 MPa", "solid_wall_030", "J4D, J5D", 0.30, 51.7, 0.76, 50.0, 52.0},
                                               {"1.21 MPa", "solid_wall_121", "J6D", 1.21, 73.3, 1.36, 71.5, 72.5},
                                               {"2.12 MPa", "solid_wall_212", "J7D", 2.12, 94.9, 1.97, 96.5, 97.5}}};
constexpr double kArea = 0.099;  // m2
// Larger differences require an explanation.
constexpr double kPeakTolerance = 0.15;

double percent(double number, double reference) { return 100.0 * (number / reference - 1.0); }

struct Line {
  double cut, slope, r2;
};
Line least_squares(const std::vector<double>& x, const std::vector<double>& y) {
  const double n = static_cast<double>(x.size());
  double sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i], syy += y[i] * y[i];
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  const double r = (n * sxy - sx * sy) / std::sqrt((n * sxx - sx * sx) * (n * syy - sy * sy));
  return {(sy - slope * sx) / n, slope, r * r};
}

}  // namespace

std::vector<RunSpec> wall_runs(const Quality& q) {
  std::vector<RunSpec> runs;
  for (const WallReference& w : kWalls) runs.push_back(shear_run(q, w.name, w.scene));
  return runs;
}

StudyReport report_walls(const Findings& findings) {
  StudyReport report;
  Chart chart{"curves", "Solid walls: horizontal force", "displacement of the top beam (mm)", "horizontal force (kN)"};
  Table table{"Peaks",
              {"pressure", "tests", "peak", "at", "mean vertical stress at the peak", "tests [D]", "difference",
               "raw tests [R]"},
              {}};
  std::vector<std::pair<std::string, const Curve*>> curves;
  std::vector<double> differences;  // differences of peaks, %
  int colour = 0;
  for (const WallReference& w : kWalls) {
    const RunResult& run = findings.run(w.name);
    const Curve& c = run.curve;
    curves.emplace_back(w.name, &c);
    chart.add(std::string("model, ") + w.name, c, colour);
    chart.add_level(fmt::format("{} peak {:.1f} kN", w.tests, w.peak), Kind::derived, w.peak, colour);
    chart.add_band(fmt::format("{} raw", w.tests), Kind::recalled, w.raw_low, w.raw_high, colour);
    const double off = percent(c.peak(), w.peak);
    differences.push_back(off);
    const double stress = c.vertical[c.peak_row()] / run.bed_area / 1e3;
    table.rows.push_back(
        {w.name, w.tests, fmt::format("{:.1f} kN", c.peak()), fmt::format("{:.2f} mm", c.peak_displacement()),
         fmt::format("{:.2f} MPa (tests {:.2f} [D])", stress, w.stress_at_peak), fmt::format("{:.1f} kN", w.peak),
         fmt::format("{:+.0f} %", off), fmt::format("{:.0f} kN", (w.raw_low + w.raw_high) / 2)});
    report.verdicts.push_back({fmt::format("peak of the solid wall at {}, within 15 %", w.name), c.peak(), w.peak, "kN",
                               Kind::derived, std::abs(off) <= 100 * kPeakTolerance,
                               fmt::format("{:.1f} kN at {:.2f} mm, tests {:.1f} kN: {:+.0f} %", c.peak(),
                                           c.peak_displacement(), w.peak, off)});
    ++colour;
  }
  const double first = findings.run(kWalls[0].name).curve.peak(), last = findings.run(kWalls[2].name).curve.peak();
  report.verdicts.push_back({"strength grows with the pressure", last / first, 94.9 / 51.7, "x", Kind::derived,
                             last > 1.2 * first,
                             fmt::format("2.12 over 0.30 MPa: {:.2f}, tests {:.2f}", last / first, 94.9 / 51.7)});
  draw(chart, findings, report,
       "Curves of the three walls. Dotted: peaks of the tests by the paper's regression [D]; bands: raw peaks as "
       "recalled [R].");
  for (const WallReference& w : kWalls)
    findings.add_cracks(report, w.name, fmt::format("Cracks at the end, {} ({}).", w.name, w.tests));
  report.tables.push_back(std::move(table));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  const auto [lowest, highest] = std::minmax_element(differences.begin(), differences.end());
  const std::string range = fmt::format("The peaks differ from the tests by {:+.0f} to {:+.0f} %", *lowest, *highest);
  if (all_reproduced(report))
    report.agrees = {range + ", within 15 %, and grow with the pressure as theirs do."};
  else
    report.differs = {range + ": not all within 15 %, or not in their order."};
  report.seen = {
      "The pictures show bending cracks at top and bottom, a diagonal through head and bed joints, and crushed toes "
      "where the diagonal strut lands. (The order in which they come is not measured.)",
      "At 2.12 MPa the diagonal runs straight through cracked bricks; at 0.30 MPa it steps round them.",
      "All three peaks were above the tests, by 5 to 10 %. An independent trial of the same law "
      "(host/reproduce/REFERENCE_DATA.md) has the same excess (+6, +9, +9 %), so it belongs to the model, not to this "
      "host. Of what was varied, finer blocks lower the peak most (-3 %; see contact_points); slower loading (rate) "
      "and the stiffness of the unit joints (stiffness) less than 1 %."};
  return report;
}

// ---- Loading rate --------------------------------------------------------------------------------------------------

namespace {

struct Rate {
  const char* name;
  double velocity;  // m/s
  double cost;
  bool slow;
};
constexpr std::array<Rate, 8> kRates{{{"0.1 mm/s", 1e-4, 100.0, true},
                                      {"1 mm/s", 1e-3, 10.0, false},
                                      {"10 mm/s", 1e-2, 1.0, false},
                                      {"20 mm/s", 2e-2, 0.5, false},
                                      {"40 mm/s", 4e-2, 0.3, false},
                                      {"80 mm/s", 8e-2, 0.2, false},
                                      {"160 mm/s", 0.16, 0.1, false},
                                      {"320 mm/s", 0.32, 0.1, false}}};
constexpr double kSmooth = 0.02;  // share of the peak; smaller drops on the rising branch are no oscillation
// Shares of the peak between which the diagonal crack opens suddenly.
constexpr double kDropBegins = 0.9, kDropEnds = 0.7;
constexpr double kRising = 1.2;  // mm, well before the peak of the slow curves
// Runs as printed: the top beam has its velocity without a ramp.
constexpr const char *kAtOnce = "10 mm/s, at once", *kAtOnceTwice = "20 mm/s, at once",
                     *kAtOnceLongStep = "10 mm/s, at once, step 0.8", *kNodalStep = "10 mm/s, at once, step of eq. 3";

// Force on a beam that starts with a velocity (m/s) without a ramp, kN: that of a plane shear wave into the wall.
// Bricks and bed joints are in series, Table 1. Eq. 1 leaves 1 - gamma of the force to accelerating motion.
double wave_force(double velocity) {
  const double brick = 16.7e9 / (2 * (1 + 0.15)), joint = 36e9 * 0.0625, rigidity = 1 / (1 / brick + 1 / joint);
  return 1e-3 * kArea * velocity * std::sqrt(1900.0 / (1 - 0.8) * rigidity);
}

}  // namespace

std::vector<RunSpec> rate_runs(const Quality& q) {
  std::vector<RunSpec> runs;
  for (const Rate& r : kRates) {
    if (r.slow && !q.slow_runs) continue;
    if (q.name == "fast" && r.velocity < 5e-3) continue;
    // Settings of the paper, eq. 1 and true inertia, at all rates. The ramp has the same length in mm, before the first
    // crack.
    runs.push_back(
        {r.name,
         "solid_wall_121",
         {fmt::format("stage.shear.velocity={}", r.velocity), "stage.shear.displacement=0.0025", "solver.damping=local",
          fmt::format("stage.shear.ramp_time={:.6g}", std::min(0.05, 1e-4 / r.velocity))},
         "",
         r.cost});
  }
  const char* scene = "solid_wall_121";
  runs.push_back(printed_run(kAtOnce, scene, 0.01, 0.0025, 0.6));
  runs.push_back(printed_run(kAtOnceTwice, scene, 0.02, 0.0025, 0.6, {}, 0.5));
  runs.push_back(printed_run(kAtOnceLongStep, scene, 0.01, 0.0025, 0.8));
  runs.push_back(printed_run(kNodalStep, scene, 0.01, 0.0025, 1.0, {"solver.critical_time_step=nodal"}, 0.1));
  return runs;
}

namespace {

using NamedCurves = std::vector<std::pair<std::string, const Curve*>>;

Table table_of_printed(const Findings& findings, NamedCurves* curves) {
  Table printed{"Eq. 1 exactly as printed (gamma 0.8 at every gridpoint, true inertia, velocity there at once)",
                {"run", "time step over 2/omega_max", "what came of it", "largest fall (to 1.2 mm)"},
                {}};
  for (const char* name : {kAtOnce, kAtOnceTwice, kAtOnceLongStep, kNodalStep}) {
    const RunResult& run = findings.outcome(name);
    printed.rows.push_back({name, fmt::format("{:.2f}", run.time_step / run.critical_time_step), outcome_text(run),
                            run.complete ? fmt::format("{:.2f} %", 100 * run.curve.largest_fall(kRising)) : ""});
    if (run.complete) curves->emplace_back(name, &run.curve);
  }
  return printed;
}

Verdict verdict_of_agreement(const Findings& findings, const char* slow, const char* fast) {
  const Curve &a = findings.run(slow).curve, &b = findings.run(fast).curve;
  const double worst = curve_distance(b, a, 0.1, 2.45);
  std::string text = fmt::format("peaks {:.1f} and {:.1f} kN; largest distance of the curves {:.1f} % of the peak",
                                 b.peak(), a.peak(), worst);
  const double drop_a = a.displacement_after_peak(kDropBegins), drop_b = b.displacement_after_peak(kDropBegins);
  const double end_a = a.displacement_after_peak(kDropEnds), end_b = b.displacement_after_peak(kDropEnds);
  if (drop_a > 0 && drop_b > 0 && end_a > 0 && end_b > 0) {
    const double before = std::min(drop_a, drop_b) - 0.1, after = std::max(end_a, end_b) + 0.1;
    text += fmt::format(
        "; up to {:.2f} mm {:.1f} %, from {:.2f} mm on {:.1f} %; between them the drop, which begins at "
        "{:.3f} and {:.3f} mm",
        before, curve_distance(b, a, 0.1, before), after, curve_distance(b, a, after, 2.45), drop_b, drop_a);
  }
  return {fmt::format("{} and {} agree", fast, slow), worst, 0.0, "% of the peak", Kind::printed, worst < 5.0, text};
}

Verdict verdict_of_unbalanced(const Findings& findings) {
  bool falls = true;
  double before = 0.0;
  for (const Rate& r : kRates) {
    if (!findings.has(r.name)) continue;
    const double now = findings.run(r.name).curve.mean_unbalanced(0.1, 2.45);
    falls = falls && now > before;
    before = now;
  }
  const char* slowest = findings.has("1 mm/s") ? "1 mm/s" : "10 mm/s";
  const double factor =
      findings.run("80 mm/s").curve.mean_unbalanced(0.1, 2.45) / findings.run(slowest).curve.mean_unbalanced(0.1, 2.45);
  return {"unbalanced ratio is lower for slower loading",
          factor,
          std::nullopt,
          "x",
          Kind::printed,
          falls,
          fmt::format("80 mm/s over {}: {:.1f} times; {}", slowest, factor,
                      falls ? "falls with every step down" : "does not fall with every step down")};
}

// Effect of the paper's loading: a velocity without a ramp.
std::string text_of_start(const Curve& at_once, const Curve& ramped) {
  return fmt::format(
      "10 mm/s does oscillate when the velocity is there at once, as the paper prescribes it, but less than the {:g} "
      "% "
      "asked for: the force jumps to {:.1f} kN and then rises in stairs, whose distance from the ramped curve is at "
      "most {:.1f} % of the peak from 0.05 to {:g} mm. The jump is the wave that the beam sends down, A v sqrt(5 rho "
      "G): {:.1f} kN, where 5 = 1/(1 - gamma) is the inertia that eq. 1 adds to what speeds up, and the stairs are "
      "its "
      "echoes. Both are in proportion to the velocity.",
      100 * kSmooth, at_once.force_at(0.003), curve_distance(at_once, ramped, 0.05, kRising), kRising,
      wave_force(0.01));
}

std::string text_of_long_steps(const Findings& findings, const Curve& at_once) {
  const RunResult &long_step = findings.outcome(kAtOnceLongStep), &nodal = findings.outcome(kNodalStep);
  return fmt::format(
      "Eq. 3 read literally, 2 sqrt(m/k) with the diagonal stiffness of a gridpoint, gives {:.2f} of 2/omega_max. Run "
      "at "
      "it: {}. Eq. 1 itself lowers the limit: F against v all the time acts like 1 + gamma times the stiffness, so "
      "that "
      "gamma = 0.8 leaves 1/sqrt(1.8) = 0.745 of 2/omega_max. At 0.8 the pressure finds no equilibrium; sheared all "
      "the "
      "same: {}, against {:.1f} kN at 0.6. So the paper cannot have run at either; its k must be larger than the "
      "diagonal.",
      nodal.time_step / nodal.critical_time_step, outcome_text(nodal), outcome_text(long_step), at_once.peak());
}

}  // namespace

StudyReport report_rate(const Findings& findings) {
  StudyReport report;
  Chart chart{"curves", "Loading rate, 1.21 MPa, no mass scaling", "displacement of the top beam (mm)",
              "horizontal force (kN)"};
  Chart ratio{"unbalanced", "Largest unbalanced force over the mean contact force", "displacement of the top beam (mm)",
              "ratio"};
  ratio.extra = "set logscale y\nset format y \"10^{%T}\"\n";
  ratio.from_zero = false;
  Table table{"Rates",
              {"rate", "peak", "largest fall on the rising branch (to 1.2 mm)", "roughness (0.1 to 2.5 mm)",
               "drop to 90 % of the peak at", "mean unbalanced ratio", "steps"},
              {}};
  NamedCurves curves;
  std::string begins = "none of those tried";
  int colour = 0;
  for (const Rate& r : kRates) {
    if (!findings.has(r.name)) continue;
    const RunResult& run = findings.run(r.name);
    const Curve& c = run.curve;
    curves.emplace_back(r.name, &c);
    chart.add(r.name, c, colour);
    ratio.series.push_back({r.name, Mark::line, c.displacement, c.unbalanced, colour});
    ++colour;
    const double rough = c.roughness(0.05, 0.1, 2.45), fall = c.largest_fall(kRising);
    if (fall > kSmooth && begins.starts_with("none")) begins = r.name;
    table.rows.push_back({r.name, fmt::format("{:.1f} kN", c.peak()), fmt::format("{:.2f} %", 100 * fall),
                          fmt::format("{:.2f} %", 100 * rough), drop_text(c),
                          fmt::format("{:.2g}", c.mean_unbalanced(0.1, 2.45)), std::to_string(run.steps)});
  }
  Table printed = table_of_printed(findings, &curves);
  const Curve &ramped = findings.run("10 mm/s").curve, &at_once = findings.run(kAtOnce).curve,
              &twice = findings.run(kAtOnceTwice).curve;
  const double fall_10 = at_once.largest_fall(kRising), fall_20 = twice.largest_fall(kRising);
  report.verdicts.push_back(
      {"10 mm/s oscillates", 100 * fall_10, std::nullopt, "% of the peak", Kind::printed, fall_10 > kSmooth,
       fmt::format("as printed, the velocity there at once: largest fall of the force on the rising branch {:.2f} % of "
                   "the peak, at 20 mm/s {:.2f} %; with a ramp {:.2f} %, and oscillation (above {:g} %) begins at {}",
                   100 * fall_10, 100 * fall_20, 100 * ramped.largest_fall(kRising), 100 * kSmooth, begins)});
  if (findings.has("1 mm/s") && findings.has("0.1 mm/s"))
    report.verdicts.push_back(verdict_of_agreement(findings, "0.1 mm/s", "1 mm/s"));
  if (findings.has("1 mm/s")) report.verdicts.push_back(verdict_of_agreement(findings, "1 mm/s", "10 mm/s"));
  report.verdicts.push_back(verdict_of_unbalanced(findings));
  const bool falls = report.verdicts.back().reproduced;
  draw(chart, findings, report, "Curves at all rates, to 2.5 mm as in Figure 7.");
  Chart start{"start", "10 mm/s at once and by a ramp", "displacement of the top beam (mm)", "horizontal force (kN)"};
  start.extra = "set xrange [0:0.6]\nset yrange [0:60]\n";
  start.add("10 mm/s, at once", at_once, 0);
  start.add("10 mm/s, ramp", ramped, 1, Mark::dashed);
  draw(start, findings, report,
       "The first 0.6 mm: eq. 1 as printed rises in stairs when the velocity is there at once.");
  draw(ratio, findings, report,
       "Unbalanced ratio. The paper divides by the total horizontal force; ours by the mean force of a contact point.");
  report.tables.push_back(std::move(table));
  report.tables.push_back(std::move(printed));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  if (falls) report.agrees = {"Slower loading lowers the unbalanced force."};
  if (fall_10 <= kSmooth) report.differs.push_back(text_of_start(at_once, ramped));
  if (findings.has("1 mm/s"))
    report.seen = {
        "10 and 1 mm/s differ where the diagonal gives way, and nowhere else. Cause tested: a drop needs a time, not a "
        "displacement. It begins some 4 ms later at every rate (table), and the faster beam moves further meanwhile. "
        "Two curves that fall by 25 kN at places 0.04 mm apart are far from each other in between. The start at once, "
        "the ramp and the time step move it by 0.002 mm at most. The paper compares 1 and 0.1 mm/s."};
  report.notes.push_back(text_of_long_steps(findings, at_once));
  if (!findings.has("0.1 mm/s"))
    report.notes.push_back(
        "0.1 mm/s is run only at quality reference (about half an hour on one core): quoin reproduce rate --quality "
        "reference, or --slow.");
  return report;
}

// ---- Brittle joints ------------------------------------------------------------------------------------------------

constexpr double kBrittle = 0.02;  // m/s, highest velocity of brittle walls

namespace {
// As printed, at the lowest pressure: with the paper's velocity, and with a longer time step.
constexpr const char *kSlowSoft = "softening, 0.30 MPa, as printed", *kSlowBrittle = "brittle, 0.30 MPa, as printed",
                     *kLongStepSoft = "softening, 0.30 MPa, as printed, step 0.8",
                     *kLongStepBrittle = "brittle, 0.30 MPa, as printed, step 0.8";
}  // namespace

std::vector<RunSpec> brittle_runs(const Quality& q) {
  std::vector<RunSpec> runs = wall_runs(q);
  for (const WallReference& w : kWalls) {
    // A brittle joint loses its bond suddenly, and vibration adds to the force of faster walls. At 2.12 MPa the peak is
    // 121 kN at 80 mm/s, 97 kN at 20 mm/s.
    RunSpec spec = shear_run(q, std::string("brittle, ") + w.name, w.scene, {}, 2.0);
    if (q.velocity > kBrittle) spec.overrides.push_back(fmt::format("stage.shear.velocity={}", kBrittle));
    spec.law = "coulomb_slip";
    runs.push_back(spec);
  }
  // Shows why the brittle wall may be stronger: the softening law without crushing, which the brittle law does not
  // have.
  for (const WallReference& w : kWalls)
    runs.push_back(shear_run(q, std::string("no crushing, ") + w.name, w.scene,
                             {"joints.mortar.compressive_strength=inf", "joints.unit.compressive_strength=inf"}));
  const char* scene = kWalls[0].scene;
  if (q.name != "fast") {
    runs.push_back(printed_run(kSlowSoft, scene, 0.001, 0.0025, 0.6, {}, 10.0));
    runs.push_back(printed_run(kSlowBrittle, scene, 0.001, 0.0025, 0.6, {}, 10.0));
    runs.back().law = "coulomb_slip";
  }
  runs.push_back(printed_run(kLongStepSoft, scene, 0.01, 0.0025, 0.8));
  runs.push_back(printed_run(kLongStepBrittle, scene, 0.01, 0.0025, 0.8));
  runs.back().law = "coulomb_slip";
  return runs;
}

namespace {

double roughness(const Curve& of, const Curve& other) {
  return of.roughness(0.05, 0.1, std::min(of.displacement.back(), other.displacement.back()) - 0.05);
}

// Draws curves at the paper's velocity, at which inertia is negligible.
void draw_slow(const Findings& findings, const Curve& slow_soft, const Curve& slow_brittle, const Curve& brittle,
               StudyReport* report) {
  Chart slow{"slow", "Brittle and softening joints, 0.30 MPa, 1 mm/s by eq. 1 as printed",
             "displacement of the top beam (mm)", "horizontal force (kN)"};
  slow.add("law fracture_energy", slow_soft, 0);
  slow.add("law coulomb_slip (brittle)", slow_brittle, 1);
  slow.add(fmt::format("brittle, {:g} mm/s", 1e3 * std::min(kBrittle, findings.quality().velocity)), brittle, 1,
           Mark::dashed);
  slow.extra = "set xrange [0:2.5]\n";
  draw(slow, findings, *report, "At the paper's velocity: what inertia hides at a faster one.");
}

void draw_pair(const Findings& findings, const WallReference& w, const Curve& soft, const Curve& brittle,
               const Curve& strong, StudyReport* report) {
  Chart chart{fmt::format("curves_{}", std::string(w.scene).substr(11)),
              fmt::format("Brittle and softening joints, {}", w.name), "displacement of the top beam (mm)",
              "horizontal force (kN)"};
  chart.add("law fracture_energy", soft, 0);
  chart.add("law coulomb_slip (brittle)", brittle, 1);
  chart.add("law fracture_energy, crushing switched off", strong, 2, Mark::dashed);
  chart.add_level(fmt::format("{} peak {:.1f} kN", w.tests, w.peak), Kind::derived, w.peak, 6);
  draw(chart, findings, *report, fmt::format("{}: the same scene, the library of the joints swapped.", w.name));
}

// Reasons why walls with brittle joints are not weaker at high pressure; empty: they are weaker.
std::vector<std::string> text_of_high_pressure(const Findings& findings) {
  const Curve &brittle_high = findings.run("brittle, 2.12 MPa").curve, &soft_high = findings.run("2.12 MPa").curve,
              &strong_high = findings.run("no crushing, 2.12 MPa").curve;
  if (brittle_high.peak() < 0.97 * soft_high.peak()) return {};
  return {fmt::format(
      "At 2.12 MPa the brittle wall is not the weaker one ({:.1f} against {:.1f} kN). Cause tested: the "
      "standard brittle law has no limit in compression, "
      "the softening one crushes. With crushing switched off the softening wall reaches {:.1f} kN: {}.",
      brittle_high.peak(), soft_high.peak(), strong_high.peak(),
      strong_high.peak() > brittle_high.peak() ? "then brittle is lower at this pressure too, and crushing is the cause"
                                               : "crushing alone does not explain it")};
}

}  // namespace

StudyReport report_brittle(const Findings& findings) {
  StudyReport report;
  Table table{"Brittle against softening",
              {"pressure", "softening", "brittle", "ratio", "softening without crushing", "roughness softening",
               "roughness brittle"},
              {}};
  NamedCurves curves;
  for (const WallReference& w : kWalls) {
    const std::string brittle_name = std::string("brittle, ") + w.name,
                      strong_name = std::string("no crushing, ") + w.name;
    const Curve& strong = findings.run(strong_name).curve;
    const Curve &soft = findings.run(w.name).curve, &brittle = findings.run(brittle_name).curve;
    curves.emplace_back(w.name, &soft);
    curves.emplace_back(brittle_name, &brittle);
    draw_pair(findings, w, soft, brittle, strong, &report);
    double r_soft = roughness(soft, brittle), r_brittle = roughness(brittle, soft);
    const double part = brittle.peak() / soft.peak();
    table.rows.push_back({w.name, fmt::format("{:.1f} kN", soft.peak()), fmt::format("{:.1f} kN", brittle.peak()),
                          fmt::format("{:.2f}", part), fmt::format("{:.2f} %", 100 * r_soft),
                          fmt::format("{:.2f} %", 100 * r_brittle)});
    report.verdicts.push_back({fmt::format("brittle is lower at {}", w.name), part, 1.0, "x", Kind::printed,
                               part < 0.97,
                               fmt::format("{:.1f} against {:.1f} kN: {:.2f}", brittle.peak(), soft.peak(), part)});
    std::string conditions;
    if (&w == &kWalls[0] && findings.has(kSlowBrittle) && findings.has(kSlowSoft)) {
      const Curve &slow_soft = findings.run(kSlowSoft).curve, &slow_brittle = findings.run(kSlowBrittle).curve;
      curves.emplace_back(kSlowSoft, &slow_soft);
      curves.emplace_back(kSlowBrittle, &slow_brittle);
      conditions = fmt::format(
          " at 1 mm/s by eq. 1 as printed (in the runs of this quality, at {:g} mm/s, {:.2f} "
          "against {:.2f} %, where inertia hides it)",
          1e3 * std::min(kBrittle, findings.quality().velocity), 100 * r_brittle, 100 * r_soft);
      r_soft = roughness(slow_soft, slow_brittle), r_brittle = roughness(slow_brittle, slow_soft);
      draw_slow(findings, slow_soft, slow_brittle, brittle, &report);
    }
    report.verdicts.push_back(
        {fmt::format("brittle is irregular at {}", w.name), r_brittle / r_soft, std::nullopt, "x", Kind::printed,
         r_brittle > 1.5 * r_soft,
         fmt::format("roughness {:.2f} against {:.2f} % of the peak{}", 100 * r_brittle, 100 * r_soft, conditions)});
  }
  for (const WallReference& w : kWalls)
    findings.add_cracks(report, std::string("brittle, ") + w.name,
                        fmt::format("Brittle joints at the end, {}.", w.name));
  report.tables.push_back(std::move(table));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  report.differs = text_of_high_pressure(findings);
  report.seen = {
      "The paper names Figure 8b, 1.21 MPa, for the irregular response. At 0.30 MPa a joint that lets go starts a wall "
      "that rocks; at 20 mm/s its inertia carries it over, the force stays level, and only at the paper's velocity "
      "does it fall at every joint."};
  report.notes = {
      "The brittle law is the standard one of 3DEC: at the first failure tension and cohesion drop to nothing; "
      "compression stays elastic.",
      "Brittle walls are never loaded faster than 20 mm/s, at quality fast neither: joints that let go at once make a "
      "fast wall ring (2.12 MPa: 121 kN at 80 mm/s, 97 kN at 20 mm/s).",
      fmt::format(
          "Eq. 1 as printed with a step of 0.8 of 2/omega_max, which is above its own limit of 0.745 (see rate), "
          "at 0.30 MPa and 10 mm/s: softening {}, brittle {}.",
          outcome_text(findings.outcome(kLongStepSoft)), outcome_text(findings.outcome(kLongStepBrittle)))};
  return report;
}

// ---- Envelope ------------------------------------------------------------------------------------------------------

StudyReport report_envelope(const Findings& findings) {
  StudyReport report;
  std::vector<double> initial, at_peak, tau, tau_test, at_peak_test;
  for (const WallReference& w : kWalls) {
    const RunResult& run = findings.run(w.name);
    initial.push_back(w.pressure);
    at_peak.push_back(run.curve.vertical[run.curve.peak_row()] / run.bed_area / 1e3);
    tau.push_back(run.curve.peak() / run.bed_area / 1e3);
    tau_test.push_back(w.peak / kArea / 1e3);
    at_peak_test.push_back(w.stress_at_peak);
  }
  const Line of_initial = least_squares(initial, tau), of_peak = least_squares(at_peak, tau);
  // Equation 6 with tan(phi) in the numerator; pattern 2 h/l of the bare brick, 50 x 204 mm.
  const double pattern = 2 * 50.0 / 204.0, c = 0.3, mu = 0.7;
  const Line mann{c / (1 + mu * pattern), mu / (1 + mu * pattern), 1.0};

  const auto line = [](const Line& l, double to) {
    return std::pair<std::vector<double>, std::vector<double>>{{0.0, to}, {l.cut, l.cut + l.slope * to}};
  };
  auto add_line = [&](Chart& chart, const std::string& label, const Line& l, int colour, Mark mark) {
    auto [x, y] = line(l, 2.4);
    chart.series.push_back({label, mark, x, y, colour});
  };
  Chart chart{"envelope", "Peak shear stress against normal stress", "mean vertical stress (MPa)",
              "peak shear stress (MPa)"};
  chart.extra = "set yrange [0:1.6]\n";
  chart.key = "top left";
  chart.add_points("model, initial stress", initial, tau, 0);
  chart.add_points("model, stress at the peak", at_peak, tau, 1);
  chart.add_points(std::string("tests, initial stress ") + kind_tag(Kind::derived), initial, tau_test, 5);
  chart.add_points(std::string("tests, stress at the peak ") + kind_tag(Kind::derived), at_peak_test, tau_test, 7);
  add_line(chart, fmt::format("model: {:.2f} + {:.2f} sigma (initial)", of_initial.cut, of_initial.slope), of_initial,
           0, Mark::line);
  add_line(chart, fmt::format("model: {:.2f} + {:.2f} sigma (at the peak)", of_peak.cut, of_peak.slope), of_peak, 1,
           Mark::line);
  add_line(chart, "tests: 0.45 + 0.24 sigma (initial) [P]", {0.45, 0.24, 1}, 5, Mark::dashed);
  add_line(chart, "tests: 0.25 + 0.36 sigma (at the peak) [P]", {0.25, 0.36, 1}, 7, Mark::dashed);
  add_line(chart, fmt::format("Mann-Mueller: {:.2f} + {:.2f} sigma [P]", mann.cut, mann.slope), mann, 6, Mark::dashed);
  draw(chart, findings, report, "Peaks and regressions, model and tests, with Mann and Mueller's line.");

  auto judge = [&](const std::string& claim, double number, double reference, double tolerance, const char* unit) {
    report.verdicts.push_back(
        {claim, number, reference, unit, Kind::printed, std::abs(number / reference - 1) <= tolerance,
         fmt::format("{:.3f} {}, paper {:.2f}: {:+.0f} %", number, unit, reference, percent(number, reference))});
  };
  judge("cohesion of the wall, initial stress", of_initial.cut, 0.45, 0.15, "MPa");
  judge("friction of the wall, initial stress", of_initial.slope, 0.24, 0.15, "");
  judge("cohesion of the wall, stress at the peak", of_peak.cut, 0.25, 0.15, "MPa");
  judge("friction of the wall, stress at the peak", of_peak.slope, 0.36, 0.15, "");
  judge("Mann-Mueller cohesion", mann.cut, 0.22, 0.03, "MPa");
  judge("Mann-Mueller friction", mann.slope, 0.52, 0.03, "");
  report.verdicts.push_back(
      {"linear regressions fit (R2)", of_peak.r2, 0.99, "", Kind::printed, of_peak.r2 > 0.98,
       fmt::format("R2 {:.3f} at the peak, {:.3f} initial; paper 0.99 both", of_peak.r2, of_initial.r2)});
  std::string csv =
      "initial_stress_MPa,stress_at_peak_MPa,peak_shear_MPa,test_stress_at_peak_MPa_D,test_peak_shear_MPa_D\n";
  for (std::size_t i = 0; i < tau.size(); ++i)
    csv += fmt::format("{},{:.5g},{:.5g},{},{:.5g}\n", initial[i], at_peak[i], tau[i], at_peak_test[i], tau_test[i]);
  write_file(findings.folder() / "envelope.csv", csv);
  if (of_initial.slope < of_peak.slope)
    report.agrees = {
        "The slope against the initial stress is below that against the stress at the peak, as in the tests: holding "
        "the vertical displacement raises the stress most where it began low."};
  report.notes = {
      "Equation 6 needs tan(phi) in the numerator to give the printed 0.52, and the bare brick (50 x 204 mm) in 2 h/l; "
      "with the expanded one it gives 0.21 MPa and 0.50.",
      "The regressions of the paper are those of the tests; ours are of the model's peaks (study walls)."};
  return report;
}

// ---- Opening -------------------------------------------------------------------------------------------------------

namespace {

struct Opening {
  const char* name;
  int first_half_unit, half_units, first_course, courses;
  bool shown;  // in the chart, to 20 mm
  double cost;
};
// The paper prints no size. On the grid of 9 half bricks only openings of odd width can be centred.
constexpr std::array<Opening, 8> kOpenings{{{"2 half bricks", 4, 2, 5, 6, true, 3.5},
                                            {"2 half bricks, the other way", 3, 2, 5, 6, true, 3.5},
                                            {"3 half bricks", 3, 3, 5, 6, true, 3.0},
                                            {"1 half brick", 4, 1, 5, 6, false, 1.0},
                                            {"2 half bricks, 4 courses", 4, 2, 6, 4, false, 1.0},
                                            {"2 half bricks, 8 courses", 4, 2, 4, 8, false, 1.0},
                                            {"3 half bricks, 4 courses", 3, 3, 6, 4, false, 1.0},
                                            {"3 half bricks, 8 courses", 3, 3, 4, 8, false, 1.0}}};
constexpr const char *kFineZones = "2 half bricks, 8 x 4 x 2 hexahedra", *kPrintedHollow = "2 half bricks, as printed",
                     *kPrintedHollowLongStep = "2 half bricks, as printed, step 0.8";

}  // namespace

std::vector<RunSpec> hollow_runs(const Quality& q) {
  std::vector<RunSpec> runs;
  for (const Opening& o : kOpenings) {
    std::vector<std::string> overrides{fmt::format("wall.opening.1.first_half_unit={}", o.first_half_unit),
                                       fmt::format("wall.opening.1.half_units={}", o.half_units),
                                       fmt::format("wall.opening.1.first_course={}", o.first_course),
                                       fmt::format("wall.opening.1.courses={}", o.courses)};
    if (!o.shown) overrides.push_back("stage.shear.displacement=0.006");
    runs.push_back(shear_run(q, o.name, "hollow_wall", overrides, o.cost));
  }
  runs.push_back(
      shear_run(q, kFineZones, "hollow_wall", {"wall.zones=[8, 4, 2]", "stage.shear.displacement=0.006"}, 4.0));
  runs.push_back(printed_run(kPrintedHollow, "hollow_wall", 0.01, 0.005, 0.6, {}, 2.0));
  runs.push_back(printed_run(kPrintedHollowLongStep, "hollow_wall", 0.01, 0.005, 0.8, {}, 0.2));
  return runs;
}

StudyReport report_hollow(const Findings& findings) {
  StudyReport report;
  Chart chart{"curves", "Wall with an opening, 0.30 MPa", "displacement of the top beam (mm)", "horizontal force (kN)"};
  std::vector<std::pair<std::string, const Curve*>> curves;
  Table table{"Openings", {"opening", "peak", "at", "at the end of the run"}, {}};
  chart.add_band("J2G, J3G peaks", Kind::recalled, 20, 40, 6);
  std::vector<std::string> names;
  for (const Opening& o : kOpenings) names.emplace_back(o.name);
  for (const char* name : {kFineZones, kPrintedHollow}) names.emplace_back(name);
  double low = 1e9, high = 0.0;
  int colour = 0;
  for (const std::string& name : names) {
    const Curve& c = findings.run(name).curve;
    curves.emplace_back(name, &c);
    const auto opening =
        std::find_if(kOpenings.begin(), kOpenings.end(), [&](const Opening& o) { return name == o.name; });
    if (opening != kOpenings.end()) low = std::min(low, c.peak()), high = std::max(high, c.peak());
    if (opening != kOpenings.end() && opening->shown) chart.add(name, c, colour++);
    table.rows.push_back({name, fmt::format("{:.1f} kN", c.peak()), fmt::format("{:.1f} mm", c.peak_displacement()),
                          fmt::format("{:.1f} kN at {:.0f} mm", c.last_force(), c.displacement.back())});
  }
  const Curve& main = findings.run("2 half bricks").curve;
  draw(chart, findings, report, "Curves. Band: peaks of the tests as recalled [R].");
  findings.add_cracks(report, "2 half bricks", "Opening of 2 half bricks: the end of the run.");
  findings.add_cracks(report, "3 half bricks", "Opening of 3 half bricks.");
  report.tables.push_back(std::move(table));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  const double printed = findings.run(kPrintedHollow).curve.peak(), fine = findings.run(kFineZones).curve.peak(),
               wide = findings.run("3 half bricks").curve.peak();
  report.verdicts.push_back(
      {"peak in the range of the tests (recalled: orientation only)", main.peak(), 30.0, "kN", Kind::recalled,
       main.peak() >= 20 && main.peak() <= 40,
       fmt::format("{:.1f} kN at {:.1f} mm; recalled 20 to 40 kN. Eq. 1 as printed {:.1f} kN, finer zones {:.1f} kN, "
                   "other openings {:.1f} to {:.1f} kN",
                   main.peak(), main.peak_displacement(), printed, fine, low, high)});
  if (main.peak() > 40.0)
    report.differs = {fmt::format(
        "The peak lies above the range that is recalled. Neither damping and time step ({:.1f} kN by eq. 1 as printed) "
        "nor the zones ({:.1f} kN with finer ones) are the cause. The assumed size of the opening is what matters, its "
        "width above all: {:.1f} kN with half a brick more.",
        printed, fine, wide)};
  report.notes = {
      "The paper does not print the size of the opening; it says that it is at the centre. 2 half bricks by 6 courses "
      "is "
      "assumed; on the grid of half bricks it cannot stand in the middle of 9, so both neighbouring places are run, "
      "and "
      "odd widths, which can. No opening is chosen by its result: the verdict is that of the size assumed first.",
      fmt::format("Eq. 1 as printed with a step of 0.8 of 2/omega_max, above its own limit of 0.745 (see rate): {}.",
                  outcome_text(findings.outcome(kPrintedHollowLongStep)))};
  return report;
}

}  // namespace quoin::reproduce
