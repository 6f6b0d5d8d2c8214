// Natural frequencies against closed forms: a cube on a joint, Timoshenko's beam, a free block. The sparse solver
// against a full one.
#include "analysis/modes.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/error.h"
#include "scene/read_scene.h"
#include "step/simulation.h"

namespace quoin {
namespace {

using std::numbers::pi;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kMaterials =
    "title = \"t\"\n[materials.stone]\nyoung_modulus = 3e9\npoisson_ratio = 0.2\ndensity = 1800.0\n"
    "[joints.bond]\nlaw = \"elastic\"\nnormal_stiffness = 1e9\nshear_stiffness = 4e8\n"
    "[joints.dry]\nlaw = \"coulomb_slip\"\ninitial_state = \"dry\"\nnormal_stiffness = 1e9\nshear_stiffness = 4e8\n"
    "friction_angle = 35.0\n";
constexpr const char* kStage = "[[stage]]\nname = \"weight\"\ngravity = [0.0, -9.81, 0.0]\nduration = 0.1\n";

std::string box(const std::string& name, double y, const char* size, const char* more = "") {
  return fmt::format(
      "[[block]]\nname = \"{}\"\nmaterial = \"stone\"\nbox = {{ lower = [0.0, {}, 0.0], size = {} }}\n{}", name, y,
      size, more);
}

struct Found {
  Vibrating v;
  Modes modes;
};
Found modes_of(const std::string& text, const ModesSettings& settings = {}) {
  Found found{vibrating(read_scene_text(text, "test.toml")), {}};
  found.modes = find_modes(found.v, settings);
  return found;
}

// points: a table [contact]; without it the points are those that the joint has by default.
std::string cube(const char* joint, const char* points = "") {
  return std::string(kMaterials) + points + fmt::format("[[joint_rule]]\nfamily = \"{}\"\n", joint) +
         box("base", -1.0, "[1.0, 1.0, 1.0]", "fixed = true\n") + box("cube", 0.0, "[1.0, 1.0, 1.0]") + kStage;
}

// Slender beam fixed in a block: E I (1.8751/L)^2 and (4.6941/L)^2 over sqrt(E I m), each twice, since the section is
// square. Tolerance 1 %, for rotary inertia by the polar moment, and masses at 40 nodes, (h/L)^2.
TEST(Modes, BeamBuiltIntoABlock) {
  constexpr double kLength = 4.0, kModulus = 1e9, kArea = 0.01, kInertia = 1e-4 / 12, kDensity = 500.0;
  const std::string text =
      std::string(kMaterials) + "[[joint_rule]]\nfamily = \"dry\"\n" +
      box("base", -1.0, "[1.0, 2.0, 1.0]", "fixed = true\n") +
      fmt::format(
          "[[beam]]\nname = \"b\"\npoints = [[1.0, 0.5, 0.5], [{}, 0.5, 0.5]]\nspacing = 0.1\narea = {}\n"
          "young_modulus = {}\ndensity = {}\ninertia = [{}, {}]\ntorsion = {}\nsupport_stiffness = 1e11\n"
          "[[beam.support]]\nblock = \"base\"\npoint = [1.0, 0.5, 0.5]\nhold = \"built_in\"\n",
          1.0 + kLength, kArea, kModulus, kDensity, kInertia, kInertia, kInertia) +
      kStage;
  const Found found = modes_of(text);
  const double unit = std::sqrt(kModulus * kInertia / (kDensity * kArea)) / (2.0 * M_PI * kLength * kLength);
  ASSERT_GE(found.modes.mode.size(), 4u);
  for (int m = 0; m < 4; ++m) {
    const double root = m < 2 ? 1.875104 : 4.694091;
    EXPECT_NEAR(found.modes.mode[static_cast<std::size_t>(m)].frequency / (root * root * unit), 1.0, 0.01) << m;
  }
  EXPECT_NEAR(found.v.free_mass(1), kDensity * kArea * kLength, 0.02 * kDensity * kArea * kLength);
}

// Floor between two fixed walls, soft only in shear: c/(2 L) with c = sqrt(G/m). Tolerance 0.5 %, for 24 panels along
// it.
TEST(Modes, FloorIsAShearBeam) {
  constexpr double kLength = 6.0, kShear = 1e6, kMass = 100.0;  // m, N/m, kg/m2
  const std::string text =
      std::string(kMaterials) + "[[joint_rule]]\nfamily = \"dry\"\n" +
      "[[block]]\nname = \"left\"\nmaterial = \"stone\"\nfixed = true\nbox = { lower = [-1, 0, -1], size = [1, 1, 6] "
      "}\n"
      "[[block]]\nname = \"right\"\nmaterial = \"stone\"\nfixed = true\nbox = { lower = [6, 0, -1], size = [1, 1, 6] "
      "}\n" +
      fmt::format(
          "[[floor]]\nname = \"f\"\ncorner = [0, 0.5, 0]\nalong = [{}, 0, 0]\nacross = [0, 0, 4]\nspacing = 0.25\n"
          "axial_stiffness = [1e12, 1e12]\nshear_stiffness = {}\nmass = {}\nspan = \"along\"\n"
          "connector = {{ axial_stiffness = 1e12, shear_stiffness = 1e12 }}\n",
          kLength, kShear, kMass) +
      kStage;
  const Modes modes = modes_of(text).modes;
  ASSERT_FALSE(modes.mode.empty());
  EXPECT_NEAR(modes.mode[0].frequency / (std::sqrt(kShear / kMass) / (2.0 * kLength)), 1.0, 0.005);
  // Half sine: 8/pi^2 of the mass along z.
  EXPECT_NEAR(modes.mode[0].effective_mass[2] / (kMass * kLength * 4.0), 8.0 / (M_PI * M_PI), 0.01);
}

// REFERENCE_DYNAMICS 7. Sway and rocking are coupled, a problem of size 2; the other two modes are not. A dry joint is
// closed at the start and has the stiffness of a bonded one.
TEST(Modes, RigidCubeOnAJoint) {
  const double kn = 1e9, ks = 4e8, m = 1800.0, inertia = m / 6.0;
  // Unknowns: u at the centre, rotation; shear springs half a metre below, rotational stiffness kn/12.
  const double a = ks / m, b = (kn / 12.0 + ks / 4.0) / inertia, c = -0.5 * ks / std::sqrt(m * inertia);
  const double mean = (a + b) / 2.0, spread = std::hypot((a - b) / 2.0, c);
  const double sway = std::sqrt(mean - spread) / (2.0 * pi), rock = std::sqrt(mean + spread) / (2.0 * pi);
  const double twist = std::sqrt(ks / 6.0 / inertia) / (2.0 * pi), bounce = std::sqrt(kn / m) / (2.0 * pi);
  EXPECT_NEAR(sway, 45.624, 1e-3);
  EXPECT_NEAR(rock, 137.938, 1e-3);
  constexpr const char* kCubic = "[contact]\ncubic_points = true\n";
  for (const auto& [joint, points] : {std::pair("bond", ""), std::pair("bond", kCubic), std::pair("dry", kCubic)}) {
    const Modes modes = modes_of(cube(joint, points)).modes;
    ASSERT_EQ(modes.mode.size(), 6u);
    const double expected[] = {sway, sway, twist, bounce, rock, rock};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(modes.mode[i].frequency, expected[i], 1e-6 * expected[i]) << i;
    // Effective masses add up to the mass, in each direction.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      for (const Mode& mode : modes.mode) sum += mode.effective_mass[axis];
      EXPECT_NEAR(sum, m, 1e-6 * m);
    }
    EXPECT_NEAR(modes.mode[3].effective_mass[1], m, 1e-6 * m);
    EXPECT_NEAR(std::abs(modes.mode[3].participation[1]), 1.0, 1e-6);
    EXPECT_EQ(modes.zero, 0);
  }
}

// The top beam on one rigid unit that is held. Sway and rocking are coupled: the centre of mass is load_height - 0.1
// above the joint, where load_height was left out.
TEST(Modes, BeamHasItsCentreAtTheLoadHeight) {
  const double kn = 1e9, ks = 4e8, x = 0.4, z = 0.2, h = 0.5, area = x * z;
  const double m = 2000.0 * x * h * z, inertia = m * (x * x + h * h) / 12.0;
  for (const double height : {0.35, 1.0}) {
    const Modes modes = modes_of(std::string(kMaterials) + R"([wall]
courses = 1
units_per_course = 1
bond = "stack"
unit = [0.4, 0.1, 0.2]
rigid_units = true
mid_unit_joints = false
bottom_beam = false
beam_height = 0.5
beam_density = 2000.0
unit_material = "stone"
bed_joint = "bond"
head_joint = "bond"
beam_joint = "bond"
)" + fmt::format("load_height = {}\n", height) +
                                 R"([[stage]]
kind = "custom"
duration = 1.0
[[stage.control]]
body = "bottom_course"
[solver]
large_motion = "never"
)")
                            .modes;
    const double arm = height - 0.1, a = ks * area / m,
                 b = (kn * area * x * x / 12.0 + ks * area * arm * arm) / inertia;
    const double c = -arm * ks * area / std::sqrt(m * inertia);
    const double mean = (a + b) / 2.0, spread = std::hypot((a - b) / 2.0, c);
    ASSERT_EQ(modes.mode.size(), 6u);
    for (const double square : {mean - spread, mean + spread, kn * area / m}) {
      const double expected = std::sqrt(square) / (2.0 * pi);
      EXPECT_TRUE(std::ranges::any_of(
          modes.mode, [&](const Mode& mode) { return std::abs(mode.frequency - expected) < 1e-6 * expected; }))
          << height << " m: " << expected << " Hz";
    }
  }
}

