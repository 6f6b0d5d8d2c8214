// Figure 3: the law at one contact point, from the library that walls use.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "base/error.h"
#include "files/file.h"
#include "law/law_library.h"
#include "law/material_point.h"
#include "reproduce/chart.h"

namespace quoin::reproduce {

namespace {

// Table 1: properties of joints between units, in the order of the law's ids.
std::vector<PropertySetting> table_1() {
  std::vector<PropertySetting> settings;
  for (const auto& [id, value] : {std::pair{"normal_stiffness", 82e9},
                                  {"shear_stiffness", 36e9},
                                  {"tensile_strength", 0.2e6},
                                  {"cohesion", 0.3e6},
                                  {"friction_angle", 35.0},
                                  {"friction_angle_residual", 35.0},
                                  {"compressive_strength", 5e6},
                                  {"fracture_energy_tension", 15.0},
                                  {"fracture_energy_shear", 125.0},
                                  {"fracture_energy_compression", 8000.0}})
    settings.push_back({id, {value}, "", {"Table 1"}});
  return settings;
}

struct Path {
  std::vector<double> jump, stress;  // mm, MPa
  double peak = 0.0;                 // MPa
};

double area_above(const Path& path, double level) {  // J/m2
  double area = 0.0;
  for (std::size_t i = 1; i < path.jump.size(); ++i)
    area += (path.jump[i] - path.jump[i - 1]) * 1e-3 * ((path.stress[i] + path.stress[i - 1]) / 2 - level) * 1e6;
  return area;
}

// Each path begins with a new point.
constexpr int kSteps = 4000;

// sign: -1 makes compression positive in plots.
Path normal_path(const std::shared_ptr<const Material>& material, double to, double sign) {
  MaterialPoint point(material, "bonded");
  Path path;
  for (int i = 0; i <= kSteps; ++i) {
    const PointResult& now = point.move_to(to * i / kSteps, 0.0, 0.0);
    path.jump.push_back(sign * now.jump[0] * 1e3);
    path.stress.push_back(sign * now.traction[0] / 1e6);
    path.peak = std::max(path.peak, path.stress.back());
  }
  return path;
}

Path shear_path(const std::shared_ptr<const Material>& material, double pressure) {
  MaterialPoint point(material, "bonded");
  point.press_to(-pressure, 0.0, 0.0);
  Path path;
  for (int i = 0; i <= kSteps; ++i) {
    const PointResult& now = point.press_to(-pressure, 1.2e-3 * i / kSteps, 0.0);
    path.jump.push_back(now.jump[1] * 1e3);
    path.stress.push_back(now.traction[1] / 1e6);
    path.peak = std::max(path.peak, path.stress.back());
  }
  return path;
}

}  // namespace

StudyReport report_law(const Findings& findings) {
  StudyReport report;
  const auto material = std::make_shared<const Material>(Law::find("fracture_energy"), table_1());
  std::string csv = "path,jump_mm,stress_MPa\n";
  auto add_csv = [&](const std::string& name, const Path& path) {
    for (std::size_t i = 0; i < path.jump.size(); ++i)
      csv += fmt::format("{},{:.7g},{:.7g}\n", name, path.jump[i], path.stress[i]);
  };
  auto judge = [&](const std::string& claim, double number, double reference, const std::string& unit) {
    report.verdicts.push_back({claim, number, reference, unit, Kind::printed, std::abs(number / reference - 1) < 0.01,
                               fmt::format("{:.4g} {}, Table 1: {:.4g} {}", number, unit, reference, unit)});
  };

  const Path tension = normal_path(material, 0.2e-3, 1.0), compression = normal_path(material, -3.6e-3, -1.0);
  add_csv("tension", tension);
  add_csv("compression", compression);
  judge("peak in tension", tension.peak, 0.2, "MPa");
  judge("area under the tension curve", area_above(tension, 0.0), 15.0, "J/m2");

  Chart chart{"tension", "Tension, Table 1's joint", "opening (mm)", "normal stress (MPa)"};
  chart.series.push_back({"law fracture_energy", Mark::line, tension.jump, tension.stress, 0});
  chart.add_level("tensile strength 0.2 MPa", Kind::printed, 0.2, 6);
  draw(chart, findings, report,
       "Tension: up to the strength with the elastic stiffness, then down a line that encloses 15 J/m2.");

  Chart shears{"shear", "Shear at three confinements, Table 1's joint", "sliding (mm)", "shear stress (MPa)"};
  const double mu = std::tan(35.0 * M_PI / 180.0);
  int colour = 0;
  for (const double pressure : {0.30e6, 1.21e6, 2.12e6}) {
    const Path path = shear_path(material, pressure);
    add_csv(fmt::format("shear_{:.2f}_MPa", pressure / 1e6), path);
    shears.series.push_back({fmt::format("{:.2f} MPa", pressure / 1e6), Mark::line, path.jump, path.stress, colour});
    shears.add_level(fmt::format("residual mu sigma at {:.2f} MPa", pressure / 1e6), Kind::derived, mu * pressure / 1e6,
                     colour);
    const double residual = mu * pressure / 1e6, peak = 0.3 + residual;
    judge(fmt::format("peak in shear at {:.2f} MPa (c + mu sigma)", pressure / 1e6), path.peak, peak, "MPa");
    // Fracture energy: the area without that of residual friction and without the elastic energy that remains.
    const double tau = residual * 1e6, slip = path.jump.back() * 1e-3 - tau / 36e9;
    const double above = area_above(path, 0.0) - tau * slip - tau * tau / (2 * 36e9);
    judge(fmt::format("work above friction at {:.2f} MPa", pressure / 1e6), above, 125.0, "J/m2");
    ++colour;
  }
  draw(shears, findings, report, "Shear: the cohesion softens with the slip, the friction stays.");

  judge("peak in compression", compression.peak, 5.0, "MPa");
  judge("area under the compression curve", area_above(compression, 0.0), 8000.0, "J/m2");
  Chart pressed{"compression", "Compression, Table 1's joint", "closure (mm)", "pressure (MPa)"};
  pressed.series.push_back({"law fracture_energy", Mark::line, compression.jump, compression.stress, 0});
  pressed.add_level("compressive strength 5 MPa", Kind::printed, 5.0, 6);
  draw(pressed, findings, report, "Compression: elastic to the strength, then down a line that encloses 8000 J/m2.");
  write_file(findings.folder() / "curves.csv", csv);

  if (all_reproduced(report))
    report.agrees = {
        "Strengths and areas are those of Table 1 to less than 1 %, measured from outside by the trapezoidal rule."};
  report.notes = {
      "The paper's figure is a sketch without numbers. Its words leave open how the modes act on each other: here "
      "tension and "
      "shear share one softening variable (contact_models/fracture_energy/LAW.md), which the walls show to matter."};
  return report;
}

}  // namespace quoin::reproduce
