// Damping ratios of the first modes of a stage, compared with a block on one joint.
#include "analysis/damping_ratios.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "scene/read_scene.h"

namespace quoin {
namespace {

constexpr double kNormal = 1e9, kShear = 4e8, kMass = 1800.0, kInertia = kMass / 6.0;  // a cube of 1 m

struct Modes : Observer {
  StageModes found;
  void on_stage_begin(const Simulation& simulation, int stage) override {
    if (stage == 1) found = damped_modes(simulation, stage);
  }
};

Scene cube(const std::vector<std::string>& overrides) {
  return read_scene_text(R"(
[materials.stone]
density = 1800.0
[joints.joint]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 4e8
[contact]
cubic_points = false
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-1, -0.2, -1], size = [3, 0.2, 3] }
[[block]]
name = "cube"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[stage]]
name = "weight"
kind = "rest"
gravity = [0, -9.81, 0]
equilibrium_ratio = 1e-6
[[stage]]
name = "shake"
duration = 1.0
ground_motion = { direction = [1, 0, 0], time = [0, 1], acceleration = [0, 1] }
)",
                         "cube.toml", overrides);
}

StageModes modes_of(const std::vector<std::string>& overrides, double* in_use = nullptr) {
  Simulation simulation(cube(overrides), 1);
  Modes modes;
  simulation.run_stage(modes);
  simulation.run_stage(modes, 1);
  if (in_use) *in_use = simulation.time_step_report().impacts.in_use;
  return modes.found;
}

// Returns frequency (Hz) and damping ratio of the lower sway mode, for given ratios of viscosity and stiffness.
// Unknowns are u at the centre and theta, with energies ks u_0^2 of the base, u_0 = u + theta/2, and kn theta^2/4 of
// the corners.
std::array<double, 2> sway(double normal, double along, double mass_damping) {
  const double k11 = kShear, k12 = 0.5 * kShear, k22 = 0.25 * (kShear + kNormal);
  const double b = k11 / kMass + k22 / kInertia, c = (k11 * k22 - k12 * k12) / (kMass * kInertia);
  const double square = 0.5 * (b - std::sqrt(b * b - 4.0 * c)), turn = (square * kMass - k11) / k12;
  const double mass = kMass + kInertia * turn * turn, w = std::sqrt(square);
  const double of_base = (1.0 + 0.5 * turn) * (1.0 + 0.5 * turn);
  const double viscous = along * kShear * of_base + normal * kNormal * 0.25 * turn * turn + mass_damping * mass;
  return {w / (2.0 * std::numbers::pi), viscous / (2.0 * w * mass)};
}

// Weight reduces the rocking stiffness by m g h: a share of 1e-4.
TEST(DampedModes, AreThoseOfABlockOnAJoint) {
  double in_use = 0.0;
  const StageModes found = modes_of({}, &in_use);
  ASSERT_EQ(found.why_none, "");
  ASSERT_EQ(found.modes.size(), 3u);
  // The edge of an impact is 0.5 m beside and 0.5 m below the centre.
  const double landing = std::sqrt(0.5 * (1.0 / kMass + 0.25 / kInertia));
  const double normal = 2.0 * in_use / (landing * std::sqrt(kNormal)), along = in_use / (landing * std::sqrt(kShear));
  const auto [frequency, ratio] = sway(normal, along, 0.0);
  for (std::size_t i = 0; i < 2; ++i) {  // along x and z
    EXPECT_NEAR(found.modes[i].frequency, frequency, 1e-3 * frequency);
    EXPECT_NEAR(found.modes[i].ratio, ratio, 1e-3 * ratio);
  }
  const double upright = std::sqrt(kNormal / kMass);
  EXPECT_NEAR(found.modes[2].frequency, upright / (2.0 * std::numbers::pi), 1e-3 * upright);
  EXPECT_NEAR(found.modes[2].ratio, 0.5 * normal * upright, 1e-3 * 0.5 * normal * upright);
}

TEST(DampedModes, OfViscousDampingAreThoseOfRayleigh) {
  const StageModes found = modes_of({"stage.shake.solver={damping='viscous',mass_damping=3.0,stiffness_damping=1e-5}"});
  const auto [frequency, ratio] = sway(1e-5, 1e-5, 3.0);
  ASSERT_EQ(found.modes.size(), 3u);
  EXPECT_NEAR(found.modes[0].frequency, frequency, 1e-3 * frequency);
  EXPECT_NEAR(found.modes[0].ratio, ratio, 1e-3 * ratio);
}

TEST(DampedModes, SayWhyThereAreNone) {
  const StageModes found = modes_of({"stage.shake.solver={damping='none'}"});
  EXPECT_TRUE(found.modes.empty());
  EXPECT_EQ(found.why_none, "no viscosity damps");
  EXPECT_EQ(modes_text(found), "damping of the first modes not computed: no viscosity damps");
}

// Modes of more than 3000 unknowns cost as much as 6000 steps, which may be 3 % of those of the stage: 200 000 steps.
TEST(DampedModes, AreLeftOutWhereTheyCostTooMuchBesideTheStage) {
  const auto why_none = [](double zone_edge, double steps) {
    double duration = 1.0;
    const auto simulated = [&] {
      return Simulation(
          cube({"materials.stone.young_modulus=1e9", "materials.stone.poisson_ratio=0.2", "block.2.rigid=false",
                "block.2.zone_edge=" + std::to_string(zone_edge), "stage.shake.duration=" + std::to_string(duration)}),
          1);
    };
    duration = steps * simulated().time_step_report().time_step;
    return damped_modes(simulated(), 1).why_none;
  };
  EXPECT_EQ(why_none(0.1, 199e3), "that would take more than 3 % of the stage");
  EXPECT_EQ(why_none(0.1, 201e3), "");
  EXPECT_EQ(why_none(0.25, 199e3), "");
}

}  // namespace
}  // namespace quoin