// Points only at corners, as dry joints have by default: rotational stiffness kn/4 in place of kn/12.
TEST(Modes, RigidCubeOnItsCorners) {
  const double kn = 1e9, ks = 4e8, m = 1800.0, inertia = m / 6.0;
  const double a = ks / m, b = (kn / 4.0 + ks / 4.0) / inertia, c = -0.5 * ks / std::sqrt(m * inertia);
  const double mean = (a + b) / 2.0, spread = std::hypot((a - b) / 2.0, c);
  for (const auto& [joint, points] : {std::pair("dry", ""), std::pair("bond", "[contact]\ncubic_points = false\n")}) {
    const Modes modes = modes_of(cube(joint, points)).modes;
    ASSERT_EQ(modes.mode.size(), 6u);
    for (const auto& [i, w2] : {std::pair(0u, mean - spread), std::pair(5u, mean + spread)})
      EXPECT_NEAR(modes.mode[i].frequency, std::sqrt(w2) / (2.0 * pi), 1e-6 * modes.mode[i].frequency) << joint;
  }
}

// Returns both frequencies of sway and rocking of the cube in one plane, Hz. Stiffness of its base, N/m and N m, and of
// a side face, along x and about the face's centre.
std::array<double, 2> sway_and_rock(double along, double turning, double beside, double beside_turning) {
  const double m = 1800.0, inertia = m / 6.0;
  const double a = (along + beside) / m, b = (turning + along / 4.0 + beside_turning) / inertia;
  const double c = -0.5 * along / std::sqrt(m * inertia);
  const double mean = (a + b) / 2.0, spread = std::hypot((a - b) / 2.0, c);
  return {std::sqrt(mean - spread) / (2.0 * pi), std::sqrt(mean + spread) / (2.0 * pi)};
}

