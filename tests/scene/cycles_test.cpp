// Cycles: their closed form, the loss of force, and scenes with cycles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "../scene_of_text.h"
#include "base/error.h"

namespace quoin {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Cycles kCycles{{0.001, 0.003}, {2, 1}, 0.01, 0.05, {}};

// A half cycle of distance L at velocity v with ramps of time r takes L/v + r. Each ramp covers half of v r.
// Distances: 1, 2, 2, 2, then 4 (from -1 to 3), 6 and 3 mm.
TEST(CyclicMotion, LastsAsLongAsItsWays) {
  const CyclicMotion motion(kCycles);
  ASSERT_EQ(motion.half_cycles(), 7);
  EXPECT_NEAR(motion.duration(), 0.020 / 0.01 + 7 * 0.05, 1e-15);
  const double targets[] = {1, -1, 1, -1, 3, -3, 0};
  double end = 0.0;
  const double ways[] = {1, 2, 2, 2, 4, 6, 3};
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(motion.target(i), 1e-3 * targets[i]);
    EXPECT_EQ(motion.half_cycle(end + 1e-9), i);
    end += 1e-3 * ways[i] / 0.01 + 0.05;
    EXPECT_NEAR(motion.position(end), 1e-3 * targets[i], 1e-18) << i;
  }
  EXPECT_EQ(motion.position(2 * motion.duration()), 0.0);
}

// Against an independent velocity, integrated by Simpson's rule: v s(t/r), with the smooth step s whose derivative is
// 30 x^2 (1 - x)^2.
TEST(CyclicMotion, IsTheIntegralOfASmoothVelocity) {
  const CyclicMotion motion(kCycles);
  constexpr int kSteps = 200000;
  const double dt = motion.duration() / kSteps;
  const auto ramp = [](double x) {  // integral of 30 x^2 (1 - x)^2
    x = std::clamp(x, 0.0, 1.0);
    return 30 * (x * x * x / 3 - x * x * x * x / 2 + x * x * x * x * x / 5);
  };
  const auto velocity = [&](double time) {
    const double ways[] = {1, -2, 2, -2, 4, -6, 3};
    double start = 0.0;
    for (const double way : ways) {
      const double length = 0.1 * std::abs(way) + 0.05;
      if (time <= start + length)
        return std::copysign(0.01, way) * std::min(ramp((time - start) / 0.05), ramp((start + length - time) / 0.05));
      start += length;
    }
    return 0.0;
  };
  double integral = 0.0, largest = 0.0, jump = 0.0, before = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double a = i * dt, b = a + dt;
    integral += dt / 6 * (velocity(a) + 4 * velocity(a + dt / 2) + velocity(b));
    ASSERT_NEAR(motion.position(b), integral, 1e-12) << b;
    const double now = (motion.position(b) - motion.position(a)) / dt;
    largest = std::max(largest, std::abs(now));
    jump = std::max(jump, std::abs(now - before));
    before = now;
  }
  EXPECT_LE(largest, 0.01 * (1 + 1e-9));
  // The largest slope of the smooth step is 15/8 over the ramp.
  EXPECT_LE(jump, 0.01 * 15 / 8 / 0.05 * dt * 1.001);
}

TEST(CyclicMotion, WaysTooShortForTheRampsAreSlower) {
  const CyclicMotion motion({{1e-4}, {1}, 0.01, 0.05, {}});  // 0.1, 0.2 and 0.1 mm; full ramps would cover 0.5 mm
  EXPECT_NEAR(motion.duration(), 3 * 0.1, 1e-15);
  EXPECT_NEAR(motion.position(0.1), 1e-4, 1e-18);
  EXPECT_NEAR(motion.position(0.2), -1e-4, 1e-18);
  EXPECT_NEAR((motion.position(0.1501) - motion.position(0.1499)) / 2e-4, -2e-4 / 0.05, 1e-7);
}

TEST(CyclicMotion, NegativeVelocityBeginsTowardsTheNegativeSide) {
  const CyclicMotion there(kCycles), back({{0.001, 0.003}, {2, 1}, -0.01, 0.05, {}});
  for (double t = 0.0; t < there.duration(); t += 0.01) EXPECT_EQ(there.position(t), -back.position(t));
}

TEST(CyclicMotion, WhatStillMovesComesBackInTheFirstRamp) {
  const CyclicMotion motion(kCycles);
  constexpr double kVelocity = 0.02, kSmall = 1e-7;
  EXPECT_EQ(motion.position(0.0, kVelocity), 0.0);
  EXPECT_NEAR(motion.position(kSmall, kVelocity) / kSmall, kVelocity, 1e-6);
  EXPECT_EQ(motion.position(0.05, kVelocity), motion.position(0.05));
  EXPECT_EQ(motion.position(0.15, kVelocity), motion.position(0.15));
}

