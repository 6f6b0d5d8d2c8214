// The paper's parametric analysis: contact points, stiffness, block size, fracture energies.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "files/file.h"
#include "reproduce/chart.h"
#include "scene/quality.h"

namespace quoin::reproduce {

namespace {

using Curves = std::vector<std::pair<std::string, const Curve*>>;

double percent(double number, double reference) { return 100.0 * (number / reference - 1.0); }

}  // namespace

// ---- Contact points ------------------------------------------------------------------------------------------------

std::vector<RunSpec> contact_point_runs(const Quality& q) {
  return {shear_run(q, "B2T4", "solid_wall_030", {"wall.zones=[2, 1, 1]"}, 0.2), shear_run(q, "B2T8", "solid_wall_030"),
          shear_run(q, "B2T16", "solid_wall_030", {"wall.zones=[8, 4, 2]"}, 8.0)};
}

StudyReport report_contact_points(const Findings& findings) {
  StudyReport report;
  Chart chart{"curves", "Contact points, 0.30 MPa", "displacement of the top beam (mm)", "horizontal force (kN)"};
  Table table{"Discretisations",
              {"name", "hexahedra per half brick", "points along its edge", "zones", "contact points", "peak", "at",
               "run time (one core)"},
              {}};
  Curves curves;
  int colour = 0;
  for (const auto& [name, zones, points] :
       {std::tuple{"B2T4", "2 x 1 x 1", 3}, {"B2T8", "4 x 2 x 2", 5}, {"B2T16", "8 x 4 x 2", 9}}) {
    const RunResult& run = findings.run(name);
    chart.add(fmt::format("{}: {} points along the edge", name, points), run.curve, colour++);
    curves.emplace_back(name, &run.curve);
    table.rows.push_back({name, zones, std::to_string(points), std::to_string(run.zones), std::to_string(run.points),
                          fmt::format("{:.1f} kN", run.curve.peak()),
                          fmt::format("{:.2f} mm", run.curve.peak_displacement()),
                          fmt::format("{:.0f} s", run.wall_clock)});
  }
  const double low = findings.run("B2T4").curve.peak(), middle = findings.run("B2T8").curve.peak(),
               fine = findings.run("B2T16").curve.peak();
  report.verdicts.push_back({"moderate equals fine", percent(middle, fine), 0.0, "%", Kind::printed,
                             std::abs(percent(middle, fine)) < 5,
                             fmt::format("{:.1f} against {:.1f} kN: {:+.1f} %", middle, fine, percent(middle, fine))});
  report.verdicts.push_back({"few points overestimate the capacity", percent(low, fine), std::nullopt, "%",
                             Kind::printed, percent(low, fine) > 5,
                             fmt::format("{:.1f} against {:.1f} kN: {:+.1f} %", low, fine, percent(low, fine))});
  draw(chart, findings, report, "Three discretisations of the half brick.");
  findings.add_cracks(report, "B2T4", "B2T4: cracks at the end.");
  findings.add_cracks(report, "B2T16", "B2T16: cracks at the end.");
  report.tables.push_back(std::move(table));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  report.notes = {"Figure 13 does not say its pressure; 0.30 MPa is taken, where joints open most."};
  return report;
}

// ---- Stiffness -----------------------------------------------------------------------------------------------------

namespace {
constexpr std::array<int, 6> kRatios{1, 2, 3, 4, 6, 10};
// Ratios run as the paper's equations read. The last also has another time step, which shows the random part of a
// curve.
constexpr std::array<int, 3> kPrintedRatios{4, 6, 10};
constexpr const char* kOtherStep = "10, as printed, step 0.59";

std::string as_printed(int ratio, const char* more = "") { return fmt::format("{}, as printed{}", ratio, more); }
constexpr const char* kLongStep = ", step 0.8";

std::vector<std::string> stiffness_overrides(int ratio) {
  return {fmt::format("joints.unit.normal_stiffness={}e9", 82 * ratio),
          fmt::format("joints.unit.shear_stiffness={}e9", 82 * ratio)};
}
}  // namespace

std::vector<RunSpec> stiffness_runs(const Quality& q) {
  std::vector<RunSpec> runs;
  for (const int ratio : kRatios)
    runs.push_back(shear_run(q, std::to_string(ratio), "solid_wall_121", stiffness_overrides(ratio)));
  const auto add = [&](const std::string& name, int ratio, double fraction) {
    runs.push_back(printed_run(name, "solid_wall_121", 0.01, 0.0025, fraction, stiffness_overrides(ratio)));
  };
  for (const int ratio : kPrintedRatios) add(as_printed(ratio), ratio, 0.6);
  add(kOtherStep, 10, 0.59);
  for (const int ratio : {4, 10}) add(as_printed(ratio, kLongStep), ratio, 0.8);
  return runs;
}

namespace {

// Distances of curves of ratio 4 and more from that of ratio 10, % of the peak.
struct Distances {
  double all = 0.0, before = 0.0, after = 0.0;  // over the whole curve; up to 2 mm; from 2.3 mm
};

Distances distances_as_printed(const Findings& findings) {
  const Curve& stiff = findings.run(as_printed(10)).curve;
  Distances most;
  for (const int ratio : kPrintedRatios) {
    const Curve& c = findings.run(as_printed(ratio)).curve;
    most.all = std::max(most.all, curve_distance(c, stiff, 0.05, 2.45));
    most.before = std::max(most.before, curve_distance(c, stiff, 0.05, 2.0));
    most.after = std::max(most.after, curve_distance(c, stiff, 2.3, 2.45));
  }
  return most;
}

Table table_as_printed(const Findings& findings, Curves* curves) {
  const Curve& stiff = findings.run(as_printed(10)).curve;
  Table table{"Eq. 1 exactly as printed, 10 mm/s at once, to 2.5 mm",
              {"ratio", "what came of it", "distance from ratio 10", "up to 2 mm", "from 2.3 mm on",
               "drop to 90 % of the peak at"},
              {}};
  std::vector<std::string> names;
  for (const int ratio : kPrintedRatios) names.push_back(as_printed(ratio));
  for (const std::string& name : {std::string(kOtherStep), as_printed(4, kLongStep), as_printed(10, kLongStep)})
    names.push_back(name);
  for (const std::string& name : names) {
    const RunResult& run = findings.outcome(name);
    const Curve& c = run.curve;
    table.rows.push_back({name, outcome_text(run)});
    if (!run.complete) continue;
    curves->emplace_back(name, &c);
    table.rows.back().insert(table.rows.back().end(),
                             {fmt::format("{:.1f} %", curve_distance(c, stiff, 0.05, 2.45)),
                              fmt::format("{:.1f} %", curve_distance(c, stiff, 0.05, 2.0)),
                              fmt::format("{:.1f} %", curve_distance(c, stiff, 2.3, 2.45)), drop_text(c)});
  }
  return table;
}

void draw_as_printed(const Findings& findings, StudyReport* report) {
  Chart chart{"as_printed", "Unit joint over mortar joint stiffness, eq. 1 as printed, 10 mm/s",
              "displacement of the top beam (mm)", "horizontal force (kN)"};
  int colour = 0;
  for (const int ratio : kPrintedRatios)
    chart.add(fmt::format("ratio {}", ratio), findings.run(as_printed(ratio)).curve, colour++);
  chart.add("ratio 10, another time step", findings.run(kOtherStep).curve, colour, Mark::dashed);
  draw(chart, findings, *report, "Eq. 1 exactly as printed: the drop moves with the stiffness, not by chance.");
}

std::vector<std::string> why_curves_differ(const Findings& findings, double above_four, double up_to_two) {
  const Curve &printed_stiff = findings.run(as_printed(10)).curve, &other_step = findings.run(kOtherStep).curve;
  return {fmt::format("The curves differ by {:.0f} % of the peak where the diagonal gives way at once, between 2 and "
                      "2.3 mm: a drop that comes 0.1 mm earlier or later is a large distance. "
                      "Up to 2 mm they differ by {:.1f} %.",
                      above_four, up_to_two),
          fmt::format(
              "Cause tested: it is the stiffness, not chance and not the way of running. By eq. 1 as printed the "
              "drop of ratio 4 begins at {}, of 6 at {}, of 10 at {} (standard damping and 20 "
              "mm/s: table), while another time step moves that of ratio 10 to {}, {:.1f} % of the peak at "
              "most between the two curves. Softer units give way later, in proportion to 1/ratio, and 4 is no "
              "threshold; beside the drop the curves are what a picture shows as one.",
              drop_text(findings.run(as_printed(4)).curve), drop_text(findings.run(as_printed(6)).curve),
              drop_text(printed_stiff), drop_text(other_step), curve_distance(other_step, printed_stiff, 0.05, 2.45))};
}

}  // namespace

StudyReport report_stiffness(const Findings& findings) {
  StudyReport report;
  Chart chart{"curves", "Unit joint over mortar joint stiffness, 1.21 MPa", "displacement of the top beam (mm)",
              "horizontal force (kN)"};
  Table table{"Ratios",
              {"ratio", "peak", "distance from ratio 10 up to 2.5 mm", "up to the end", "drop to 90 % of the peak at"},
              {}};
  Curves curves;
  const Curve& stiff = findings.run("10").curve;
  double above_four = 0.0, peak_four = 0.0, up_to_two = 0.0;
  int colour = 0;
  for (const int ratio : kRatios) {
    const Curve& c = findings.run(std::to_string(ratio)).curve;
    chart.add(fmt::format("ratio {}", ratio), c, colour++);
    curves.emplace_back(fmt::format("ratio {}", ratio), &c);
    const double near = curve_distance(c, stiff, 0.05, 2.5), far = curve_distance(c, stiff, 0.05, 4.9);
    table.rows.push_back({std::to_string(ratio), fmt::format("{:.1f} kN", c.peak()),
                          fmt::format("{:.1f} % of the peak", near), fmt::format("{:.1f} %", far), drop_text(c)});
    if (ratio >= 4) {
      above_four = std::max(above_four, near);
      up_to_two = std::max(up_to_two, curve_distance(c, stiff, 0.05, 2.0));
      peak_four = std::max(peak_four, std::abs(percent(c.peak(), stiff.peak())));
    }
  }
  report.verdicts.push_back({"peaks are the same from ratio 4 on", peak_four, 0.0, "%", Kind::printed, peak_four < 2,
                             fmt::format("peaks from 4 on within {:.1f} % of that at 10; at 1 {:+.1f} %", peak_four,
                                         percent(findings.run("1").curve.peak(), stiff.peak()))});
  Table printed = table_as_printed(findings, &curves);
  const Distances of_printed = distances_as_printed(findings);
  report.verdicts.push_back(
      {"curves are the same from ratio 4 on, to 2.5 mm", above_four, 0.0, "% of the peak", Kind::printed,
       above_four < 5,
       fmt::format(
           "largest distance {:.1f} % of the peak, by eq. 1 as printed {:.1f} %: at the drop; there {:.1f} % up "
           "to 2 mm and {:.1f} % from 2.3 mm on",
           above_four, of_printed.all, of_printed.before, of_printed.after)});
  draw(chart, findings, report, "Normal and shear stiffness of the joint inside units, from 1 to 10 times 82 GPa/m.");
  draw_as_printed(findings, &report);
  report.tables.push_back(std::move(table));
  report.tables.push_back(std::move(printed));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  if (above_four >= 5) report.differs = why_curves_differ(findings, above_four, up_to_two);
  report.notes = {"Both stiffnesses of the unit joint are varied together, equal as in Table 1 (which has ratio 12).",
                  fmt::format("Eq. 1 as printed with a step of 0.8 of 2/omega_max, above its own limit of 0.745 (see "
                              "rate): ratio 4 {}, ratio 10 {}; noise of stiff modes, not a response.",
                              outcome_text(findings.outcome(as_printed(4, kLongStep))),
                              outcome_text(findings.outcome(as_printed(10, kLongStep))))};
  return report;
}

// ---- Block size ----------------------------------------------------------------------------------------------------

namespace {
struct Size {
  const char *name, *scene, *paper;
  double cost;
};
constexpr std::array<Size, 4> kSizes{{{"60 blocks", "wall_2m_60", "16 min", 0.7},
                                      {"144 blocks", "wall_2m_144", "", 1.5},
                                      {"240 blocks", "wall_2m_240", "", 3.0},
                                      {"576 blocks", "wall_2m_576", "140 min", 12.0}}};
}  // namespace

std::vector<RunSpec> block_size_runs(const Quality& q) {
  std::vector<RunSpec> runs;
  for (const Size& s : kSizes) runs.push_back(shear_run(q, s.name, s.scene, {}, s.cost));
  return runs;
}

StudyReport report_block_size(const Findings& findings) {
  StudyReport report;
  Chart chart{"curves", "Size of blocks: 2 m x 2 m wall, 1.21 MPa", "displacement of the top beam (mm)",
              "horizontal force (kN)"};
  Table table{"Sizes, run times for 10 mm of drift",
              {"blocks", "zones", "contact points", "peak", "at", "steps", "run time, one core",
               "the paper's, 2.1 GHz Xeon [P]"},
              {}};
  Curves curves;
  std::vector<double> peaks;
  int colour = 0;
  for (const Size& s : kSizes) {
    const RunResult& run = findings.run(s.name);
    chart.add(s.name, run.curve, colour++);
    curves.emplace_back(s.name, &run.curve);
    peaks.push_back(run.curve.peak());
    table.rows.push_back({std::to_string(run.blocks), std::to_string(run.zones), std::to_string(run.points),
                          fmt::format("{:.1f} kN", run.curve.peak()),
                          fmt::format("{:.2f} mm", run.curve.peak_displacement()), std::to_string(run.steps),
                          fmt::format("{:.0f} s", run.wall_clock), s.paper});
  }
  const auto [low, high] = std::minmax_element(peaks.begin(), peaks.end());
  const double spread = percent(*high, *low);
  report.verdicts.push_back({"peaks within 6 %", spread, 6.0, "%", Kind::printed, spread <= 6,
                             fmt::format("from {:.1f} to {:.1f} kN: {:.1f} %", *low, *high, spread)});
  // Peaks closer than their errors show neither rise nor fall. Errors of 2 m walls are at most 0.7 %
  // (benchmarks/README.md), less than for other walls.
  const double error = std::min(0.01, quoin::quality_named(findings.quality().name).peak_error);
  const bool falls = std::adjacent_find(peaks.begin(), peaks.end(), [&](double coarse, double fine) {
                       return fine > (1.0 + error) * coarse;
                     }) == peaks.end();
  report.verdicts.push_back({"the peak falls with the number of blocks", percent(peaks[3], peaks[0]), std::nullopt, "%",
                             Kind::printed, falls,
                             fmt::format("60: {:.1f}, 144: {:.1f}, 240: {:.1f}, 576: {:.1f} kN, each to {:g} %",
                                         peaks[0], peaks[1], peaks[2], peaks[3], 100.0 * error)});
  report.verdicts.push_back(
      {"240 and 576 blocks differ little", percent(peaks[2], peaks[3]), 0.0, "%", Kind::printed,
       std::abs(percent(peaks[2], peaks[3])) < 2,
       fmt::format("{:.1f} and {:.1f} kN: {:+.1f} %", peaks[2], peaks[3], percent(peaks[2], peaks[3]))});
  const double fine = findings.run("576 blocks").wall_clock / 60;
  report.verdicts.push_back(
      {"time for the 576-block wall", fine, 140.0, "min", Kind::printed, fine < 140,
       fmt::format("{:.1f} min on one core, the paper {:.0f}; {:.1f} times as fast", fine, 140.0, 140 / fine)});
  draw(chart, findings, report, "Four sizes of blocks; joint stiffness times block height is kept.");
  findings.add_cracks(report, "60 blocks", "60 blocks.");
  findings.add_cracks(report, "576 blocks", "576 blocks.");
  report.tables.push_back(std::move(table));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  report.notes = {
      "Run times are those of whole programs that share the machine with other runs. The top beam moves twice as fast "
      "as that of a 1 m wall. "
      "The paper's time covers a run at 1 mm/s, if its general statement holds here: then compare the times per step "
      "and not those per run.",
      "The paper's formula for the stiffness is printed upside down; its text (stiffer for smaller blocks) is "
      "followed."};
  return report;
}

// ---- Fracture energies ---------------------------------------------------------------------------------------------

namespace {
constexpr std::array<double, 4> kFactors{0.5, 1.0, 2.0, 4.0};
}

std::vector<RunSpec> energy_runs(const Quality& q) {
  std::vector<RunSpec> runs;
  for (const double f : kFactors) {
    const std::vector<std::string> overrides{fmt::format("joints.mortar.fracture_energy_tension={}", 15 * f),
                                             fmt::format("joints.mortar.fracture_energy_shear={}", 125 * f)};
    runs.push_back(
        shear_run(q, fmt::format("x {}", f), "solid_wall_121", f == 1.0 ? std::vector<std::string>{} : overrides));
  }
  return runs;
}

StudyReport report_energy(const Findings& findings) {
  StudyReport report;
  Chart chart{"curves", "Fracture energies of the mortar joints, 1.21 MPa", "displacement of the top beam (mm)",
              "horizontal force (kN)"};
  Table table{"Factors on the energies in tension and shear",
              {"factor", "peak", "against 1", "at", "falls to 80 % of the peak at", "force at the end over the peak"},
              {}};
  Curves curves;
  const double base = findings.run("x 1").curve.peak();
  double worst = 0.0, worst_factor = 1.0;
  std::vector<double> ends;
  int colour = 0;
  for (const double f : kFactors) {
    const std::string name = fmt::format("x {}", f);
    const Curve& c = findings.run(name).curve;
    chart.add("energies " + name, c, colour++);
    curves.emplace_back(name, &c);
    const double off = percent(c.peak(), base), fall = c.displacement_after_peak(0.8);
    if (std::abs(off) > std::abs(worst)) worst = off, worst_factor = f;
    // A wall whose force never drops so far is ductile at least to the end of the run.
    ends.push_back(fall < 0 ? c.displacement.back() : fall);
    table.rows.push_back({fmt::format("{}", f), fmt::format("{:.1f} kN", c.peak()), fmt::format("{:+.1f} %", off),
                          fmt::format("{:.2f} mm", c.peak_displacement()),
                          fall < 0 ? "not before the end" : fmt::format("{:.2f} mm", fall),
                          fmt::format("{:.2f}", c.last_force() / c.peak())});
  }
  report.verdicts.push_back({"the peak changes by less than 10 %", worst, 10.0, "%", Kind::printed,
                             std::abs(worst) < 10,
                             fmt::format("largest change {:+.1f} %, at factor {}", worst, worst_factor)});
  report.verdicts.push_back(
      {"ductility grows with the energies", ends[3] / ends[0], std::nullopt, "x", Kind::printed,
       std::is_sorted(ends.begin(), ends.end()),
       fmt::format("falls to 80 % of its peak at {:.2f}, {:.2f}, {:.2f}, {:.2f} mm for 0.5, 1, 2, 4", ends[0], ends[1],
                   ends[2], ends[3])});
  draw(chart, findings, report, "Energies in tension and shear of the joints between units, multiplied together.");
  findings.add_cracks(report, "x 0.5", "Half the energies.");
  findings.add_cracks(report, "x 4", "Four times the energies.");
  report.tables.push_back(std::move(table));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  return report;
}

}  // namespace quoin::reproduce