void expect_frequencies(const std::string& text, std::vector<double> expected) {
  const Modes modes = modes_of(text).modes;
  ASSERT_EQ(modes.mode.size(), expected.size());
  std::sort(expected.begin(), expected.end());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(modes.mode[i].frequency, expected[i], 1e-6 * expected[i]) << i;
}

// A dowel through the centre of the joint adds shear stiffness to sway and axial stiffness to bounce, and none to
// rotation.
TEST(Modes, DowelStiffensTheJointOfACube) {
  const double kn = 1e9, ks = 4e8, m = 1800.0, axial = 7e8, shear = 3e8;
  const auto [sway, rock] = sway_and_rock(ks + shear, kn / 12.0, 0.0, 0.0);
  expect_frequencies(
      cube("bond") + fmt::format("[[dowel]]\npoint = [0.5, 0.0, 0.5]\ndirection = [0, 1, 0]\naxial_stiffness = {}\n"
                                 "shear_stiffness = {}\nyield_force = 1e4\nyield_shear = 1e4\n",
                                 axial, shear),
      {sway, sway, rock, rock, std::sqrt((kn + axial) / m) / (2.0 * pi), std::sqrt(ks / m) / (2.0 * pi)});
}

// Soil on one side of the cube acts along x only: sway and rocking in x-y, and twisting, become stiffer. Its points
// integrate k u over the face exactly.
TEST(Modes, SoilStiffensOneSideOfACube) {
  const double kn = 1e9, ks = 4e8, m = 1800.0, soil = 5e8;
  const auto [sway, rock] = sway_and_rock(ks, kn / 12.0, soil, soil / 12.0);
  const auto [free_sway, free_rock] = sway_and_rock(ks, kn / 12.0, 0.0, 0.0);
  const double twist = std::sqrt((ks / 6.0 + soil / 12.0) / (m / 6.0)) / (2.0 * pi);
  expect_frequencies(cube("bond") + fmt::format("[[fill]]\nblock = \"cube\"\ntowards = [1, 0, 0]\nsurface = [0, 2, "
                                                "0]\nunit_weight = 18e3\nfriction_angle = 30\nstiffness = {}\n",
                                                soil),
                     {sway, rock, free_sway, free_rock, twist, std::sqrt(kn / m) / (2.0 * pi)});
}

