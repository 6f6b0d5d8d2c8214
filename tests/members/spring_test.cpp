// Faces on ground springs, against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "model/world_results.h"
#include "scenes.h"

namespace quoin {
namespace {

using members_cases::box;

constexpr double kWidth = 1.0, kHeight = 1.2, kDepth = 0.5, kGravity = 9.81;
constexpr double kMass = 2000.0 * kWidth * kHeight * kDepth, kWeight = kMass * kGravity;

// Returns a block on springs only, and a stage.
Scene on_springs(const std::string& spring, const std::string& stage, const std::string& solver) {
  return read_scene_text(R"([materials.stone]
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 1e9
friction_angle = 30
[output]
frames = 0
plots = false
monitor = "block"
[solver]
)" + solver + box("block", "[-0.5, 0, 0]", "[1, 1.2, 0.5]") +
                             "[[spring]]\nname = \"soil\"\nblock = \"block\"\n" + spring +
                             "[[stage]]\ngravity = [0, -9.81, 0]\n" + stage,
                         "springs.toml");
}

const char* const kCalm = "damping = \"viscous\"\nmass_damping = 60.0\n";

struct Rest {
  double settled, tilt;  // m, rad
  std::vector<double> force;
};
Rest rest_of(const Scene& scene) {
  Simulation simulation(scene, 1);
  Observer nobody;
  simulation.run(nobody);
  const blocks::Model& m = *simulation.large_motion();
  return {start_position_of(m, 0).y - position_of(m, 0).y, std::asin(orientation_of(m, 0).row[0].y),
          m.held_by.members.get()->columns()};
}

// A point of stiffness 100 and 50 N/m, friction 0.5 and dashpots of 4 and 2 N s/m, in steps of 0.1 s, numbers by hand.
TEST(SpringLaw, SlipsAndDampsAndForgetsShearWhereItOpens) {
  members::SpringLaw law;
  law.normal = 100.0, law.shear = 50.0, law.friction = 0.5;
  const geometry::Vector down{0, -1, 0};
  members::SpringState s;
  const auto expect = [&](const geometry::Vector& force, double stored, double dissipated) {
    EXPECT_NEAR(norm(s.force - force), 0.0, 1e-12) << s.force.x << " " << s.force.y << " " << s.force.z;
    EXPECT_NEAR(s.stored, stored, 1e-12);
    EXPECT_NEAR(s.dissipated, dissipated, 1e-12);
  };
  s.follow(law, down, {0.01, -0.02, 0}, 0.1);  // pressed by 2 N, sheared by 0.5 N of 1 N
  expect({-0.5, 2.0, 0}, 0.5 * 2.0 * 0.02 + 0.5 * 0.5 * 0.01, 0.0);
  s.follow(law, down, {0.03, -0.02, 0.04}, 0.1);  // 2.5 N of shear slips to 1 N, along (3, 0, 4)
  expect({-0.6, 2.0, -0.8}, 0.02 + 0.5 * 1.0 / 50.0, 1.0 * 1.5 / 50.0);
  EXPECT_NEAR(norm(s.slid), 1.5 / 50.0, 1e-12);
  s.follow(law, down, {0.03, 0.01, 0.04}, 0.1);  // opens: the shear energy is lost
  expect({}, 0.0, 0.03 + 0.01);
  s.follow(law, down, {0.05, -0.02, 0.04}, 0.1);  // touches again: shear from where it was
  expect({-1.0, 2.0, 0}, 0.02 + 0.01, 0.04);
  law.normal_dashpot = 4.0, law.shear_dashpot = 2.0;
  s.follow(law, down, {0.05, -0.03, 0.045}, 0.1);  // 0.1 and 0.05 m/s
  expect({-1.0, 3.0 + 0.4, -0.25 - 0.1}, 0.5 * 3.0 * 0.03 + 0.5 * (1.0 + 0.25 * 0.25) / 50.0,
         0.04 + 0.4 * 0.01 + 0.1 * 0.005);
  s.follow(law, down, {0.05, -0.001, 0.045}, 0.1);  // leaves at 0.29 m/s: its dashpot does not pull
  EXPECT_EQ(s.force.y, 0.0);
  law.tension = 1, law.friction = std::numeric_limits<double>::infinity(), law.normal_dashpot = 0.0;
  s.follow(law, down, {0.05, 0.02, 0.045}, 0.1);
  EXPECT_NEAR(s.force.y, -2.0, 1e-12) << "with tension it pulls";
}

// Points of a face integrate areas and second moments exactly. The face has the outward normal +x here.
TEST(Springs, PointsOfAFaceHaveItsAreaAndMoments) {
  Simulation simulation(
      on_springs("normal = [1, 0, 0]\nnormal_stiffness = 4e7\nshear_stiffness = 2e7\nnormal_dashpot = 3e4\n"
                 "shear_dashpot = 2e4\nfriction_angle = 45\ndivisions = 3\n",
                 "duration = 0.1\n", kCalm),
      1);
  const members::Members& m = *simulation.large_motion()->held_by.members.get();
  const members::Bed& bed = m.beds().front();
  double area = 0.0, y = 0.0, yy = 0.0, zz = 0.0, yz = 0.0;
  for (const members::SpringPoint& p : bed.points) {
    const geometry::Vector at = m.nodes()[static_cast<std::size_t>(p.node)].start;
    EXPECT_NEAR(at.x, 0.5, 1e-12);
    EXPECT_NEAR(norm(p.out - geometry::Vector{1, 0, 0}), 0.0, 1e-12);
    area += p.area, y += p.area * at.y, yy += p.area * at.y * at.y, zz += p.area * at.z * at.z;
    yz += p.area * at.y * at.z;
    EXPECT_NEAR(p.law.normal, 4e7 * p.area, 1e-6);
    EXPECT_NEAR(p.law.shear, 2e7 * p.area, 1e-6);
    EXPECT_NEAR(p.law.normal_dashpot, 3e4 * p.area, 1e-9);
    EXPECT_NEAR(p.law.shear_dashpot, 2e4 * p.area, 1e-9);
    EXPECT_NEAR(p.law.friction, 1.0, 1e-12);
  }
  EXPECT_NEAR(area, kHeight * kDepth, 1e-12);
  EXPECT_NEAR(bed.area, kHeight * kDepth, 1e-12);
  EXPECT_NEAR(y, area * kHeight / 2, 1e-12);
  EXPECT_NEAR(yy, area * kHeight * kHeight / 3, 1e-12);
  EXPECT_NEAR(zz, area * kDepth * kDepth / 3, 1e-12);
  EXPECT_NEAR(yz, area * kHeight * kDepth / 4, 1e-12);
}

// u = W/(kn A); theta = F h/(kn I - W h/2), including the moment of the weight. The points are exact for linear
// pressures.
TEST(Springs, BlockSettlesAndTiltsAsItsFaceSays) {
  const double kn = 4e7, force = 600.0;
  const Rest rest = rest_of(on_springs("normal_stiffness = 4e7\nshear_stiffness = 2e7\ndivisions = 1\n",
                                       "ramp_time = 0.5\nduration = 3.0\n[[stage.force]]\nblock = \"block\"\n"
                                       "point = [0.5, 1.2, 0.25]\nforce = [600, 0, 0]\n",
                                       kCalm));
  const double area = kWidth * kDepth, second = kDepth * std::pow(kWidth, 3) / 12.0;
  EXPECT_NEAR(rest.settled / (kWeight / (kn * area)), 1.0, 1e-3);
  EXPECT_NEAR(rest.tilt / (force * kHeight / (kn * second - kWeight * kHeight / 2)), 1.0, 2e-3);
  EXPECT_NEAR(rest.force[0], -force, 1e-3 * force);
  EXPECT_NEAR(rest.force[1], kWeight, 1e-3 * kWeight);
}

// Without tension and with e = M/N above b/6 only a part x = 3 (b/2 - e) of the face has pressure: theta =
// 2 N/(kn d x^2). Tolerance 2 %, since the edge of this part is within one of the divisions of b/16.
TEST(Springs, FaceLiftsOffWithoutTension) {
  const double kn = 4e8;
  const std::string stage =
      "ramp_time = 0.5\nduration = 3.0\n[[stage.force]]\nblock = \"block\"\npoint = [0.5, 0.6, 0.25]\n"
      "force = [0, -12000, 0]\n";
  const Rest rest =
      rest_of(on_springs("normal_stiffness = 4e8\nshear_stiffness = 2e8\ndivisions = 16\n", stage, kCalm));
  const double pressing = kWeight + 12000.0, e = 12000.0 * 0.5 / pressing;
  ASSERT_GT(e, kWidth / 6);
  const double x = 3 * (kWidth / 2 - e), expected = 2 * pressing / (kn * kDepth * x * x);
  std::printf("  | lifted face: tilt %.4e, closed form %.4e\n", rest.tilt, expected);
  EXPECT_NEAR(rest.tilt / expected, 1.0, 0.02);
  // With tension the face does not lift off: theta = M/(kn I).
  const Rest bonded = rest_of(
      on_springs("normal_stiffness = 4e8\nshear_stiffness = 2e8\ndivisions = 1\ntension = true\n", stage, kCalm));
  EXPECT_NEAR(bonded.tilt / (12000.0 * 0.5 * 12 / (kn * kDepth)), 1.0, 5e-3);
}

// A horizontal force above friction moves the block without limit; one below does not.
TEST(Springs, FrictionHoldsUpToItsAngle) {
  const auto force = [](double share) {
    return rest_of(
               on_springs("normal_stiffness = 1e9\nshear_stiffness = 5e8\nfriction_angle = 30\n",
                          fmt::format("ramp_time = 0.5\nduration = 1.5\n[[stage.force]]\nblock = \"block\"\npoint = "
                                      "[0, 0.0, 0.25]\nforce = [{}, 0, 0]\n",
                                      share * std::tan(std::numbers::pi / 6) * kWeight),
                          kCalm))
        .force[0];
  };
  const double most = std::tan(std::numbers::pi / 6) * kWeight;
  EXPECT_NEAR(force(0.95), -0.95 * most, 1e-3 * most);
  EXPECT_NEAR(force(1.2), -most, 0.01 * most);
}

// A block dropped onto its springs: vertical vibration with xi = c/(2 sqrt(k m)). A peak over the position at rest is
// exp(-2 pi xi/sqrt(1 - xi^2)) of the one before. Energies balance.
TEST(Springs, DashpotsDampHeave) {
  const double kn = 4e7, k = kn * kWidth * kDepth, xi = 0.1, c = 2 * xi * std::sqrt(k * kMass) / (kWidth * kDepth);
  Simulation simulation(on_springs(fmt::format("normal_stiffness = 4e7\nshear_stiffness = 2e7\nnormal_dashpot = {}\n"
                                               "shear_dashpot = {}\ntension = true\n",
                                               c, c),
                                   "duration = 0.4\n", "damping = \"none\"\ntime_step_fraction = 0.1\n"),
                        1);
  const double omega = std::sqrt(k / kMass), still = kWeight / k;
  std::vector<double> troughs;
  double before = 0.0, last = 0.0;
  while (simulation.time() < 3.2 * 2 * std::numbers::pi / omega) {
    simulation.advance(1);
    const double now =
        start_position_of(*simulation.large_motion(), 0).y - position_of(*simulation.large_motion(), 0).y;
    if (last > before && last > now) troughs.push_back(last - still);
    before = last, last = now;
  }
  ASSERT_GE(troughs.size(), 3u);
  const double expected = std::exp(-2 * std::numbers::pi * xi / std::sqrt(1 - xi * xi));
  EXPECT_NEAR(troughs[1] / troughs[0] / expected, 1.0, 0.01);
  EXPECT_NEAR(troughs[2] / troughs[1] / expected, 1.0, 0.01);
  const Energies& e = simulation.large_motion()->step_sums.energies;
  EXPECT_LT(std::abs(e.balance_error()), 0.01 * e.external);
  EXPECT_GT(e.members_dissipated, 0.3 * e.external);
}

// The critical step c of a mass on dashpots alone, nearly: c^2 (K + 2 C/c) = 4, so c = 2/C for K = 0. It holds for
// rocking, which is stiffest: C = c_n I/I_0. The step is its fraction, whatever the dashpots are; the bound of springs
// in all directions is at most 3 times stiffer.
TEST(Springs, StepUnderDashpotsIsAFractionOfTheCriticalOne) {
  const auto step = [](double fraction, double dashpot) {
    return Simulation(
               on_springs(fmt::format("normal_stiffness = 1e4\nshear_stiffness = 1e4\nnormal_dashpot = {0}\n"
                                      "shear_dashpot = {0}\ntension = true\n",
                                      dashpot),
                          "duration = 0.4\n", fmt::format("damping = \"none\"\ntime_step_fraction = {}\n", fraction)),
               1)
        .time_step_report()
        .time_step;
  };
  const double dashpot = 1e6, whole = step(1.0, dashpot);
  for (const double fraction : {0.2, 0.5, 0.8}) EXPECT_NEAR(step(fraction, dashpot) / whole, fraction, 1e-9);
  EXPECT_NEAR(step(0.8, 2 * dashpot) / step(0.8, dashpot), 0.5, 0.02);
  const double heave = 2 * kMass / (dashpot * kWidth * kDepth);
  EXPECT_LT(whole, heave);
  EXPECT_GT(whole, heave / 12);
}

}  // namespace
}  // namespace quoin
