// Faults that testers found from outside, of the ground and its supports. Each of these scenes gave another result,
// without a word.
#include <fmt/format.h>

#include <cmath>

#include "members/members.h"
#include "outside.h"

namespace quoin::verification {
namespace {

// A block on springs of the ground, tied to a fixed block that is a support with a motion of its own. The tie is in
// series with the springs, sideways and in rotation. So F = u/(1/k + 1/k_s + h^2/(k_n b^2/12 - W h)), with h = b = 1 m.
// The ground moved with the first support of the file, and the force was 0.002 of that.
TEST(OutsideGround, ASupportIsNotTheGround) {
  const std::string support = R"([[block]]
name = "support"
material = "stone"
fixed = true
box = { lower = [3, 0, 0], size = [1, 2, 1] }
)";
  const std::string other = R"([[block]]
name = "other"
material = "stone"
fixed = true
box = { lower = [9, 0, 0], size = [1, 2, 1] }
)";
  const std::string rest = R"([[block]]
name = "block"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 2, 1] }
[[spring]]
name = "soil"
block = "block"
normal_stiffness = 1e7
shear_stiffness = 1e7
tension = true
[[tie]]
name = "tie"
from = { block = "block", point = [1, 1, 0.5] }
to = { block = "support", point = [3, 1, 0.5] }
area = 1e-5
young_modulus = 2e11
yield_stress = 1e9
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
ramp_time = 0.2
duration = 0.8
[[stage]]
name = "settle"
duration = 2.5
monitor = "block"
solver = { damping = "viscous", stiffness_damping = 1e-3, mass_damping = 20.0 }
)";
  const auto motion = [](const std::string& blocks, double last) {
    return fmt::format(
        "[[stage.ground_motion.support]]\nblocks = [\"{}\"]\ndirection = [1, 0, 0]\ntime = [0, 0.5, 1]\n"
        "displacement = [0, {}, {}]\n",
        blocks, 0.5 * last, last);
  };
  const double u = 0.002, k = 2e11 * 1e-5 / 2.0, soil = 1e7;
  const double force = u / (1.0 / k + 1.0 / soil + 1.0 / (soil / 12.0 - 2.0 * kWeightOfCube));
  const auto of_support = motion("support", u);
  for (const std::string& scene : {support + rest + of_support, support + other + rest + of_support,
                                   support + other + rest + of_support + motion("other", 0.007),
                                   other + support + rest + of_support + motion("other", 0.007)}) {
    std::unique_ptr<Simulation> run;
    const Rows rows = rows_of(scene, &run);
    EXPECT_NEAR(run->large_motion()->held_by.members->columns()[0], force, 0.005 * force);
    EXPECT_EQ(rows.all.back().ground_displacement, Vec3{});
  }
  const std::string ground =
      "[stage.ground_motion]\ndirection = [1, 0, 0]\ntime = [0, 0.5, 1]\ndisplacement = [0, 1, 2]\n";
  expect_refused(kBase + kCube + "[[stage]]\nduration = 1\n" + ground + motion("base", 1.0),
                 "all fixed blocks are in its supports");
}

// Rest is that against the ground. Where a record had left it with a velocity, blocks stopped in space, and slid by
// v^2/(2 mu g) = 0.073 m on it.
TEST(OutsideGround, RestIsThatOnTheMovingGround) {
  const std::string shaken = R"(
[[stage]]
name = "weight"
kind = "rest"
gravity = [0, -9.81, 0]
[[stage]]
name = "shake"
duration = 1
monitor = "cube"
ground_motion = { direction = [1, 0, 0], pulse = { shape = "rectangle", amplitude = 2, period = 0.5 } }
[[stage]]
name = "settle"
kind = "rest"
monitor = "cube"
)";
  for (const char* of_cube : {"", "rigid = false\ndivisions = [1, 1, 1]\n"}) {
    const Rows rows = rows_of(kBase + kCube + of_cube + shaken);
    EXPECT_GT(rows.all.back().ground_displacement[0], 0.5);
    EXPECT_LT(std::abs(rows.all.back().monitor_relative[0]), 2e-5);
  }
}

// Stages of walls that hold the bottom beam stop a ground that still moves: 0.3 m/s within 5 ms, which cracks the wall.
TEST(OutsideGround, AWallWhoseGroundIsStoppedIsWarnedOf) {
  const auto shaken = [](const std::string& after) {
    return wall("zones = [1, 1, 1]\ntop_beam = true\n") + R"(
[[stage]]
kind = "pressure"
pressure = 0.1e6
[[stage]]
name = "shake"
kind = "custom"
monitor = "top_beam"
duration = 0.3
ground_motion = { direction = [1, 0, 0], pulse = { shape = "rectangle", amplitude = 2, period = 0.15 })" +
           after + " }\n[[stage]]\nname = \"pressed again\"\n";
  };
  // In a stage of rest all stops together.
  for (const auto& [last, warnings] :
       {std::pair("kind = \"pressure\"\npressure = 0.2e6\n", 1), std::pair("kind = \"rest\"\npressure = 0.2e6\n", 0)}) {
    EXPECT_EQ(std::ranges::count(rows_of(shaken("") + last).warned_of, "ground_motion"), warnings) << last;
    const Rows stopped = rows_of(shaken(", after = \"rest\", rest_time = 0.1") + last);
    EXPECT_EQ(std::ranges::count(stopped.warned_of, "ground_motion"), 0) << last;
  }
}

// Blocks on springs go where the ground goes, 4 m. They are held, and come to rest. Where nothing is fixed the way of
// the ground counted as a fall. A block that rises off its springs does fall.
TEST(OutsideGround, ABlockOnSpringsOfAMovingGroundIsHeld) {
  const auto falls = [](const std::string& stages) {
    const Rows rows = rows_of(kCube + R"(
[[block]]
name = "top"
material = "stone"
box = { lower = [0, 1, 0], size = [1, 1, 1] }
[[spring]]
name = "soil"
block = "cube"
normal_stiffness = 1e7
shear_stiffness = 1e7
normal_dashpot = 2e5
shear_dashpot = 2e5
friction_angle = 40.0
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
ramp_time = 0.2
duration = 0.5
)" + stages);
    return std::ranges::count(rows.warned_of, "free_fall");
  };
  EXPECT_EQ(falls(R"(
[[stage]]
name = "shake"
duration = 4
ground_motion = { direction = [1, 0, 0], time = [0, 2, 4], displacement = [0, 2, 4] }
[[stage]]
name = "rest"
equilibrium_ratio = 1e-2
)"),
            0);
  EXPECT_EQ(falls("[[stage]]\nname = \"rise\"\ngravity = [0, 9.81, 0]\nduration = 4\n"), 1);
}

}  // namespace
}  // namespace quoin::verification