// A mass of 900 kg at 1.5 m above the joint, outside of the cube. Sway, rocking, twisting and bounce are those of the
// whole, with its centre of mass and Steiner's theorem. A mass distributed over the cube is an additional density.
TEST(Modes, ACubeThatCarriesAMass) {
  const double kn = 1e9, ks = 4e8, own = 1800.0, added = 900.0, m = own + added;
  const double centre = (0.5 * own + 1.5 * added) / m;  // m over the joint
  const double inertia = own / 6.0 + own * (centre - 0.5) * (centre - 0.5) + added * (1.5 - centre) * (1.5 - centre);
  const double a = ks / m, b = (kn / 12.0 + ks * centre * centre) / inertia, c = -ks * centre / std::sqrt(m * inertia);
  const double mean = (a + b) / 2.0, spread = std::hypot((a - b) / 2.0, c);
  const double sway = std::sqrt(mean - spread) / (2.0 * pi), rock = std::sqrt(mean + spread) / (2.0 * pi);
  const double bounce = std::sqrt(kn / m) / (2.0 * pi), twist = std::sqrt(ks / own) / (2.0 * pi);
  const std::string mass = "[[mass]]\nblock = \"cube\"\nmass = 900.0\n";
  const Modes above = modes_of(cube("bond") + mass + "point = [0.5, 1.5, 0.5]\n").modes;
  ASSERT_EQ(above.mode.size(), 6u);
  std::vector<double> expected{sway, sway, rock, rock, bounce, twist};
  std::sort(expected.begin(), expected.end());
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(above.mode[i].frequency, expected[i], 1e-6 * expected[i]) << i;
  double sum = 0.0;
  for (const Mode& mode : above.mode) sum += mode.effective_mass[0];
  EXPECT_NEAR(sum, m, 1e-6 * m);

  const Modes spread_out = modes_of(cube("bond") + mass).modes, without = modes_of(cube("bond")).modes;
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(spread_out.mode[i].frequency, std::sqrt(own / m) * without.mode[i].frequency, 1e-3) << i;
}

TEST(Modes, RayleighGivesBothRatios) {
  const Rayleigh r = rayleigh({2.0, 9.0}, {0.05, 0.02});
  for (const auto& [f, ratio] : {std::pair(2.0, 0.05), std::pair(9.0, 0.02)}) {
    const double w = 2.0 * pi * f;
    EXPECT_NEAR(0.5 * (r.mass_damping / w + r.stiffness_damping * w), ratio, 1e-12);
  }
}

