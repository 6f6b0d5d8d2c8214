#include "support.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "../scene_of_text.h"

namespace quoin::verification {

namespace {
const std::filesystem::path kRecords = "verification_records";

// Returns the record of the running test, named without the mark of long tests. The first line of a test overwrites the
// file of an earlier run.
std::ofstream record() {
  static std::string last;
  const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = test.name();
  if (name.starts_with("DISABLED_")) name.erase(0, 9);
  name = test.test_suite_name() + ("." + name);
  std::filesystem::create_directories(kRecords);
  std::ofstream file(kRecords / (name + ".csv"), name == last ? std::ios::app : std::ios::trunc);
  last = name;
  return file;
}

void write(const std::string& what, const std::string& expected, double measured, const std::string& error,
           double tolerance, const std::string& unit, const std::string& note) {
  char line[400];
  std::snprintf(line, sizeof line, "%-58s %14s %14.7g %-5s error %-9s (<= %.2g) %s", what.c_str(), expected.c_str(),
                measured, unit.c_str(), error.c_str(), tolerance, note.c_str());
  std::printf("  | %s\n", line);
  std::fflush(stdout);
  record() << '"' << what << "\"," << expected << ',' << measured << ',' << unit << ',' << error << ',' << tolerance
           << ",\"" << note << "\"\n";
}
std::string text(double x, const char* format) {
  char b[40];
  std::snprintf(b, sizeof b, format, x);
  return b;
}
}  // namespace

void check(const std::string& what, double expected, double measured, double tolerance, const std::string& unit,
           const std::string& note, double scale) {
  const double reference = expected != 0 ? std::abs(expected) : scale;
  const double error = std::abs(measured - expected) / reference;
  write(what, text(expected, "%.7g"), measured, text(error, "%.2e"), tolerance, unit, note);
  EXPECT_LE(error, tolerance) << what << ": expected " << expected << ", measured " << measured << ' ' << unit;
}

void check_error(const std::string& what, double error, double bound, const std::string& unit,
                 const std::string& note) {
  write(what, "0", error, text(std::abs(error), "%.2e"), bound, unit, note);
  EXPECT_LE(std::abs(error), bound) << what;
}

Curve reference(const std::string& name, double from, double to, const std::function<double(double)>& y) {
  Curve curve{name, CurveKind::reference};
  for (int i = 0; i <= 200; ++i) {
    const double x = from + (to - from) * i / 200;
    curve.add(x, y(x));
  }
  return curve;
}

void write_figure(const std::string& name, const std::string& x, const std::string& y,
                  const std::vector<Curve>& curves) {
  std::filesystem::create_directories(kRecords);
  std::ofstream file(kRecords / (name + ".figure.csv"));
  file << "curve,kind,\"" << x << "\",\"" << y << "\"\n";
  for (const Curve& curve : curves) {
    const size_t size = curve.points.size(), kept = std::min<size_t>(size, 200);
    for (size_t k = 0; k < kept; ++k) {
      const auto& point = curve.points[kept < 2 ? 0 : k * (size - 1) / (kept - 1)];
      file << '"' << curve.name << "\"," << (curve.kind == CurveKind::reference ? "reference" : "measured") << ','
           << text(point[0], "%.5g") << ',' << text(point[1], "%.5g") << '\n';
    }
  }
}

void EnergyCurves::add(const Model& m) {
  const Energies& e = m.step_sums.energies;
  work.add(m.stepping.time, e.external), kinetic.add(m.stepping.time, e.kinetic);
  lost.add(m.stepping.time, e.dissipated_total() + e.damping + e.contact_stored + e.strain + e.detection);
  sum.add(m.stepping.time, e.balance_error() + e.external);
}
void EnergyCurves::write(const std::string& figure) const {
  write_figure(figure, "time, s", "energy, J", {work, sum, kinetic, lost});
}

JointFamily joint(const std::string& law, std::vector<std::pair<std::string, double>> properties) {
  JointFamily f;
  f.name = law, f.law = law;
  for (const auto& [id, value] : properties) {
    PropertySetting s;
    s.id = id, s.numbers = {value};
    f.properties.push_back(s);
  }
  return f;
}
JointFamily elastic_joint(double kn, double ks) {
  return joint("elastic", {{"normal_stiffness", kn}, {"shear_stiffness", ks}});
}
JointFamily dry_joint(double kn, double ks, double angle) {
  JointFamily f = joint("coulomb_slip", {{"normal_stiffness", kn}, {"shear_stiffness", ks}, {"friction_angle", angle}});
  f.initial_state = "dry";
  return f;
}

JointFamily mortar(const std::string& initial_state) {
  JointFamily f = joint("fracture_energy", {{"normal_stiffness", 2e9},
                                            {"shear_stiffness", 1e9},
                                            {"tensile_strength", 0.05e6},
                                            {"cohesion", 0.08e6},
                                            {"friction_angle", 33},
                                            {"compressive_strength", 5e6},
                                            {"compressive_strength_residual", 2e6},
                                            {"fracture_energy_tension", 10.0},
                                            {"fracture_energy_shear", 30.0},
                                            {"fracture_energy_compression", 20000.0}});
  f.initial_state = initial_state;
  return f;
}

SolverSettings undamped(double fraction) {
  SolverSettings s;
  s.damping = DampingKind::none, s.time_step_fraction = fraction;
  return s;
}
SolverSettings local(double gamma, double fraction) {
  SolverSettings s;
  s.damping = DampingKind::local, s.local_damping = gamma, s.time_step_fraction = fraction;
  return s;
}
SolverSettings viscous(double mass, double stiffness, double fraction) {
  SolverSettings s;
  s.damping = DampingKind::viscous, s.mass_damping = mass, s.stiffness_damping = stiffness,
  s.time_step_fraction = fraction;
  return s;
}

Scene::Scene(JointFamily family, double density, double young, double poisson) {
  assembly.families.push_back(std::move(family));
  assembly.materials.push_back({"stone", young, poisson, density});
}
int Scene::brick(const Vector& lower, const Vector& size, bool fixed, const Quaternion& turn) {
  Block b;
  b.fixed = fixed, b.orientation = turn;
  if (turn.w == 1.0) return assembly.add(box(lower, size), b);
  // rotated about the origin
  return assembly.add(box(lower, size), b);
}
int Scene::block(const ConvexPolyhedron& shape, bool fixed) {
  Block b;
  b.fixed = fixed;
  return assembly.add(shape, b);
}
int Scene::soft(const Vector& lower, const Vector& size, std::array<int, 3> divisions) {
  Block b;
  b.rigid = false, b.divisions = divisions;
  return assembly.add(box(lower, size), b);
}

quoin::Scene scene_of(const std::string& toml) { return scene_of_text(toml); }

std::string stone_and_ground(double young_modulus) {
  return "[materials.stone]\nyoung_modulus = " + std::to_string(young_modulus) + R"(
poisson_ratio = 0.2
density = 1800.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 2e9
shear_stiffness = 1e9
friction_angle = 33.0
[solver]
kernels = "general"
damping = "viscous"
mass_damping = 0.3
stiffness_damping = 4e-5
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-20, -0.2, -20], size = [60, 0.2, 60] }
)";
}

void settle(Model& m, double ratio, long most) {
  double largest = 0.0;
  m.track_energy(true);
  for (long i = 0; i < most; ++i) {
    m.step();
    largest = std::max(largest, m.step_sums.energies.kinetic);
    if (i > 200 && i % 50 == 0 && m.step_sums.energies.kinetic < ratio * largest) return;
  }
}

}  // namespace quoin::verification
