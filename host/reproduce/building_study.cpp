// The Pavia building: the detached door wall, and the window wall with its transverse walls.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "files/file.h"
#include "reproduce/building_layouts.h"
#include "reproduce/chart.h"

namespace quoin::reproduce {

namespace {

struct Model {
  const char *name, *scene;
  double measured;                 // peak base shear of the test, kN [R]
  double overestimate;             // peak of the paper's model above the test, % [P]
  Count table;                     // Table 2 [P]
  std::vector<double> velocities;  // velocities of the push, m/s, the slowest last
  double cost;                     // cost of the run at the first velocity, as RunSpec::cost
  std::size_t openings;
};
const std::array<Model, 2>& models() {
  static const std::array<Model, 2> all{
      {{"wall D", "pavia_door", 150.0, 0.0, kTableD, {0.02, 0.01, 0.005, 0.0025}, 10.0, 4},
       {"walls A + B + C", "pavia_window", 140.0, 15.0, kTableABC, {0.02, 0.01, 0.005, 0.0025}, 30.0, 6}}};
  return all;
}
constexpr double kRoof = 5760.0;     // mm above the ground [R]
constexpr double kPastPeak = 0.018;  // m; end of all runs but the first of each model, which ends at 0.43 % drift

// Name of a run; at the first velocity that of the model.
std::string run_name(const Model& m, double velocity) {
  return velocity == m.velocities.front() ? m.name : fmt::format("{}, {:g} mm/s", m.name, 1e3 * velocity);
}

// A change of an unknown or altered property, run at the first velocity of its model.
struct Variant {
  std::string name, what;
  std::vector<std::string> overrides;
  std::size_t model;  // index into models()
};

std::vector<std::string> lintels_of(const Model& m, double young_modulus) {
  std::vector<std::string> settings{
      fmt::format("materials.lintel={{young_modulus = {:g}, poisson_ratio = 0.2, density = 1750}}", young_modulus)};
  for (std::size_t i = 1; i <= m.openings; ++i)
    settings.push_back(fmt::format("building.wall.1.opening.{}.lintel_material=lintel", i));
  return settings;
}

std::vector<std::string> without_lintels(const Model& m) {
  std::vector<std::string> settings;
  for (std::size_t i = 1; i <= m.openings; ++i)
    settings.push_back(fmt::format("building.wall.1.opening.{}.bearing=0", i));
  return settings;
}

// Layouts of the shipped scenes: equal windows in both walls, 6.00 x 4.00 m in total.
constexpr DoorLayout kDoors{5, 12, 5, 6};
constexpr WindowLayout kWindows{28, 19, 6, false};

std::vector<Variant> layout_variants() {
  std::vector<Variant> all;
  for (const DoorLayout& layout : door_layouts()) {
    if (why_not(layout).empty() && layout != kDoors) all.push_back({layout.name(), "", layout.overrides(), 0});
  }
  for (const WindowLayout& layout : window_layouts()) {
    if (why_not(layout).empty() && layout != kWindows) all.push_back({layout.name(), "", layout.overrides(), 1});
  }
  return all;
}

std::vector<Variant> changes() {
  std::vector<Variant> all;
  for (std::size_t i = 0; i < models().size(); ++i) {
    const Model& m = models()[i];
    all.push_back({fmt::format("{}, rigid beams", m.name),
                   "floor beams are rigid half blocks bedded in mortar, which carry the floor and are pushed",
                   {"building.floor.1.rigid_beams=true", "building.floor.2.rigid_beams=true"},
                   i});
    for (const double factor : {3.0, 12.0}) {
      if (i == 1 && factor != 12.0) continue;  // wall D has the same result in a third of the time
      all.push_back({fmt::format("{}, lintels x {:g}", m.name, factor),
                     fmt::format("lintels {:g} times as stiff as units", factor), lintels_of(m, factor * 2.4e9), i});
    }
  }
  all.push_back({"wall D, no lintels", "half units in place of the lintels", without_lintels(models()[0]), 0});
  all.push_back({"wall D, joints of the pier tests",
                 "joint cohesion 0.23 MPa and friction 0.58, as tested for the same masonry (study blind), in place of "
                 "Table 3's 0.075 MPa and 30 degrees",
                 {"joints.mortar.cohesion=0.23e6", "joints.mortar.friction_angle=30.114"},
                 0});
  return all;
}

std::string range_text(const std::vector<double>& values, const char* unit) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return std::round(*low) == std::round(*high) ? fmt::format("{:.0f} {}", *low, unit)
                                               : fmt::format("{:.0f} to {:.0f} {}", *low, *high, unit);
}

std::string with_sign(double percent) { return fmt::format("{:+.0f} %", percent); }

}  // namespace