// One of two coefficients below 0 would be amplification at some frequencies.
TEST(Modes, RatiosThatNeedANegativeCoefficientAreRefused) {
  const auto refusal = [](std::array<double, 2> frequencies, std::array<double, 2> ratios) {
    try {
      rayleigh(frequencies, ratios);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal({2.0, 9.0}, {0.05, 0.01}), HasSubstr("may differ by a factor of 4.5 at most"));
  EXPECT_THAT(refusal({2.0, 9.0}, {0.01, 0.05}), HasSubstr("none may be negative"));
  EXPECT_THAT(refusal({2.0, 2.0}, {0.01, 0.05}), HasSubstr("both at 2 Hz"));
  EXPECT_EQ(refusal({2.0, 9.0}, {0.01, 0.045}), "");
  const Rayleigh rising = rayleigh({2.0, 9.0}, {0.05, 0.02}), falling = rayleigh({9.0, 2.0}, {0.02, 0.05});
  EXPECT_NEAR(falling.mass_damping, rising.mass_damping, 1e-12);
  EXPECT_NEAR(falling.stiffness_damping, rising.stiffness_damping, 1e-15);
}

TEST(Modes, AFreeBlockMovesInSixWaysWithoutStiffness) {
  const Found rigid = modes_of(std::string(kMaterials) + "[[joint_rule]]\nfamily = \"dry\"\n" +
                               box("ground", -5.0, "[1.0, 1.0, 1.0]", "fixed = true\n") +
                               box("alone", 0.0, "[1.0, 1.0, 1.0]") + kStage);
  EXPECT_EQ(rigid.modes.mode.size(), 6u);
  EXPECT_EQ(rigid.modes.zero, 6);
  EXPECT_THAT(rigid.modes.loose, ElementsAre(1));
  const nlohmann::ordered_json json = json_of("s", rigid.v, rigid.modes);
  EXPECT_EQ(json["zero_modes"], 6);
  EXPECT_THAT(json["loose_blocks"][0].get<std::string>(), HasSubstr("alone"));
  EXPECT_EQ(json["frequencies_Hz"][5], 0.0);

  // Deformable, and too large for a full matrix.
  ModesSettings settings;
  settings.count = 8;
  const Found soft =
      modes_of(std::string(kMaterials) + "[[joint_rule]]\nfamily = \"dry\"\n" +
                   box("ground", -5.0, "[1.0, 1.0, 1.0]", "fixed = true\n") +
                   box("alone", 0.0, "[1.0, 1.0, 1.0]", "rigid = false\ndivisions = [5, 5, 5]\n") + kStage,
               settings);
  EXPECT_GT(soft.modes.factor_entries, 0.0);
  EXPECT_EQ(soft.modes.zero, 6);
  EXPECT_GT(soft.modes.mode[6].frequency, 100.0);
}

TEST(Modes, NothingThatMovesIsRefused) {
  const std::string text = std::string(kMaterials) + "[[joint_rule]]\nfamily = \"dry\"\n" +
                           box("ground", -5.0, "[1.0, 1.0, 1.0]", "fixed = true\n") + kStage;
  EXPECT_THROW(modes_of(text), Error);
  ModesSettings settings;
  settings.ratios = {1.5, 0.0};
  EXPECT_THROW(modes_of(cube("bond"), settings), Error);
}

// Cantilever by Timoshenko (1921), with rotary inertia: roots of the determinant of clamped and free end. bending: EI,
// N m2; shear: kappa GA, N; mass: kg/m; rotary: inertia j, kg m; length: m.
struct Beam {
  double bending, shear, mass, rotary, length;
};
double determinant(const Beam& beam, double w) {
  // u: displacement, t: rotation. shear (u' - t)' + mass w2 u = 0, bending t'' + shear (u' - t) + rotary w2 t = 0.
  // Integrated from the clamped end for two initial states by the Runge-Kutta method of fourth order.
  using State = std::array<double, 4>;  // u, t, bending moment, shear force
  const auto slope = [&](const State& y) {
    return State{y[3] / beam.shear + y[1], y[2] / beam.bending, -y[3] - beam.rotary * w * w * y[1],
                 -beam.mass * w * w * y[0]};
  };
  const auto at_tip = [&](State y) {
    constexpr int kSteps = 400;
    const double h = beam.length / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      State k[4], at = y;
      for (int s = 0; s < 4; ++s) {
        k[s] = slope(at);
        for (std::size_t c = 0; c < 4; ++c) at[c] = y[c] + (s < 2 ? 0.5 : 1.0) * h * k[s][c];
      }
      for (std::size_t c = 0; c < 4; ++c) y[c] += h / 6.0 * (k[0][c] + 2.0 * k[1][c] + 2.0 * k[2][c] + k[3][c]);
    }
    return y;
  };
  const State by_moment = at_tip({0.0, 0.0, 1.0, 0.0}), by_force = at_tip({0.0, 0.0, 0.0, 1.0});
  return by_moment[2] * by_force[3] - by_moment[3] * by_force[2];
}
std::vector<double> frequencies_of(const Beam& beam, int count) {
  std::vector<double> found;
  const double scale = std::sqrt(beam.bending / beam.mass) / (beam.length * beam.length);
  double low = 0.05 * scale, at_low = determinant(beam, low);
  for (double high = low; static_cast<int>(found.size()) < count; low = high, at_low = determinant(beam, low)) {
    high = low + 0.1 * scale;
    if ((determinant(beam, high) > 0.0) == (at_low > 0.0)) continue;
    double a = low, b = high;
    for (int i = 0; i < 60; ++i) ((determinant(beam, 0.5 * (a + b)) > 0.0) == (at_low > 0.0) ? a : b) = 0.5 * (a + b);
    found.push_back(a / (2.0 * pi));
  }
  return found;
}

