// Actions of an outside controller between two steps, against Newton's law: on the lattice and for blocks of any shape.
#include "step/steer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "scene/read_scene.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

using ::testing::HasSubstr;

constexpr double kKeep = std::numeric_limits<double>::quiet_NaN();

// Returns a plate with prescribed velocity, and two stones beside it without contacts, of 0.1 m and 2000 kg/m3: 2 kg.
// The lattice needs two blocks that touch: they are at rest behind.
std::string stones(const std::string& kernels) {
  return undamped_stone(kernels) + R"(
[[block]]
name = "base"
material = "stone"
box = { lower = [0, 0, 0], size = [0.3, 0.1, 0.3] }
[[block]]
name = "a"
material = "stone"
box = { lower = [1, 1, 0], size = [0.1, 0.1, 0.1] }
[[block]]
name = "b"
material = "stone"
box = { lower = [2, 1, 0], size = [0.1, 0.1, 0.1] }
[[block]]
name = "pillar"
material = "stone"
fixed = true
box = { lower = [0, 0, 5], size = [0.1, 0.1, 0.1] }
[[block]]
material = "stone"
box = { lower = [0.1, 0, 5], size = [0.1, 0.1, 0.1] }
[[stage]]
name = "fly"
duration = 10.0
[[stage.velocity]]
block = "base"
velocity = [0.1, 0.2, "free"]
omega = [0, 0, 0]
[[stage.force]]
block = "a"
point = [1.05, 1.05, 0.05]
force = [10.0, 0.0, 0.0]
[[stage.force]]
block = "b"
point = [2.05, 1.05, 0.05]
force = [0.0, 0.0, 0.0]
)";
}

class Steering : public ::testing::TestWithParam<const char*> {
 protected:
  Simulation simulation_{read_scene_text(stones(GetParam()), "stones.toml")};
  // Velocity of the centre of a rigid block, m/s.
  Vec3 velocity(int block) {
    const ArrayView v = view(simulation_, BlockArray::velocity, block);
    return {v.data[0], v.data[v.column_stride], v.data[2 * v.column_stride]};
  }
  double dt() const { return simulation_.time_step_report().time_step; }
  static void near(const Vec3& is, const Vec3& expected) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(is[c], expected[c], 1e-12 * (1.0 + std::abs(expected[c]))) << c;
  }
};

TEST_P(Steering, ForcesAccelerateWhatIsNamedAndNothingElse) {
  simulation_.advance(10);
  near(velocity(1), {10.0 / 2.0 * 10 * dt(), 0, 0});
  set_force(simulation_, "b", {kKeep, 6.0, -4.0});
  set_force(simulation_, "a", {kKeep, -2.0, kKeep});
  simulation_.advance(5);
  near(velocity(0), {0.1, 0.2, 0});
  near(velocity(1), {5.0 * 15 * dt(), -1.0 * 5 * dt(), 0});
  near(velocity(2), {0, 3.0 * 5 * dt(), -2.0 * 5 * dt()});
  // A force acts along the free axis of a block with prescribed velocity: 18 kg.
  set_force(simulation_, "base", {kKeep, kKeep, 36.0});
  simulation_.advance(5);
  near(velocity(0), {0.1, 0.2, 2.0 * 5 * dt()});
  near(velocity(2), {0, 3.0 * 10 * dt(), -2.0 * 10 * dt()});
}

TEST_P(Steering, VelocitiesMoveWhatTheStageMoves) {
  simulation_.advance(3);
  set_velocity(simulation_, "base", {kKeep, -0.7, kKeep});
  simulation_.advance(4);
  near(velocity(0), {0.1, -0.7, 0});
  near(velocity(2), {0, 0, 0});
}

