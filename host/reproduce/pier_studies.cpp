// Beyond the paper: blind predictions of two piers, and cyclic loads.
#include <fmt/format.h>

#include <cmath>

#include "files/file.h"
#include "reproduce/chart.h"

namespace quoin::reproduce {

namespace {
using Curves = std::vector<std::pair<std::string, const Curve*>>;
constexpr double kPierLoad = 150.0;  // kN: 0.6 MPa on 1.00 x 0.25 m
}  // namespace

std::vector<RunSpec> blind_runs(const Quality& q) {
  return {shear_run(q, "ISP1", "ispra_isp1", {}, 0.6), shear_run(q, "ISP3", "ispra_isp3", {}, 0.9)};
}

StudyReport report_blind(const Findings& findings) {
  StudyReport report;
  Chart chart{"curves", "Ispra piers, 0.60 MPa, blind", "displacement of the top (mm)", "horizontal force (kN)"};
  Curves curves;
  Table table{
      "Piers",
      {"pier", "height", "model", "at", "tests [S]", "difference", "failure in the test [S]", "rigid rocking bound"},
      {}};
  struct Pier {
    const char* name;
    double height, low, high;  // m, kN, kN
    const char* failure;
  };
  int colour = 0;
  for (const Pier& p : {Pier{"ISP1", 1.35, 81.4, 84.2, "shear"}, Pier{"ISP3", 2.0, 71.9, 72.2, "flexure"}}) {
    const Curve& c = findings.run(p.name).curve;
    const double mean = (p.low + p.high) / 2, off = 100 * (c.peak() / mean - 1);
    const double rocking = kPierLoad * 1.0 / p.height * (1 - 0.6 / (0.85 * 6.2));
    chart.add(fmt::format("{}, model", p.name), c, colour);
    chart.add_band(fmt::format("{}, tests +-: {} and {} kN", p.name, p.low, p.high), Kind::seen, p.low, p.high, colour);
    chart.add_level(fmt::format("{}, rigid rocking {:.1f} kN", p.name, rocking), Kind::derived, rocking, colour);
    ++colour;
    curves.emplace_back(p.name, &c);
    table.rows.push_back({p.name, fmt::format("{} m", p.height), fmt::format("{:.1f} kN", c.peak()),
                          fmt::format("{:.1f} mm", c.peak_displacement()), fmt::format("{} / {} kN", p.low, p.high),
                          fmt::format("{:+.0f} %", off), p.failure, fmt::format("{:.1f} kN", rocking)});
    report.verdicts.push_back({fmt::format("peak of {}, within 15 %", p.name), c.peak(), mean, "kN", Kind::seen,
                               std::abs(off) <= 15,
                               fmt::format("{:.1f} kN, tests {} and {} kN: {:+.0f} %", c.peak(), p.low, p.high, off)});
  }
  draw(chart, findings, report,
       "Curves. Bands: the two directions of the tests [S]; dotted: rigid blocks rocking on crushed toes [D].");
  findings.add_cracks(report, "ISP1", "ISP1 at the end. The test failed in shear.");
  findings.add_cracks(report, "ISP3", "ISP3 at the end. The test rocked.");
  report.tables.push_back(std::move(table));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  report.notes = {
      "Scenes written from the reference data before the first run; run once at each quality, nothing changed since. "
      "Test values: EPFL database of modern masonry walls [S].",
      "The tests were cyclic, the model is pushed one way: cycles wear joints, so a model is expected to come out "
      "higher."};
  return report;
}

// ---- Cyclic --------------------------------------------------------------------------------------------------------

namespace {

struct Cyclic {
  const char *name, *scene, *monotonic;
  int half_cycles;
  double cost;
};
constexpr Cyclic kCyclic[] = {{"solid wall", "cyclic_wall_121", "solid wall, one way", 6, 8.0},
                              {"pier ISP1", "cyclic_isp1", "pier ISP1, one way", 6, 2.0}};

// Dissipated work of each half cycle over the rectangle of its largest force and its path: 0 for elastic, 1 for
// rigid-plastic.
double fullness(const Curve& c, int half_cycle) {
  double work = 0.0, path = 0.0, largest = 0.0;
  for (std::size_t i = 1; i < c.size(); ++i) {
    if (c.half_cycle[i] != half_cycle || c.half_cycle[i - 1] != half_cycle) continue;
    const double d = c.displacement[i] - c.displacement[i - 1];
    work += d * (c.force[i] + c.force[i - 1]) / 2;
    path += std::abs(d);
    largest = std::max(largest, std::abs(c.force[i]));
  }
  return path > 0 && largest > 0 ? work / (path * largest) : 0.0;
}

}  // namespace

std::vector<RunSpec> cyclic_runs(const Quality& q) {
  std::vector<RunSpec> runs;
  for (const Cyclic& c : kCyclic) {
    RunSpec spec{c.name, c.scene, {q.setting()}, "", c.cost};
    // The scenes have 10 mm/s.
    const double velocity = q.name == "reference" ? 0.005 : q.name == "fast" ? 0.02 : 0.01;
    if (velocity != 0.01) spec.overrides.push_back(fmt::format("stage.cycles.velocity={}", velocity));
    runs.push_back(spec);
  }
  runs.push_back(shear_run(q, "solid wall, one way", "solid_wall_121"));
  runs.push_back(shear_run(q, "pier ISP1, one way", "ispra_isp1", {}, 0.6));
  return runs;
}

StudyReport report_cyclic(const Findings& findings) {
  StudyReport report;
  Curves curves;
  Table table{
      "Half cycles", {"structure", "half cycle", "to", "largest force", "work lost over largest force times path"}, {}};
  for (const Cyclic& setup : kCyclic) {
    const Curve &c = findings.run(setup.name).curve, &one_way = findings.run(setup.monotonic).curve;
    curves.emplace_back(setup.name, &c);
    curves.emplace_back(setup.monotonic, &one_way);
    Chart chart{setup.scene, fmt::format("Cyclic: {}", setup.name), "displacement of the top (mm)",
                "horizontal force (kN)"};
    chart.from_zero = false;
    chart.extra = "set xzeroaxis linecolor rgb \"#888888\"\nset yzeroaxis linecolor rgb \"#888888\"\n";
    chart.add("cycles", c, 0);
    chart.add("one way", one_way, 1, Mark::dashed);
    draw(chart, findings, report, fmt::format("{}: cycles against loading one way.", setup.name));
    findings.add_cracks(report, setup.name, fmt::format("{} after the cycles.", setup.name));
    double highest = 0.0, lowest = 0.0;
    for (int i = 0; i < setup.half_cycles; ++i) {
      double largest = 0.0, to = 0.0;
      for (std::size_t k = 0; k < c.size(); ++k) {
        if (c.half_cycle[k] != i) continue;
        to = c.displacement[k];
        if (std::abs(c.force[k]) > std::abs(largest) && c.force[k] * (i % 2 == 0 ? 1.0 : -1.0) > 0)
          largest = c.force[k];
      }
      highest = std::max(highest, largest);
      lowest = std::min(lowest, largest);
      table.rows.push_back({setup.name, std::to_string(i + 1), fmt::format("{:+.2f} mm", to),
                            fmt::format("{:+.1f} kN", largest), fmt::format("{:.2f}", fullness(c, i))});
    }
    report.verdicts.push_back(
        {fmt::format("cycles do not exceed loading one way: {}", setup.name), highest, one_way.peak(), "kN",
         Kind::derived, highest <= 1.03 * one_way.peak(),
         fmt::format("{:+.1f} and {:+.1f} kN in cycles, {:.1f} kN one way", highest, lowest, one_way.peak())});
    const double last = fullness(c, setup.half_cycles - 1);
    report.verdicts.push_back({fmt::format("half cycles lose work: {}", setup.name), last, std::nullopt, "",
                               Kind::derived, last > 0.0,
                               fmt::format("{:.2f} of the largest force times the path in the last half cycle", last)});
  }
  report.tables.push_back(std::move(table));
  write_file(findings.folder() / "curves.csv", curves_csv(curves));
  report.notes = {
      "What the law can do: unload tension along the secant, close again with full stiffness, keep damage and crushing "
      "in both directions, and lose work by friction: "
      "loops, falling strength from cycle to cycle, and the rising of a wall whose height is held."};
  report.differs = {
      "What it cannot: grow damage by cycles below an earlier peak (no fatigue), wear asperities or lose friction with "
      "slip unless a residual angle is given, "
      "crush progressively on reloading (unloading is elastic with full stiffness), or dilate and close again as rough "
      "joints do. Strength and stiffness "
      "lost between equal cycles are therefore underestimated, and no verdict here speaks of a test."};
  return report;
}

}  // namespace quoin::reproduce