std::vector<RunSpec> building_runs(const Quality& q) {
  std::vector<RunSpec> runs;
  const auto add = [&](const std::string& name, const Model& m, std::vector<std::string> overrides, double velocity) {
    overrides.push_back(fmt::format("stage.push.velocity={:g}", velocity));
    if (name != m.name) overrides.push_back(fmt::format("stage.push.displacement={:g}", kPastPeak));
    overrides.push_back(q.setting());
    runs.push_back({name, m.scene, std::move(overrides), "", m.cost * m.velocities.front() / velocity});
  };
  for (const Model& m : models()) {
    for (const double velocity : m.velocities) add(run_name(m, velocity), m, {}, velocity);
  }
  for (const auto& variants : {layout_variants(), changes()}) {
    for (const Variant& v : variants) {
      const Model& m = models()[v.model];
      add(v.name, m, v.overrides, m.velocities.front());
    }
  }
  return runs;
}

namespace {

// Report of the study: curves and peaks of both models, their layouts, and effects of single changes.
class BuildingReport {
 public:
  explicit BuildingReport(const Findings& findings) : findings_(findings) {}

  StudyReport all() {
    for (std::size_t i = 0; i < models().size(); ++i) model(i);
    report_.tables.push_back(std::move(table_));
    report_.tables.push_back(std::move(rates_));
    layouts();
    changes_one_at_a_time();
    write_file(findings_.folder() / "curves.csv", curves_csv(curves_));
    words();
    return std::move(report_);
  }

 private:
  const Curve& curve_of(const std::string& name) {
    const Curve& curve = findings_.run(name).curve;
    curves_.emplace_back(name, &curve);
    return curve;
  }

  void model(std::size_t i) {
    const Model& m = models()[i];
    std::vector<double> peaks;  // by velocity, kN
    const std::string by_velocity = chart(m, peaks);
    const std::string slowest = run_name(m, m.velocities.back());
    // The slowest run is the converged one; the first one continues to the drift of the test.
    const RunResult& run = findings_.run(slowest);
    const Curve &c = run.curve, &whole = findings_.run(m.name).curve;
    converged_[i] = c.peak();
    const long blocks = run.blocks + run.beams - 1;  // one beam is the ground
    const double off = 100 * (c.peak() / m.measured - 1);
    table_.rows.push_back({m.name, fmt::format("{} ({})", blocks, m.table.blocks),
                           fmt::format("{} ({})", run.zones, kZonesPerHalfUnit * m.table.half_units),
                           std::to_string(run.points), fmt::format("{:.0f} kN", c.peak()),
                           fmt::format("{:.1f} mm", c.peak_displacement()), fmt::format("{:g} kN", m.measured),
                           with_sign(off), fmt::format("{:+g} %", m.overestimate),
                           fmt::format("{:.0f} kN", whole.last_force()), fmt::format("{:.0f} s", run.wall_clock)});
    report_.verdicts.push_back(
        {m.overestimate > 0 ? fmt::format("capacity of {}: about 15 % above the test", m.name)
                            : fmt::format("capacity of {} meets the test", m.name),
         off, m.overestimate, "%", Kind::printed, std::abs(off - m.overestimate) <= 15,
         fmt::format("{:.0f} kN at {:.1f} mm in the slowest run ({}: {}); test about {:g} kN (recalled): {}, the "
                     "paper's model {:+g} %",
                     c.peak(), c.peak_displacement(), by_velocity, range_text(peaks, "kN"), m.measured, with_sign(off),
                     m.overestimate)});
    report_.verdicts.push_back({fmt::format("number of blocks of {}, within 5 %", m.name), static_cast<double>(blocks),
                                static_cast<double>(m.table.blocks), "", Kind::printed,
                                std::abs(static_cast<double>(blocks) / m.table.blocks - 1) < 0.05,
                                fmt::format("{} blocks and {} zones, Table 2: {} and {}", blocks, run.zones,
                                            m.table.blocks, kZonesPerHalfUnit * m.table.half_units)});
    const double drift = 100 * whole.displacement.back() / kRoof;
    report_.verdicts.push_back({fmt::format("{} follows the drift to 0.43 %", m.name), drift, 0.43, "%", Kind::seen,
                                drift > 0.425,
                                fmt::format("{:.2f} % of 5.76 m, with {:.0f} % of the peak left", drift,
                                            100 * whole.last_force() / whole.peak())});
  }