TEST_P(Steering, WhatCannotBeSteeredIsToldAndNothingHasChanged) {
  const std::uint64_t before = simulation_.hash();
  const auto refused = [](const auto& call, const std::string& why) {
    try {
      call();
      ADD_FAILURE() << "taken: " << why;
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      EXPECT_THAT(error.what(), HasSubstr(why));
    }
  };
  refused([&] { set_force(simulation_, "base", {1, kKeep, kKeep}); }, "holds or moves 'base' along x");
  refused([&] { set_velocity(simulation_, "base", {kKeep, kKeep, 1}); }, "leaves free 'base' along z");
  refused([&] { set_velocity(simulation_, "a", {kKeep, 1, kKeep}); }, "leaves free 'a' along y");
  refused([&] { set_force(simulation_, "roof", {1, 1, 1}); }, "'roof'");
  refused(
      [&] {
        set_force(simulation_, "pillar", {1, kKeep, kKeep});
      },
      GetParam() == std::string("general") ? "holds or moves 'pillar' along x" : "'pillar'");
  const double endless = std::numeric_limits<double>::infinity();
  refused([&] { set_force(simulation_, "a", {kKeep, endless, kKeep}); }, "force[1] is inf");
  simulation_.advance(0, false);
  EXPECT_EQ(simulation_.hash(), before);
}

// What was set after the end of a stage was lost, as the next one began.
TEST_P(Steering, BetweenStagesIsRefused) {
  const std::string next = "[[stage]]\nname = \"go_on\"\nduration = 1.0\n";
  Simulation simulation(read_scene_text(stones(GetParam()) + next, "stones.toml", {"stage.fly.duration=1e-3"}));
  Observer observer;
  ASSERT_TRUE(simulation.run_stage(observer));
  for (const auto& steer : {set_force, set_velocity}) {
    try {
      steer(simulation, "b", {1, kKeep, kKeep});
      ADD_FAILURE() << "taken";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("stage 'fly' has ended, and 'go_on' would begin without it"));
    }
  }
  ASSERT_TRUE(simulation.run_stage(observer, 1));
  set_force(simulation, "b", {kKeep, 6.0, kKeep});
}

INSTANTIATE_TEST_SUITE_P(Kernels, Steering, ::testing::Values("lattice", "general"),
                         [](const auto& of) { return std::string(of.param); });

// A checkpoint of a steered run contains its blocks by index; an index that the model does not have is refused.
TEST(SteeredCheckpoint, BlocksThatAreNotThereAreRefused) {
  const auto saved = [](const std::string& steered) {
    std::string text = stones("general");
    text.resize(text.find("[[stage.force]]"));
    Simulation simulation(read_scene_text(text, "stones.toml"));
    set_force(simulation, steered, {kKeep, 1.0, kKeep});
    return simulation.save();
  };
  const std::vector<std::uint8_t> a = saved("a"), b = saved("b");  // blocks 1 and 2
  ASSERT_EQ(a.size(), b.size());
  std::string text = stones("general");
  text.resize(text.find("[[stage.force]]"));
  const auto number = [](const std::vector<std::uint8_t>& bytes, std::size_t place) {
    std::int32_t value;
    std::memcpy(&value, bytes.data() + place, sizeof value);
    return value;
  };
  int found = 0;
  for (std::size_t i = 0; i + 4 <= a.size(); ++i) {
    if (number(a, i) != 1 || number(b, i) != 2) continue;
    ++found;
    for (const std::int32_t wrong : {5, 6, -1}) {
      std::vector<std::uint8_t> bytes = a;
      std::memcpy(bytes.data() + i, &wrong, sizeof wrong);
      Simulation simulation(read_scene_text(text, "stones.toml"));
      ASSERT_EQ(simulation.block_count(), 5);
      EXPECT_THROW(simulation.restore(bytes), Error) << wrong;
    }
  }
  EXPECT_EQ(found, 1);
}