// Half cycles with largest forces of 10, -9, 12, -7, each in the middle of the half cycle.
TEST(ForceLoss, HoldsHalfCyclesAgainstThoseOfTheirSide) {
  ForceLoss loss;
  const double forces[] = {10, -9, 12, -7};
  for (int half_cycle = 0; half_cycle < 5; ++half_cycle) {
    const double target = half_cycle % 2 == 0 ? 1e-3 : -1e-3;
    // A remaining force of the last half cycle does not count for this one.
    const double before = half_cycle > 0 ? forces[half_cycle - 1] : 0.0;
    EXPECT_EQ(loss.see(before, half_cycle, target, 0.8), half_cycle == 4) << half_cycle;
    if (half_cycle == 4) break;
    EXPECT_FALSE(loss.see(forces[half_cycle], half_cycle, target, 0.8));
    EXPECT_FALSE(loss.see(0.5 * forces[half_cycle], half_cycle, target, 0.8));
  }
  EXPECT_EQ(loss.half_cycle(), 3);
  EXPECT_EQ(loss.force(), 7.0);
  EXPECT_EQ(loss.largest(), 9.0);
}

TEST(ForceLoss, SmallerAmplitudesLoseNoForce) {
  ForceLoss loss;
  const double amplitudes[] = {2e-3, -2e-3, 1e-3, -1e-3, 2e-3, -2e-3};
  const double forces[] = {10, -10, 5, -5, 7, -9};
  for (int i = 0; i < 6; ++i) EXPECT_EQ(loss.see(forces[i], i, amplitudes[i], 0.8), i == 5) << i;
  EXPECT_EQ(loss.half_cycle(), 4);
}

// ---- Scenes --------------------------------------------------------------------------------------------------------

class ReadCycles : public ::testing::Test {
 protected:
  Scene read(const std::string& scene, const std::vector<std::string>& overrides) {
    return scene_of_text(scene, overrides);
  }
  std::string fault(const std::string& scene, const std::vector<std::string>& overrides) {
    try {
      read(scene, overrides);
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      return error.what();
    }
    ADD_FAILURE() << "accepted";
    return {};
  }
};

const char* const kWall = R"([materials.brick]
young_modulus = 16.7e9
poisson_ratio = 0.15
density = 1900
[joints.mortar]
law = "elastic"
normal_stiffness = 82e9
shear_stiffness = 36e9
[wall]
courses = 2
units_per_course = 1.5
unit = [0.2, 0.1, 0.1]
mid_unit_joints = false
unit_material = "brick"
bed_joint = "mortar"
head_joint = "mortar"
beam_joint = "mortar"
[[stage]]
name = "press"
kind = "pressure"
pressure = 1e5
[[stage]]
kind = "cycles"
amplitudes = [0.001, 0.003]
cycles = [2, 1]
velocity = 0.01
)";

const char* const kBlocks = R"([materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000
[joints.dry]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 5e8
[[block]]
name = "foot"
material = "stone"
fixed = true
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[block]]
name = "head"
material = "stone"
box = { lower = [0, 1, 0], size = [1, 1, 1] }
[[stage]]
kind = "cycles"
amplitudes = [1e-5]
cycle_velocity = 0.01
block = "head"
)";

TEST_F(ReadCycles, OfTheTopBeamOfAWall) {
  const Stage stage = read(kWall, {"stage.2.vertical=pressure"}).stages[1];
  ASSERT_TRUE(stage.cycles);
  EXPECT_THAT(stage.cycles->amplitudes, ElementsAre(0.001, 0.003));
  EXPECT_THAT(stage.cycles->counts, ElementsAre(2, 1));
  EXPECT_EQ(stage.ramp_time, 0.05);
  EXPECT_NEAR(*stage.duration, 2.35, 1e-12);
  EXPECT_FALSE(stage.cycles->stop_at_force_loss);
  ASSERT_EQ(stage.controls.size(), 2u);
  EXPECT_EQ(stage.controls[1].body, "top_beam");
  EXPECT_EQ(stage.controls[1].in_cycles, 0);
  EXPECT_NEAR(stage.controls[1].force[1], -1e5 * 0.3 * 0.1, 1e-9);
  EXPECT_EQ(stage.controls[0].in_cycles, -1);
  EXPECT_THAT(read(kWall, {"stage.2.cycles=3"}).stages[1].cycles->counts, ElementsAre(3, 3));
  EXPECT_EQ(text_of(*stage.cycles), "2 cycles of 1 mm, 1 of 3 mm");
}