  // Draws the curves of a model, and returns its peaks: "80 / 79 kN at 20 / 10 mm/s".
  std::string chart(const Model& m, std::vector<double>& peaks) {
    Chart chart{m.scene, fmt::format("Pavia building, {}", m.name), "displacement of the roof (mm)", "base shear (kN)"};
    std::string by_velocity;
    for (std::size_t k = 0; k < m.velocities.size(); ++k) {
      const Curve& c = curve_of(run_name(m, m.velocities[k]));
      const std::string velocity = fmt::format("{:g} mm/s", 1e3 * m.velocities[k]);
      chart.add(velocity, c, static_cast<int>(k));
      peaks.push_back(c.peak());
      by_velocity += fmt::format("{}{:.0f}", k == 0 ? "" : " / ", c.peak());
      rates_.rows.push_back(
          {m.name, velocity, fmt::format("{:.0f} kN", c.peak()), fmt::format("{:.1f} mm", c.peak_displacement())});
    }
    by_velocity += " kN at ";
    for (std::size_t k = 0; k < m.velocities.size(); ++k)
      by_velocity += fmt::format("{}{:g}", k == 0 ? "" : " / ", 1e3 * m.velocities[k]);
    by_velocity += " mm/s";
    chart.add_level(fmt::format("measured, about {:g} kN", m.measured), Kind::recalled, m.measured, 5);
    if (m.overestimate > 0)
      chart.add_level(fmt::format("the paper's model: test {:+g} %, on the recalled test", m.overestimate),
                      Kind::printed, m.measured * (1 + m.overestimate / 100), 6);
    draw(chart, findings_, report_,
         fmt::format("{}: base shear against the displacement of the roof, equal forces at both floors.", m.name));
    const std::string slowest = run_name(m, m.velocities.back());
    for (const std::string& name : {std::string(m.name), slowest})
      findings_.add_cracks(report_, name,
                           fmt::format("{} at {:.0f} mm.{}", name, findings_.run(name).curve.displacement.back(),
                                       m.overestimate > 0 ? " Seen along the transverse walls." : ""));
    return by_velocity;
  }

  // Geometry and Table 2 alone select layouts, not the capacity.
  void layouts() {
    Table table{"Layouts that give the numbers of Table 2 (blocks, half units of 80 zones)",
                {"layout", "blocks", "half units", "geometry", "peak base shear, 20 mm/s"},
                {}};
    const auto add_layout = [&](std::size_t model, const std::string& name, const Count& count, bool in_scene,
                                const std::string& excluded, const std::string& remark) {
      std::string peak = "not run";
      if (excluded.empty()) {
        const Curve& c = in_scene ? findings_.run(models()[model].name).curve : curve_of(name);
        over_layouts_[model].push_back(c.peak());
        peak = fmt::format("{:.0f} kN at {:.1f} mm", c.peak(), c.peak_displacement());
      }
      table.rows.push_back({name, std::to_string(count.blocks), std::to_string(count.half_units),
                            excluded.empty() ? (in_scene ? "the scene: " : "") + remark : "no: " + excluded, peak});
    };
    for (const DoorLayout& l : door_layouts())
      add_layout(0, l.name(), l.count(), l == kDoors, why_not(l), l == kDoors ? "windows as in wall B" : "fits");
    for (const WindowLayout& l : window_layouts())
      add_layout(1, l.name(), l.count(), l == kWindows, why_not(l), fmt::format("6.00 x {:.2f} m", l.depth()));
    report_.tables.push_back(std::move(table));
  }

