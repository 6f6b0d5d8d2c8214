// Ground motion against the polynomials to which a piecewise linear record integrates. Blocks on the ground against
// Newton's law.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

// Piecewise linear acceleration at unequal times, whose parts do not cancel. At its end the ground has 0.31 m/s.
const std::vector<double> kTime{0.0, 0.07, 0.1, 0.18, 0.23}, kAcceleration{1.0, 4.0, -2.0, 3.0, 0.0};

// Returns the displacement of the ground at time t of its stage, m: u + v h + a h^2/2 + a' h^3/6 between two times.
double way(double t) {
  double u = 0.0, v = 0.0;
  for (std::size_t i = 0; i + 1 < kTime.size() && kTime[i] < t; ++i) {
    const double a = kAcceleration[i], rate = (kAcceleration[i + 1] - a) / (kTime[i + 1] - kTime[i]);
    const double h = std::min(t, kTime[i + 1]) - kTime[i];
    u += v * h + a * h * h / 2 + rate * h * h * h / 6;
    v += a * h + rate * h * h / 2;
  }
  return u + v * std::max(0.0, t - kTime.back());
}

// A block on the ground, with an elastic joint of 1e6 N/m that carries tension, and a second block without contacts;
// 2 kg each.
std::string scene(const std::string& of_ground, const std::string& stages) {
  return undamped_stone("general") + R"(
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-1, -0.1, -1], size = [2, 0.1, 2] }
)" + of_ground +
         R"(
[[block]]
name = "rider"
material = "stone"
box = { lower = [0, 0, 0], size = [0.1, 0.1, 0.1] }
[[block]]
name = "bird"
material = "stone"
box = { lower = [0, 3, 0], size = [0.1, 0.1, 0.1] }
)" + stages;
}

// The sum of velocities at half steps is the integral up to dt^2/24 times the change of the acceleration. With dt =
// 3e-5 s and changes of 6 m/s2 that is 1e-9 m. An error of half a step would be 5e-6 m, and of the rectangle rule
// centimetres. Direction [2, -3, 6] has length 7, which must not scale the motion.
class MovingGround : public ::testing::TestWithParam<const char*> {};

TEST_P(MovingGround, IsTheDoubleIntegralOfTheRecordAtEveryStep) {
  const Scene moving = read_scene_text(scene(GetParam(), R"(
[[stage]]
name = "wait"
duration = 0.0137
[[stage]]
name = "shake"
duration = 0.3
ground_motion = { direction = [2, -3, 6], time = [0, 0.07, 0.1, 0.18, 0.23], acceleration = [1, 4, -2, 3, 0] }
)"),
                                       "ground.toml", {"solver.time_step_fraction=0.02"});
  Simulation simulation(moving);
  Observer nobody;
  ASSERT_TRUE(simulation.run_stage(nobody));
  const double begin = simulation.time(), dt = simulation.time_step_report().time_step;
  ASSERT_LT(dt, 1e-4);
  const auto expect_at_rest = [&](int block) {
    for (const Vec3& u : block_displacement(simulation, block)) EXPECT_LT(std::hypot(u[0], u[1], u[2]), 1e-14) << block;
  };
  expect_at_rest(0);
  double fastest = 0.0;
  std::vector<std::uint8_t> half_way;
  for (bool more = true; more;) {
    more = simulation.run_stage(nobody, 101);
    if (half_way.empty() && simulation.time() > begin + 0.15) half_way = simulation.save();
    const double t = simulation.time() - begin, expected = way(t);
    const Vec3 axis{2.0 / 7, -3.0 / 7, 6.0 / 7};
    for (const Vec3& u : block_displacement(simulation, 0)) {
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(u[c], axis[c] * expected, 6.0 * dt * dt) << c << " at " << t;
    }
    fastest = std::max(fastest, (way(t + dt) - expected) / dt);
  }
  EXPECT_GT(fastest, 0.3);
  EXPECT_GT(dt * fastest / 2, 100 * 6.0 * dt * dt) << "half a step late must be seen";
  expect_at_rest(2);  // the block without contacts
  Simulation resumed(moving, 2);
  resumed.restore(half_way);
  resumed.run(nobody);
  EXPECT_EQ(resumed.hash(), simulation.hash()) << "a record goes on where it was left";
}

INSTANTIATE_TEST_SUITE_P(Grounds, MovingGround, ::testing::Values("", "rigid = false\ndivisions = [2, 1, 2]"),
                         [](const auto& of) { return std::string(*of.param ? "Zones" : "Rigid"); });

// The ground rises with constant acceleration a under a mass on a spring. Relative to the ground the mass has the
// weight m a and vibrates about m a/k by -(a/w^2) (1 - cos w t). Steps of a hundredth of a period have an error of (w
// dt)^2/24 of w, 2e-4 over three periods. The work of the ground balances the energies.
TEST(GroundMotion, AMassOnASpringLagsBehindByItsInertia) {
  const Scene moving = read_scene_text(scene("", R"(
[[stage]]
name = "rise"
duration = 0.03
ground_motion = { direction = [0, 1, 0], time = [0, 1], acceleration = [5, 5] }
[output]
energy = true
)"),
                                       "ground.toml", {"solver.time_step_fraction=0.03"});
  Simulation simulation(moving);
  Observer nobody;
  const double frequency = std::sqrt(1e8 * 0.01 / 2.0), swing = 5.0 / (frequency * frequency);
  double largest = 0.0;
  for (bool more = true; more;) {
    more = simulation.run_stage(nobody, 7);
    const double t = simulation.time();
    const double lag = block_displacement(simulation, 1)[0][1] - block_displacement(simulation, 0)[0][1];
    EXPECT_NEAR(lag, -swing * (1 - std::cos(frequency * t)), 5e-3 * swing) << t;
    largest = std::max(largest, -lag);
  }
  EXPECT_NEAR(largest, 2 * swing, 0.02 * swing);
  simulation.advance(1);
  const Energies e = *simulation.measure().energies;
  EXPECT_GT(e.external, 0.5 * 2.0 * 0.1 * 0.1);  // 2 kg at about 0.15 m/s
  EXPECT_NEAR(e.balance_error(), 0.0, 1e-3 * e.external);
}

// Impact damping has a state: the tractions of the last step and the share of damping in use. A run resumed in the
// middle of a pulse is bitwise identical.
TEST(GroundMotion, DampingOfImpactsGoesOnWhereItWasLeft) {
  const Scene shaken = read_scene(
      QUOIN_SCENES "/facade.toml",
      {"stage.weight.duration=0.05", "stage.earthquake.duration=0.3",
       "stage.earthquake.ground_motion={direction=[1, 0, 0], pulse={shape='sine', amplitude=20, period=0.3}}"});
  Simulation simulation(shaken);
  Observer nobody;
  ASSERT_TRUE(simulation.run_stage(nobody));
  ASSERT_TRUE(simulation.run_stage(nobody, 700));
  ASSERT_GT(impact_damping_in_use(*simulation.large_motion()), 0.0);
  const std::vector<std::uint8_t> half_way = simulation.save();
  simulation.run(nobody);
  Simulation resumed(shaken, 2);
  resumed.restore(half_way);
  resumed.run(nobody);
  EXPECT_EQ(resumed.hash(), simulation.hash());
  EXPECT_EQ(impact_damping_in_use(*resumed.large_motion()), impact_damping_in_use(*simulation.large_motion()));
}

}  // namespace
}  // namespace quoin