TEST_F(ReadCycles, OfAnyBodyWithControlsOfItsOwn) {
  const std::string more = R"(body = "bottom_beam"
direction = "y"
[[stage.control]]
body = "top_beam"
[[stage.control]]
body = "bottom_beam"
velocity = ["free", 0.0, 0.0]
)";
  const Stage stage = read(std::string(kWall) + more, {}).stages[1];
  ASSERT_EQ(stage.controls.size(), 2u);
  EXPECT_EQ(stage.controls[1].in_cycles, 1);
  EXPECT_EQ(stage.controls[1].kind[0], DofKind::free);
  EXPECT_EQ(stage.monitor, "bottom_beam");
  EXPECT_EQ(stage.direction, 1);
  EXPECT_THAT(fault(std::string(kWall) + more, {"stage.2.direction=x"}),
              HasSubstr("allowed: a body whose velocity along x is 0 in its own table"));
}

TEST_F(ReadCycles, OfABlock) {
  const Stage stage = read(kBlocks, {}).stages[0];
  ASSERT_EQ(stage.controls.size(), 1u);
  EXPECT_EQ(stage.controls[0].body, "head");
  EXPECT_EQ(stage.controls[0].in_cycles, 0);
  EXPECT_FALSE(stage.controls[0].may_turn);
  EXPECT_EQ(stage.monitor, "head");
}

TEST_F(ReadCycles, FaultsSayWhereAndWhatIsAllowed) {
  const struct {
    const char *scene, *override, *message;
  } faults[] = {
      {kWall, "stage.2.amplitudes=[]", "stage.2.amplitudes = []: wrong type, a list; allowed: a list of numbers"},
      {kWall, "stage.2.amplitudes=[0.001, 0]", "a list of numbers, each more than 0, m"},
      {kWall, "stage.2.amplitudes=0.001", "wrong type, a number; allowed: a list of numbers, each more than 0, m"},
      {kWall, "stage.2.cycles=0", "stage.2.cycles = 0: allowed: an integer, 1 to 10000"},
      {kWall, "stage.2.cycles=[1, 2.5]", "a list of integers, each 1 to 10000"},
      {kWall, "stage.2.cycles=[1, 0]", "each 1 to 10000, one for each amplitude"},
      {kWall, "stage.2.cycles=[1, 1, 1]", "an integer for all amplitudes, or one for each of the 2; the list has 3"},
      {kWall, "stage.2.velocity=0", "stage.2.velocity = 0: allowed: not 0"},
      {kWall, "stage.2.velocity=1e-320", "one that reaches the amplitudes in finite time"},
      {kWall, "stage.2.ramp_time=0", "stage.2.ramp_time = 0: allowed: more than 0 s"},
      {kWall, "stage.2.stop_at_force_loss=1.5", "a number, more than 0 and at most 1"},
      {kWall, "stage.2.duration=1", "stage.2.duration = 1: allowed: not with kind = \"cycles\""},
      {kWall, "stage.2.displacement=1", "stage.2.displacement = 1: allowed: not with kind = \"cycles\""},
      {kWall, "stage.2.equilibrium_ratio=0.1", "allowed: not with kind = \"cycles\""},
      {kWall, "stage.2.vertical=free", "one of held, pressure"},
      {kWall, "stage.2.amplitude=1", "unknown key, did you mean 'amplitudes'?"},
      {kWall, "wall.top_beam=false", "cycles move the top beam, which the wall does not have"},
      {kWall, "stage.2.body=top", "stage.2.body = 'top': allowed: one of bottom_beam, top_beam"},
      {kBlocks, "stage.1.kind=cycle", "one of rest, cycles, custom, did you mean 'cycles'?"},
      {kBlocks, "stage.1.cycle_velocity=0", "stage.1.cycle_velocity = 0: allowed: not 0"},
      {kBlocks, "stage.1.block=1", "wrong type, an integer; allowed: the name of the block that moves"},
      {kBlocks, "stage.1.displacement=1", "stage.1.displacement = 1: allowed: not with kind = \"cycles\""},
      {kBlocks, "stage.1.collapse.rate=1", "cycles without ground_motion, collapse and moving_load"},
      {kBlocks, "stage.1.kind=custom", "stage.1.amplitudes"},
  };
  for (const auto& f : faults) EXPECT_THAT(fault(f.scene, {f.override}), HasSubstr(f.message)) << f.override;
  EXPECT_THAT(fault(std::string(kWall) + "duration = 1\n", {}), AllOf(HasSubstr(".toml:27: stage.2.duration = 1")));
}

}  // namespace
}  // namespace quoin