TEST(Modes, TheTestsBeamIsEulersWhereItIsSlender) {
  const Beam slender{1.0, 1e9, 1.0, 0.0, 1.0};
  EXPECT_NEAR(2.0 * pi * frequencies_of(slender, 2)[0], 3.51602, 1e-4);
  EXPECT_NEAR(2.0 * pi * frequencies_of(slender, 2)[1], 22.0345, 1e-3);
}

// A pillar of 40 rigid blocks of 0.5 x 0.1 x 0.3 m, with joints exact in bending. It is a beam with EI = kn h I and
// kappa GA = ks h A. Tolerance 1 %, for 40 blocks in place of a continuum.
TEST(Modes, PillarOfRigidBlocksIsTimoshenkosBeam) {
  constexpr int kBlocks = 40;
  constexpr double h = 0.1, kn = 1e9, ks = 4e8, density = 1800.0;
  std::string text = std::string(kMaterials) +
                     "[joints.foot]\nlaw = \"elastic\"\nnormal_stiffness = 2e9\n"
                     "shear_stiffness = 8e8\n[[joint_rule]]\nfamily = \"foot\"\nbetween = [\"base\", \"\"]\n"
                     "[[joint_rule]]\nfamily = \"bond\"\n" +
                     box("base", -h, "[0.5, 0.1, 0.3]", "fixed = true\n");
  for (int i = 0; i < kBlocks; ++i) text += box(fmt::format("b{}", i), i * h, "[0.5, 0.1, 0.3]");
  const Modes modes = modes_of(text + kStage).modes;
  // Bending about x and about z.
  std::vector<double> expected;
  for (const auto& [width, depth] : {std::pair(0.5, 0.3), std::pair(0.3, 0.5)}) {
    const double area = width * depth, second = depth * width * width * width / 12.0;
    const Beam beam{kn * h * second, ks * h * area, density * area, density * (second + area * h * h / 12.0),
                    kBlocks * h};
    for (const double f : frequencies_of(beam, 3)) expected.push_back(f);
  }
  std::sort(expected.begin(), expected.end());
  // Bending modes are those that a ground motion along x or z excites.
  std::vector<double> bending;
  for (const Mode& mode : modes.mode)
    if (mode.effective_mass[0] + mode.effective_mass[2] > 1.0) bending.push_back(mode.frequency);
  ASSERT_GE(bending.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(bending[i], expected[i], 0.002 * expected[i]) << i;
}

// A wall in running bond, 0.8 x 4 m, of deformable half units, in its plane. Joints are in series with units:
//   1/E' = 1/E + 1/(kn h), 1/G' = 1/G + 1/(ks h) + 1/(ks l).
// The last term, with l the length of a half unit, is that of head joints, which transfer shear, too.
// Tolerance 2 %, for zones of constant strain and Timoshenko's shear coefficient.
// Half of its thickness has the same modes in the plane. Along z the other half moves against it: no mode is excited.
TEST(Modes, SolidWallIsTimoshenkosBeam) {
  constexpr double E = 3e9, G = 1.25e9, kn = 20e9, ks = 8e9, h = 0.1, l = 0.2, width = 0.8, depth = 0.2,
                   density = 1800.0;
  std::string text =
      "title = \"t\"\n[materials.stone]\nyoung_modulus = 3e9\npoisson_ratio = 0.2\ndensity = "
      "1800.0\n[joints.bond]\nlaw = "
      "\"elastic\"\nnormal_stiffness = 20e9\nshear_stiffness = 8e9\n[wall]\nbond = \"running\"\ncourses = 40\n"
      "units_per_course = 2\nunit = [0.4, 0.1, 0.2]\nzones = [3, 2, 2]\nunit_material = \"stone\"\nbed_joint = "
      "\"bond\"\n"
      "head_joint = \"bond\"\nunit_joint = \"bond\"\nbeam_joint = \"bond\"\ntop_beam = false\n"
      "[[stage]]\nname = \"weight\"\nkind = \"custom\"\ngravity = [0.0, -9.81, 0.0]\nduration = 0.1\n"
      "[[stage.control]]\nbody = \"bottom_beam\"\n";
  const auto mode_in_plane = [&](const std::string& scene) {
    const Modes modes = modes_of(scene).modes;
    const auto found = std::find_if(modes.mode.begin(), modes.mode.end(),
                                    [](const Mode& mode) { return mode.effective_mass[0] > 0.3 * density * 0.64; });
    EXPECT_NE(found, modes.mode.end());
    double along_z = 0.0;
    for (const Mode& mode : modes.mode) along_z += mode.effective_mass[2];
    return std::pair(found == modes.mode.end() ? Mode() : *found, along_z);
  };
  const auto [in_plane, along_z] = mode_in_plane(text);
  const double area = width * depth, second = depth * width * width * width / 12.0;
  const double young = 1.0 / (1.0 / E + 1.0 / (kn * h)), shear = 1.0 / (1.0 / G + 1.0 / (ks * h) + 1.0 / (ks * l));
  const Beam beam{young * second, 5.0 / 6.0 * shear * area, density * area, density * second, 4.0};
  const double expected = frequencies_of(beam, 1)[0];
  EXPECT_NEAR(in_plane.frequency, expected, 0.02 * expected);
  EXPECT_GT(along_z, 0.5 * density * area * 4.0);

  text.replace(text.find("bond = "), 0, "half_thickness = true\n");
  const auto [of_half, half_along_z] = mode_in_plane(text);
  EXPECT_NEAR(of_half.frequency, in_plane.frequency, 1e-3 * in_plane.frequency);
  EXPECT_NEAR(of_half.effective_mass[0], in_plane.effective_mass[0], 1e-3 * in_plane.effective_mass[0]);
  EXPECT_EQ(half_along_z, 0.0);
}

struct Top : Observer {
  void on_row(const HistoryRow& row) override {
    time.push_back(row.time), displacement.push_back(row.monitor_displacement[0]);
  }
  std::vector<double> time, displacement;
};

// Returns the frequency about the mean of the largest and smallest displacement, Hz.
double frequency_of(const Top& top) {
  const auto [least, most] = std::minmax_element(top.displacement.begin(), top.displacement.end());
  const double middle = 0.5 * (*least + *most);
  std::vector<double> outwards;  // times of outward passages through the mean, s
  for (std::size_t i = 1; i < top.time.size(); ++i) {
    const double before = top.displacement[i - 1] - middle, now = top.displacement[i] - middle;
    if (before < 0.0 && now >= 0.0)
      outwards.push_back(top.time[i] - (top.time[i] - top.time[i - 1]) * now / (now - before));
  }
  return static_cast<double>(outwards.size() - 1) / (outwards.back() - outwards.front());
}

// This wall of whole units, without damping, under a sudden horizontal body force. It vibrates about its static
// deflection, mainly in its first mode. Compares the run with quoin modes (1 %, for higher modes) and with Timoshenko's
// beam (2 %). Rigid units have the points of bonded joints by default.
TEST(Modes, ASolidWallSwingsAtItsFirstFrequency) {
  constexpr double kn = 20e9, ks = 8e9, h = 0.1, l = 0.4, width = 0.8, depth = 0.2, density = 1800.0, height = 4.0;
  for (const bool rigid : {false, true}) {
    const std::string text =
        "[solver]\ndamping = \"none\"\n[materials.stone]\nyoung_modulus = 3e9\npoisson_ratio = 0.2\ndensity = 1800.0\n"
        "[joints.bond]\nlaw = \"elastic\"\nnormal_stiffness = 20e9\nshear_stiffness = 8e9\n" +
        box("base", -0.2, "[0.8, 0.2, 0.2]", "fixed = true\n") +
        "[[dry_wall]]\nname = \"wall\"\nmaterial = \"stone\"\ncourses = 40\nunits_per_course = 2\n"
        "unit = [0.4, 0.1, 0.2]\n" +
        (rigid ? "" : "rigid = false\nzones = [3, 2, 2]\n") +
        "[[stage]]\nname = \"swing\"\ngravity = [0.5, 0.0, 0.0]\nduration = 0.4\n"
        "[output]\nmonitor = \"wall/39/0\"\nrecord_interval = 5e-4\nframes = 0\nenergy = false\n";
    const Modes modes = modes_of(text).modes;
    const auto in_plane = std::find_if(modes.mode.begin(), modes.mode.end(),
                                       [](const Mode& mode) { return mode.effective_mass[0] > 0.3 * density * 0.64; });
    ASSERT_NE(in_plane, modes.mode.end());
    Simulation simulation(read_scene_text(text, "swing.toml"), 1);
    Top top;
    simulation.run(top);
    const double swings = frequency_of(top);

    const double units = rigid ? 0.0 : 1.0, area = width * depth, second = depth * width * width * width / 12.0;
    const double young = 1.0 / (units / 3e9 + 1.0 / (kn * h));
    const double shear = 1.0 / (units / 1.25e9 + 1.0 / (ks * h) + 1.0 / (ks * l));
    const Beam beam{young * second, 5.0 / 6.0 * shear * area, density * area, density * second, height};
    const double expected = frequencies_of(beam, 1)[0];
    std::printf("%s units: modes %.3f, run %.3f, Timoshenko %.3f Hz\n", rigid ? "rigid" : "deformable",
                in_plane->frequency, swings, expected);
    EXPECT_NEAR(swings, in_plane->frequency, 0.01 * in_plane->frequency);
    EXPECT_NEAR(swings, expected, 0.02 * expected);
  }
}

// All eigenvalues by a full solver. The sparse solver misses none, and its error is rounding of the highest frequency,
// 1e-16 of its square. A plate with equal sides has equal frequencies. More than 120 modes of a wall were "not
// settled".
TEST(Modes, SparseSolverAgreesWithAFullOne) {
  std::string text = std::string(kMaterials) + "[[joint_rule]]\nfamily = \"bond\"\n";
  for (int i = 0; i < 4; ++i)
    text += box(fmt::format("b{}", i), 0.5 * i, "[0.5, 0.5, 0.5]",
                i == 0 ? "fixed = true\n" : "rigid = false\ndivisions = [4, 4, 4]\n");
  ModesSettings settings;
  settings.count = 250;
  const Found found = modes_of(text + kStage, settings);
  const Eigen::MatrixXd lower = found.v.stiffness;
  const Eigen::MatrixXd full = lower.selfadjointView<Eigen::Lower>();
  const Eigen::Map<const Eigen::VectorXd> mass(found.v.mass.data(), full.rows());
  const Eigen::VectorXd scale = mass.cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * full * scale.asDiagonal(),
                                                             Eigen::EigenvaluesOnly);
  ASSERT_GT(full.rows(), 1000);
  for (int i = 0; i < settings.count; ++i) {
    const double expected = std::sqrt(eigen.eigenvalues()(i)) / (2.0 * pi);
    EXPECT_NEAR(found.modes.mode[static_cast<std::size_t>(i)].frequency, expected, 1e-7 * expected) << i;
  }
}

}  // namespace
}  // namespace quoin