  void changes_one_at_a_time() {
    Chart causes{"changes", "Wall D: what its capacity hangs on", "displacement of the roof (mm)", "base shear (kN)"};
    causes.add("as the scene is", findings_.run(models()[0].name).curve, 0);
    causes.add_level("measured, about 150 kN", Kind::recalled, models()[0].measured, 6);
    Table changed{"One thing changed at a time, 20 mm/s", {"model", "change", "peak", "against the scene"}, {}};
    int colour = 1;
    for (const Variant& v : changes()) {
      const Model& m = models()[v.model];
      const Curve& c = curve_of(v.name);
      if (v.model == 0) causes.add(v.name.substr(std::string(m.name).size() + 2), c, colour++);
      changed.rows.push_back({m.name, v.what, fmt::format("{:.0f} kN at {:.1f} mm", c.peak(), c.peak_displacement()),
                              with_sign(100 * (c.peak() / findings_.run(m.name).curve.peak() - 1))});
    }
    draw(causes, findings_, report_, "One thing changed at a time, 20 mm/s.");
    report_.tables.push_back(std::move(changed));
  }

  void words() {
    for (std::size_t i = 0; i < models().size(); ++i) {
      const Model& m = models()[i];
      const double off = 100 * (converged_[i] / m.measured - 1);
      const std::string text = fmt::format(
          "{}: {:.0f} kN in the slowest run, {} of the recalled capacity, the paper's model {:+g} %; {} over "
          "the layouts that fit Table 2.",
          m.name, converged_[i], with_sign(off), m.overestimate, range_text(over_layouts_[i], "kN"));
      (std::abs(off - m.overestimate) <= 15 ? report_.agrees : report_.differs).push_back(text);
    }
    for (
        const char* note :
        {"Measured capacities are recalled, not seen: the verdicts compare with them within 15 points of the paper's "
         "difference. Table 2 gives the numbers of half units and, being smaller, of blocks: one lintel of 7 half "
         "units "
         "over each opening of 5. Sizes of piers and openings beyond that are recalled (door wall) or assumed (window "
         "wall); the scene files say which is which.",
         "Floors are point loads, as in the paper: half units at eleven beams carry a share of the floor and of the "
         "horizontal force each, by their gridpoints. Both floors are pushed by equal forces, F = K (u - (u1 + u2)/2), "
         "K = 100 kN/mm, so that the falling branch is followed too.",
         "What walls A + B + C carry hangs on the height of their windows, which Table 2 does not settle by itself: "
         "layouts "
         "with windows 8 and 10 courses high count as well, are weaker, and are in the table. The scene's is the one "
         "that is "
         "6.00 x 4.00 m over all with no blocks besides those of the walls, as in wall D, where the numbers fit "
         "exactly.",
         "Lintels of two hexahedra over their height are 32 % too stiff in bending, as tetrahedra of constant strain "
         "lock; "
         "the stiffer lintels tell what that matters.",
         "The building is pushed one way; the test was cyclic. The paper gives that, too, as a reason for its excess."})
      report_.notes.push_back(note);
    report_.seen = {
        "Velocity: peaks used to grow with it. Local damping at 0.8 of 2/omega_max fed the drift of the walls into "
        "vibration, which braked them in proportion to their velocity, by up to 20 kN at 20 mm/s. The step of the "
        "qualities now leaves no motion the period of four steps that this needs, and what scatter is left is that of "
        "cracks.",
        "Mechanisms. Wall D: the piers open at their feet and at the floors, stair-step "
        "cracks run through all spandrels, then a diagonal crack from the spandrel down through the middle pier, with "
        "which the force drops; the outer pier on the far side begins to crack diagonally below its spandrel. Walls A "
        "+ "
        "B + C: the same in the spandrels, diagonal cracks in the inner piers, while the outer pier turns over on its "
        "foot with a piece of the transverse wall. The paper: diagonal cracks from the spandrels through the piers, "
        "the "
        "outer pier of the door wall failing in shear, that of the window wall overturning."};
  }

  const Findings& findings_;
  StudyReport report_;
  std::vector<std::pair<std::string, const Curve*>> curves_;  // columns of curves.csv by name
  Table table_{"Models",
               {"model", "blocks (Table 2)", "zones (Table 2)", "contact points", "peak base shear", "at", "test [R]",
                "difference", "the paper's model [P]", "at 0.43 % drift", "run time"},
               {}};
  Table rates_{"Velocity of the push", {"model", "velocity", "peak base shear", "at"}, {}};
  std::array<double, 2> converged_{};                // peak of the slowest run, kN, by model
  std::array<std::vector<double>, 2> over_layouts_;  // peaks, kN, by model
};

}  // namespace

StudyReport report_building(const Findings& findings) { return BuildingReport(findings).all(); }

}  // namespace quoin::reproduce