// A stone with a prescribed velocity along one axis, or a rotation about one axis, is free otherwise.
TEST(DrivenStone, FollowsTheOneComponentThatIsPrescribed) {
  for (const bool spin : {false, true}) {
    for (std::size_t c = 0; c < 3; ++c) {
      SCOPED_TRACE(c);
      std::array<std::string, 3> velocity{"\"free\"", "\"free\"", "\"free\""}, omega{"0", "0", "0"};
      (spin ? omega : velocity)[c] = "0.3";
      Simulation simulation(read_scene_text(
          undamped_stone("general") +
              fmt::format(R"(
[[block]]
name = "stone"
material = "stone"
box = {{ lower = [0, 0, 0], size = [0.1, 0.2, 0.3] }}
[[block]]
material = "stone"
box = {{ lower = [1, 0, 0], size = [0.1, 0.2, 0.3] }}
[[stage]]
duration = 1.0
[[stage.velocity]]
block = "stone"
velocity = [{}]
{}
)",
                          fmt::join(velocity, ", "),
                          spin ? fmt::format("omega = [{}]", fmt::join(omega, ", ")) : "rotation_held = false"),
          "stone.toml"));
      simulation.advance(100);
      const auto corners = block_mesh(simulation, 0).gridpoint;
      const auto moved = block_displacement(simulation, 0), velocities = block_velocity(simulation, 0);
      const Vec3 centre{0.05, 0.1, 0.15};  // centre of rotation
      for (std::size_t i = 0; i < corners.size(); ++i) {
        Vec3 expected{}, arm{};
        for (std::size_t k = 0; k < 3; ++k) arm[k] = corners[i][k] + moved[i][k] - centre[k];
        if (spin)
          expected[(c + 1) % 3] = -0.3 * arm[(c + 2) % 3], expected[(c + 2) % 3] = 0.3 * arm[(c + 1) % 3];
        else
          expected[c] = 0.3;
        // Velocities are those half a step before the positions.
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(velocities[i][k], expected[k], spin ? 1e-3 : 1e-12) << k;
      }
    }
  }
}

// A force on a deformable brick of the lattice is distributed by mass: two bricks, each with its own name.
TEST(SteeringBricks, ForcesOfTheStageAreReplacedOnOneOfThem) {
  Scene scene = bare_scene(0.6);
  Assembly assembly = brick_grid({2, 1, 1}, {0.2, 0.1, 0.05}, {2, 1, 1});
  assembly.joints.clear();
  Stage stage;
  stage.name = "push";
  stage.duration = 1.0;
  for (std::size_t i = 0; i < 2; ++i) {
    assembly.bricks[i].body = i == 0 ? "left" : "right";
    BodyControl control;
    control.body = assembly.bricks[i].body;
    control.kind = {DofKind::free, DofKind::free, DofKind::free};
    control.force = {30.0, 0.0, 0.0};
    stage.controls.push_back(control);
  }
  scene.stages = {stage};
  Simulation simulation(scene, assembly);
  simulation.advance(10);
  set_force(simulation, "right", {kKeep, -20.0, 50.0});
  simulation.advance(10);
  const double mass = kDensity * 0.2 * 0.1 * 0.05, dt = simulation.time_step_report().time_step;
  const auto expect = [&](int block, const Vec3& expected) {
    for (const Vec3& v : block_velocity(simulation, block)) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[c], expected[c], 1e-9 * 30.0 / mass * 20 * dt) << block;
    }
  };
  expect(0, {30.0 / mass * 20 * dt, 0, 0});
  expect(1, {30.0 / mass * 20 * dt, -20.0 / mass * 10 * dt, 50.0 / mass * 10 * dt});
}

// Diagnostic states are kept with energies, and in large motion always: promotion and pictures need them.
TEST(Steered, StatesThatAreKeptAreSeenInLargeMotionToo) {
  const auto wall = [](const std::string& motion) {
    return read_scene(QUOIN_HOST_TESTS "/../cli/small_wall.toml",
                      {"output.energy=false", "output.plots=false", "solver.large_motion=" + motion});
  };
  Simulation lattice(wall("never")), general(wall("always"));
  EXPECT_FALSE(keeps_state(lattice, "slip"));
  EXPECT_THROW(view_state(lattice, 0, "slip"), Error);
  EXPECT_TRUE(keeps_state(general, "slip"));
  EXPECT_EQ(view_state(general, 0, "slip").rows, general.large_motion()->contacts.families[0].size());
}

}  // namespace
}  // namespace quoin
