// State of a stage that comes from the one before: supports and loads that it releases, laws that it replaces, the time
// step. And the ground from which a collapse counts. On the lattice and for blocks of any shape.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "../dry_stone.h"
#include "base/error.h"
#include "base/input_file.h"
#include "members/members.h"
#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "step/steer.h"

namespace quoin {
namespace {

using ::testing::HasSubstr;

std::string with(std::string text, const std::string& was, const std::string& is) {
  const std::size_t place = text.find(was);
  EXPECT_NE(place, std::string::npos) << was;
  return place == std::string::npos ? text : text.replace(place, was.size(), is);
}

std::string block(const std::string& name, const std::string& box, bool fixed = false) {
  return fmt::format("[[block]]\nname = \"{}\"\nmaterial = \"stone\"\nbox = {{ {} }}\n{}", name, box,
                     fixed ? "fixed = true\n" : "");
}

std::string general_from_start() { return "[contact]\nsmall_displacement = 0.0\n"; }

// Runs whole stages.
void run_stages(Simulation& simulation, int count) {
  Observer nobody;
  for (int i = 0; i < count; ++i) simulation.run_stage(nobody);
}

Vec3 moved(const Simulation& simulation, int block) { return block_displacement(simulation, block)[0]; }

// ---- Forces and pressures ------------------------------------------------------------------------------------------

// The first stage ends in the middle of its ramp, where half of its loads act: these fade while those of the second
// grow. A moving load is shared by two of five positions, so that its place is that of the load between its ends.
TEST(Loads, FadeFromWhatActsWhileThoseOfTheNextStageGrow) {
  Simulation simulation(
      read_scene_text(dry_stone(35.0) + "[solver]\ndamping = \"viscous\"\nmass_damping = 50.0\n" +
                          block("slab", "lower = [-1, -0.2, 0], size = [5, 0.2, 1]", true) +
                          block("a", "lower = [0, 0, 0], size = [0.5, 0.5, 1]") + general_from_start() +
                          "[[stage]]\nname = \"one\"\ngravity = [0, -9.81, 0]\nramp_time = 0.04\nduration = 0.02\n"
                          "[[stage.force]]\nblock = \"a\"\npoint = [0, 0.25, 0.5]\nforce = [100, 0, 0]\n"
                          "[[stage.pressure]]\nblock = \"a\"\nnormal = [0, 1, 0]\npressure = 1000\n"
                          "[[stage]]\nname = \"two\"\nramp_time = 0.04\nduration = 0.12\n"
                          "[[stage.force]]\nblock = \"a\"\npoint = [0, 0.25, 0.5]\nforce = [0, 0, 40]\n"
                          "[stage.moving_load]\nfrom = [0.05, 2, 0.5]\nto = [0.45, 2, 0.5]\nforce = [0, -10, 0]\n"
                          "positions = 5\n",
                      "loads.toml"),
      1);
  struct Acting {
    geometry::Vector force;
    double moment = 0.0, pressure = 0.0;
  };
  const auto acting = [&] {
    Acting sum;
    for (const blocks::Load& load : simulation.large_motion()->actions.loads) {
      sum.force += load.scale * load.force;
      sum.moment += load.scale * load.force.y * load.point.x;
    }
    for (const blocks::Pressure& pressure : simulation.large_motion()->actions.pressures)
      sum.pressure += pressure.scale * pressure.value;
    return sum;
  };
  run_stages(simulation, 1);
  const Acting first = acting();
  EXPECT_NEAR(first.force.x, 50.0, 3.0) << "to a step of 0.8 ms";
  EXPECT_NEAR(first.pressure, 10.0 * first.force.x, 1e-9);
  const double begin = simulation.time();
  Observer nobody;
  simulation.run_stage(nobody, 1);
  EXPECT_NEAR(acting().force.x, first.force.x, 0.1) << "without a jump";
  double before = -1.0;
  while (simulation.time() < begin + 0.11) {
    simulation.run_stage(nobody, 10);
    const Acting now = acting();
    const double ramp = now.force.z / 40.0;
    EXPECT_GE(ramp, before);
    EXPECT_NEAR(now.force.x, first.force.x * (1.0 - ramp), 1e-9);
    EXPECT_NEAR(now.pressure, first.pressure * (1.0 - ramp), 1e-9);
    EXPECT_NEAR(now.force.y, -10.0 * ramp, 1e-9) << "all of the moving load";
    const double way = std::clamp((simulation.time() - begin - 0.04) / 0.08, 0.0, 1.0);
    if (ramp > 0.0) {
      EXPECT_NEAR(now.moment / now.force.y, 0.05 + 0.4 * way, 0.4 * 2e-3 / 0.08) << "to the way in a step";
    }
    before = ramp;
  }
  EXPECT_EQ(before, 1.0);
}

// ---- Fixed blocks that a stage frees -------------------------------------------------------------------------------

const std::string kSlab = block("slab", "lower = [-1, -0.2, 0], size = [5, 0.2, 1]", true);

// A fixed block on a fixed slab, of 4905 N on 0.5 m2, which the second stage frees.
std::string freed_block(double gravity, const std::string& stages) {
  return dry_stone(35.0) + "[solver]\ndamping = \"viscous\"\nmass_damping = 50.0\nstiffness_damping = 1e-4\n" + kSlab +
         block("a", "lower = [0, 0, 0], size = [0.5, 0.5, 1]", true) +
         block("c", "lower = [2, 0, 0], size = [0.5, 0.5, 1]") +
         fmt::format("[[stage]]\nname = \"weight\"\ngravity = [0, {}, 0]\nramp_time = 0.1\nduration = 0.2\n", gravity) +
         stages;
}

constexpr const char* kFree = R"([[stage]]
name = "free"
ramp_time = 0.05
duration = 0.3
[[stage.velocity]]
block = "a"
velocity = ["free", "free", "free"]
rotation_held = false
)";

// Its weight closes the joint by 4905 N / (1e9 Pa/m 0.5 m2). With gravity upwards the bond carries as much.
TEST(FreedBlock, HasAJointWithTheFixedBlockBelow) {
  for (const char* kernels : {"automatic", "general"}) {
    for (const double gravity : {-9.81, 9.81}) {
      std::string text = freed_block(gravity, kFree);
      if (gravity > 0.0)
        text = with(text, "\"dry\"\nnormal", "\"bonded\"\ntensile_strength = 1e6\ncohesion = 1e6\nnormal");
      Simulation simulation(read_scene_text(text, "freed.toml", {std::string("solver.kernels=") + kernels}));
      run_stages(simulation, 2);
      EXPECT_NEAR(moved(simulation, 1)[1], gravity / 9.81 * 9.81e-6, 0.02 * 9.81e-6) << kernels;
      EXPECT_NEAR(moved(simulation, 2)[1], gravity / 9.81 * 9.81e-6, 0.02 * 9.81e-6) << kernels;
    }
  }
}

// Its weight grows over the ramp of 0.05 s, 8 of its periods. Let go at once it would sink twice as far.
TEST(FreedBlock, ForceOfItsSupportFades) {
  const std::string text =
      with(freed_block(-9.81, kFree), "\"viscous\"\nmass_damping = 50.0\nstiffness_damping = 1e-4", "\"none\"");
  for (const char* kernels : {"automatic", "general"}) {
    Simulation simulation(read_scene_text(text, "freed.toml", {std::string("solver.kernels=") + kernels}));
    run_stages(simulation, 1);
    Observer nobody;
    double lowest = 0.0;
    for (bool goes_on = true; goes_on && simulation.stages_ended() < 2;) {
      goes_on = simulation.run_stage(nobody, 1);
      lowest = std::min(lowest, moved(simulation, 1)[1]);
    }
    EXPECT_NEAR(lowest, -9.81e-6, 0.05 * 9.81e-6) << kernels;
  }
}

// The slab touches both blocks; without a stage that frees block a, the slab and it are one ground.
TEST(FreedBlock, OnlyItsFixedNeighboursGetAJoint) {
  for (const bool freed : {false, true}) {
    Simulation simulation(read_scene_text(
        freed_block(-9.81, freed ? kFree : "") + block("far", "lower = [-1, 0, 0], size = [0.5, 0.5, 1]", true),
        "freed.toml", {"solver.kernels=general"}));
    EXPECT_EQ(simulation.large_motion()->contacts.list.size(), freed ? 2u : 1u);
  }
}

TEST(FreedBlock, CountsAsOneThatMovesAndIsNoBase) {
  const std::string text = with(freed_block(-9.81, kFree), block("c", "lower = [2, 0, 0], size = [0.5, 0.5, 1]"), "");
  Simulation simulation(read_scene_text(text, "freed.toml", {"solver.kernels=general"}));
  run_stages(simulation, 2);
  simulation.advance(1);
  const HistoryRow row = simulation.measure();
  EXPECT_NEAR(row.largest_displacement, 9.81e-6, 0.02 * 9.81e-6);
  EXPECT_NEAR(row.base_force[1], -4905.0, 0.02 * 4905.0);  // its weight on the slab
}

// A small block that tables hold, and that is let go. Meanwhile a stage chooses a longer step, of the others alone.
TEST(ReleasedBlock, HasItsFrequencyInTheTimeStep) {
  const std::string text = with(dry_stone(35.0), "\"coulomb_slip\"\ninitial_state = \"dry\"", "\"elastic\"") +
                           general_from_start() + kSlab + block("b", "lower = [0, 0, 0.4], size = [0.05, 0.05, 0.05]") +
                           block("c", "lower = [2, 0, 0], size = [0.5, 0.5, 1]") + R"(
[[stage]]
name = "one"
gravity = [0, -9.81, 0]
ramp_time = 0.1
duration = 0.02
[[stage.velocity]]
block = "b"
velocity = [0, 0, 0]
[[stage]]
name = "two"
duration = 0.01
solver = { time_step_fraction = 0.61 }
[[stage.velocity]]
block = "b"
velocity = [0, 0, 0]
[[stage]]
name = "three"
duration = 0.05
)";
  const std::string no_friction = with(text, "friction_angle = 35\n", "");
  Simulation whole(read_scene_text(no_friction, "held.toml", {"solver.time_step_fraction=0.61"}));
  const double with_small_block = whole.time_step_report().time_step;
  Simulation simulation(read_scene_text(no_friction, "held.toml"));
  run_stages(simulation, 2);
  EXPECT_GT(simulation.time_step_report().time_step, 1.5 * with_small_block);
  run_stages(simulation, 1);
  EXPECT_NEAR(simulation.time_step_report().time_step, with_small_block, 1e-3 * with_small_block);
}

// ---- Collapse ------------------------------------------------------------------------------------------------------

// Two blocks of 0.5 x 0.7 m on each other, far from the origin, pushed until they rock about an edge: 0.5/1.4.
std::string rocking(const std::string& stages, bool up_is_z = false, const std::string& more = "") {
  const auto place = [&](const char* x, const char* up, const char* width, const char* height, bool fixed,
                         const char* name) {
    return block(name,
                 up_is_z ? fmt::format("lower = [{}, -1, {}], size = [{}, 1, {}]", x, up, width, height)
                         : fmt::format("lower = [{}, {}, 0], size = [{}, {}, 1]", x, up, width, height),
                 fixed);
  };
  return dry_stone(35.0) + general_from_start() +
         "[solver]\ntime_step_fraction = 0.6\ndamping = \"viscous\"\nmass_damping = 2.0\nstiffness_damping = 1e-4\n" +
         place("4", "-0.2", "3", "0.2", true, "slab") + place("5", "0", "0.5", "0.7", false, "b") +
         place("5", "0.7", "0.5", "0.7", false, "c") + more +
         fmt::format("[[stage]]\nname = \"weight\"\ngravity = [0, {}]\nramp_time = 0.1\nduration = 0.2\n",
                     up_is_z ? "0, -9.81" : "-9.81, 0") +
         stages + "[output]\nmonitor = \"b\"\n";
}

constexpr const char* kShake = R"([[stage]]
name = "shake"
duration = 0.02
ground_motion = { direction = [1, 0, 0], time = [0, 0.005, 0.015, 0.02], acceleration = [0, 1, -1, 0] }
)";
constexpr const char* kPush = R"([[stage]]
name = "push"
ramp_time = 0.3
collapse = { direction = [1, 0, 0], start = 0.2, rate = 0.5, displacement = 0.02, limit = 1.0 }
)";

TEST(CollapseStage, CountsFromItsStartAfterAShake) {
  Simulation calm(read_scene_text(rocking(kPush), "calm.toml"));
  run_stages(calm, 2);
  ASSERT_TRUE(calm.outcome().collapse_multiplier);
  for (const char* held : {"", "[[stage.velocity]]\nblock = \"slab\"\nvelocity = [0, 0, 0]\n"}) {
    Simulation shaken(read_scene_text(rocking(std::string(kShake) + kPush + held), "shaken.toml"));
    run_stages(shaken, 3);
    ASSERT_TRUE(shaken.outcome().collapse_multiplier) << held;
    EXPECT_NEAR(*shaken.outcome().collapse_multiplier, *calm.outcome().collapse_multiplier, 0.02) << held;
  }
}

// A fixed block above a gap of 0.5 mm is no joint that opens, nor is one that an earlier stage has opened.
TEST(CollapseStage, UpliftIsOfJointsThatOpenInIt) {
  const auto slip = [](const std::string& more, const std::string& stages, const std::string& held = "") {
    Simulation simulation(read_scene_text(rocking(stages + kPush + held, false, more), "uplift.toml"));
    run_stages(simulation, stages.empty() ? 2 : 3);
    return simulation.outcome().base_slip_at_uplift.value_or(-1.0);
  };
  const double alone = slip("", "");
  EXPECT_GT(alone, 1e-5);
  EXPECT_NEAR(slip(block("roof", "lower = [4.9, 1.4005, 0], size = [0.3, 0.2, 1]", true), ""), alone, 0.1 * alone);
  const std::string lifted = block("d", "lower = [4.2, 0, 0], size = [0.3, 0.2, 1]");
  const std::string table = "[[stage.velocity]]\nblock = \"d\"\nvelocity = [0, 0.01, 0]\n";
  const std::string still = "[[stage.velocity]]\nblock = \"d\"\nvelocity = [0, 0, 0]\n";
  EXPECT_NEAR(slip(lifted, "[[stage]]\nname = \"lift\"\nduration = 0.03\n" + table, still), alone, 0.1 * alone);
}

TEST(CollapseStage, TheVerticalIsTheAxisOfTheWeight) {
  Simulation y(read_scene_text(rocking(kPush), "y.toml")), z(read_scene_text(rocking(kPush, true), "z.toml"));
  run_stages(y, 1), run_stages(z, 1);
  EXPECT_NEAR(y.measure().vertical_force, 6867.0, 0.02 * 6867.0);  // upper block: 0.35 m3
  EXPECT_NEAR(z.measure().vertical_force, y.measure().vertical_force, 1e-6 * 6867.0);
  run_stages(y, 1), run_stages(z, 1);
  ASSERT_TRUE(y.outcome().base_slip_at_uplift);
  ASSERT_TRUE(z.outcome().base_slip_at_uplift);
  EXPECT_NEAR(*z.outcome().base_slip_at_uplift, *y.outcome().base_slip_at_uplift,
              1e-3 * *y.outcome().base_slip_at_uplift);
  EXPECT_NEAR(z.measure().overturning_moment[1], -y.measure().overturning_moment[2],
              1e-3 * std::abs(y.measure().overturning_moment[2]));
}

// ---- Reactions and loads that fade ---------------------------------------------------------------------------------

// A block is held along x while a collapse pushes it. Released, its reaction and the body force fade together. Without
// the body force in the reaction it would swing by 0.6 mm.
TEST(ReleasedSupport, ReactionHasTheBodyForceOfACollapse) {
  const std::string held = "[[stage.velocity]]\nblock = \"b\"\nvelocity = [0, \"free\", \"free\"]\n";
  const std::string text =
      with(with(dry_stone(35.0), "normal_stiffness = 1e9", "normal_stiffness = 1e8"), "shear_stiffness = 1e9",
           "shear_stiffness = 1e7") +
      "[solver]\ndamping = \"none\"\n" + general_from_start() + kSlab +
      block("b", "lower = [-1, 0, 0], size = [1, 0.5, 1]") + block("c", "lower = [1.5, 0, 0], size = [1, 0.5, 1]") +
      "[[stage]]\nname = \"weight\"\ngravity = [0, -9.81, 0]\nramp_time = 0.2\nduration = 0.3\n" + held +
      "[[stage]]\nname = \"push\"\nramp_time = 0.2\n"
      "collapse = { direction = [1, 0, 0], start = 0.3, rate = 0.05, displacement = 0.1, limit = 0.305 }\n" +
      held + "[[stage]]\nname = \"free\"\nramp_time = 0.3\nduration = 0.2\n" +
      "[[stage]]\nname = \"on\"\nramp_time = 0.1\nduration = 0.2\n";
  Simulation simulation(read_scene_text(text, "held.toml"));
  run_stages(simulation, 2);
  const double before = moved(simulation, 1)[0];
  Observer nobody;
  double largest = 0.0;
  for (bool goes_on = true; goes_on && simulation.stages_ended() < 3;) {
    goes_on = simulation.run_stage(nobody, 50);
    largest = std::max(largest, std::abs(moved(simulation, 1)[0] - before));
  }
  EXPECT_LT(largest, 1e-5);
  // That stage ends inside its ramp. What is left of the body force fades in the next one; it ended at once.
  const double left = simulation.large_motion()->actions.of_collapse.x;
  EXPECT_GT(left, 0.1);
  simulation.run_stage(nobody, 1);
  EXPECT_NEAR(simulation.large_motion()->actions.of_collapse.x, left, 0.01 * left);
  simulation.run_stage(nobody);
  EXPECT_EQ(simulation.large_motion()->actions.of_collapse.x, 0.0);
}

// A force of 500 N fades while a stage holds its block; the next stage releases it. Both kernels give it the same
// motion.
TEST(ReleasedSupport, ReactionHasLoadsThatStillFade) {
  const std::string text = with(dry_stone(30.0), "shear_stiffness = 1e9", "shear_stiffness = 5e8") +
                           "[solver]\ntime_step_fraction = 0.4\ndamping = \"viscous\"\nmass_damping = 20.0\n"
                           "stiffness_damping = 5e-4\n" +
                           block("slab", "lower = [0, -0.25, 0], size = [0.5, 0.25, 0.5]", true) +
                           block("b", "lower = [0, 0, 0], size = [0.5, 0.25, 0.5]") + R"(
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
ramp_time = 0.02
duration = 0.07
[[stage]]
name = "force"
ramp_time = 0.02
duration = 0.1
[[stage.force]]
block = "b"
point = [0.25, 0.125, 0.25]
force = [500, 0, 0]
[[stage]]
name = "hold"
ramp_time = 0.03
duration = 0.01
[[stage.velocity]]
block = "b"
velocity = [0, "free", 0]
rotation_held = true
[[stage]]
name = "release"
ramp_time = 0.01
duration = 0.02
[[stage.velocity]]
block = "b"
velocity = ["free", "free", "free"]
rotation_held = true
)";
  const auto way = [&](const std::string& kernels) {
    Simulation simulation(read_scene_text(text, "fades.toml", {"solver.kernels=" + kernels}));
    run_stages(simulation, 3);
    std::vector<std::array<double, 2>> seen;  // s after the release, m
    const double begin = simulation.time();
    Observer nobody;
    while (simulation.stages_ended() < 4) {
      simulation.run_stage(nobody, 1);
      seen.push_back({simulation.time() - begin, moved(simulation, 1)[0]});
    }
    return seen;
  };
  const auto lattice = way("lattice"), general = way("general");
  const auto x_at = [&](double time) {
    const auto after = std::ranges::find_if(general, [&](const auto& sample) { return sample[0] >= time; });
    return after == general.end() ? general.back()[1] : (*after)[1];
  };
  double swing = 0.0, apart = 0.0;
  for (const auto& [time, x] : lattice) {
    swing = std::max(swing, std::abs(x - lattice.front()[1]));
    apart = std::max(apart, std::abs(x_at(time) - x));
  }
  EXPECT_LT(apart, 0.1 * swing) << swing;
}

// A base that may turn under the push of a force is held again. Its spin fades over the ramp of T = 0.05 s, in which
// the block on it moves by v T/2. Damping and its own vibration may take a tenth. Stopped at once on the lattice, it
// stayed.
TEST(CaughtSpin, FadesOverTheRampOnBothKernels) {
  const std::string text = with(dry_stone(35.0), "shear_stiffness = 1e9", "shear_stiffness = 5e8") +
                           "[solver]\ndamping = \"viscous\"\nmass_damping = 80.0\ntime_step_fraction = 0.2\n" +
                           block("g", "lower = [0, -0.5, 0], size = [0.5, 0.5, 0.5]", true) +
                           block("b", "lower = [0, 0, 0], size = [0.5, 0.5, 0.5]") + R"(
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
ramp_time = 0.1
duration = 0.15
[[stage]]
name = "push"
ramp_time = 0.03
duration = 0.1
[[stage.velocity]]
block = "g"
velocity = [0, 0, 0]
rotation_held = false
[[stage.force]]
block = "b"
point = [0.25, 0.25, 0.25]
force = [-311, 0, 0]
[[stage]]
name = "held"
ramp_time = 0.05
duration = 0.1
)";
  const auto way = [&](const std::string& kernels) {
    Simulation simulation(read_scene_text(text, "spin.toml", {"solver.kernels=" + kernels, "output.energy=true"}));
    EXPECT_EQ(simulation.large_motion() == nullptr, kernels == "lattice");
    run_stages(simulation, 2);
    const double before = moved(simulation, 1)[0], speed = block_velocity(simulation, 1)[0][0];
    EXPECT_LT(speed, -1e-3);
    run_stages(simulation, 1);
    EXPECT_NEAR(moved(simulation, 1)[0] - before, 0.5 * 0.05 * speed, 0.1 * 0.5 * 0.05 * std::abs(speed)) << kernels;
    const HistoryRow row = simulation.measure();
    EXPECT_LT(std::abs(row.energies->balance_error()), 2e-3 * std::abs(row.energies->external)) << kernels;
    return moved(simulation, 1)[0] - before;
  };
  const double general = way("general");
  EXPECT_NEAR(way("lattice"), general, 0.02 * std::abs(general));
}

// The jack of a push keeps its force where the run goes over to large motion, and it fades there as from the start.
TEST(ReleasedSupport, ForceOfAJackFadesAfterTheRunGoesOver) {
  std::string text = with(read_input_file(QUOIN_HOST_TESTS "/small_building.toml"), "load = 20e3", "load = 0.0");
  text = with(text, "displacement = 0.03", "displacement = 1e-4");
  text = text.substr(0, text.find("[output]")) + R"([[stage]]
name = "after"
kind = "custom"
duration = 0.004
ramp_time = 0.1
record_interval = 100
[[stage.force]]
block = "floor_1_1"
point = [0.65, 1.1, 0.125]
force = [0.0, 0.0, 1.0]
[output]
frames = 0
)";
  const auto end = [&](const std::string& kernels) {
    Simulation simulation(read_scene_text(text, "jack.toml", {"solver.kernels=" + kernels}));
    run_stages(simulation, 3);
    return simulation.measure().monitor_displacement[0];
  };
  const double general = end("general");
  EXPECT_NEAR(end("automatic"), general, 0.05 * std::abs(general));
}

// A support that is released adds the kinetic energy of its block, with the scaled mass.
TEST(ReleasedSupport, EnergiesBalanceWithScaledMass) {
  const std::string text = read_input_file(QUOIN_HOST_TESTS "/../cli/small_wall.toml");
  const std::string stages = R"([[stage]]
name = "after"
kind = "custom"
duration = 0.002
[[stage.control]]
body = "bottom_beam"
velocity = [0.0, 0.0, 0.0]
[[stage.control]]
body = "top_beam"
velocity = ["free", "free", "free"]
rotation_held = false
)";
  Simulation simulation(read_scene_text(
      text.substr(0, text.find("[output]")) + stages + text.substr(text.find("[output]")), "released.toml",
      {"solver.mass_scaling=100", "output.energy=true", "stage.shear.displacement=2e-4"}));
  ASSERT_FALSE(simulation.large_motion());
  run_stages(simulation, 3);
  simulation.advance(1);
  const Energies e = *simulation.measure().energies;
  EXPECT_LT(std::abs(e.balance_error()), 0.02 * std::abs(e.external));
}

// x^3 (10 - 15 x + 6 x^2) of the pretension is on when the first stage ends at a quarter of its ramp: 0.1035.
TEST(Pretension, GoesOnFromWhereTheFirstStageEnds) {
  Simulation simulation(
      read_scene_text(dry_stone(35.0) + kSlab + block("b", "lower = [0, 0, 0], size = [0.5, 0.5, 1]") + R"(
[[tie]]
name = "t"
from = { block = "slab", point = [0.25, -0.1, 0.5] }
to = { block = "b", point = [0.25, 0.4, 0.5] }
area = 1e-5
young_modulus = 200e9
yield_stress = 2350e6
pretension = 10000.0
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
ramp_time = 0.2
duration = 0.05
[[stage]]
name = "next"
ramp_time = 0.1
duration = 0.1
)",
                      "tie.toml"));
  Observer nobody;
  const auto jacked = [&] { return simulation.large_motion()->held_by.members->jacked(); };
  run_stages(simulation, 1);
  EXPECT_NEAR(jacked(), 0.1035, 5e-3);
  simulation.run_stage(nobody, 1);
  EXPECT_NEAR(jacked(), 0.1035, 5e-3);
  run_stages(simulation, 1);
  EXPECT_NEAR(jacked(), 1.0, 1e-4);
}

// ---- Laws and checkpoints ------------------------------------------------------------------------------------------

std::string wall_with(const std::string& properties, const std::string& stages = "") {
  const std::string text = with(read_input_file(QUOIN_HOST_TESTS "/../cli/small_wall.toml"), "friction_angle = 35.0",
                                "friction_angle = 35.0\n" + properties);
  return text.substr(0, text.find("[output]")) + stages + text.substr(text.find("[output]"));
}

TEST(LawSwap, IsRefusedWherePropertiesScatter) {
  Simulation simulation(
      read_scene_text(with(wall_with(""), "normal_stiffness = 82e9",
                           "normal_stiffness = { distribution = \"uniform\", lower = 20e9, upper = 150e9 }"),
                      "scatter.toml"));
  run_stages(simulation, 1);
  try {
    exchange_law(simulation, "mortar", "cyclic_joint");
    ADD_FAILURE() << "not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("the law of joints.mortar is replaced in stage"));
    EXPECT_THAT(error.what(), HasSubstr("its properties scatter"));
  }
}

constexpr const char* kCollapse = R"([[stage]]
name = "topple"
kind = "custom"
gravity = [0, -9.81, 0]
ramp_time = 0.002
collapse = { direction = [1, 0, 0], start = 0.0, rate = 200000.0, displacement = 0.0002, limit = 100000.0 }
)";

// With dilation, cyclic_joint may be stiffer than fracture_energy of the same properties.
TEST(LawSwap, AStifferLawHasItsOwnTimeStepOnTheLattice) {
  const std::string dilates = wall_with("dilation_angle = 24.0", kCollapse);
  Simulation stiff(read_scene_text(with(dilates, "law = \"fracture_energy\"", "law = \"cyclic_joint\""), "stiff.toml"));
  const double needed = stiff.time_step_report().time_step;
  const std::string text = with(dilates, "kind = \"shear\"", "kind = \"shear\"\nlaw = \"cyclic_joint\"");
  Simulation simulation(read_scene_text(text, "swap.toml", {"stage.shear.displacement=1e-4"}));
  run_stages(simulation, 1);
  const double before = simulation.time_step_report().time_step;
  EXPECT_GT(before, 1.5 * needed);
  const std::vector<std::uint8_t> at_press = simulation.save();
  Observer nobody;
  simulation.run_stage(nobody, 40);
  EXPECT_NEAR(simulation.time_step_report().time_step, needed, 1e-9 * needed);
  const std::vector<std::uint8_t> swapped = simulation.save();

  // Both states go on bit for bit in a simulation with the other law, also after it has gone over to large motion.
  const auto hash_after = [&](Simulation& run, const std::vector<std::uint8_t>& state) {
    run.restore(state);
    run.run_stage(nobody, 30);
    return run.hash();
  };
  Simulation fresh(simulation.scene());
  EXPECT_EQ(hash_after(fresh, swapped), hash_after(simulation, swapped));
  Simulation first(simulation.scene());
  const std::uint64_t from_press = hash_after(first, at_press);
  EXPECT_EQ(hash_after(simulation, at_press), from_press);
  run_stages(simulation, 2);
  ASSERT_TRUE(simulation.large_motion());
  EXPECT_TRUE(simulation.outcome().collapse_multiplier);
  EXPECT_EQ(hash_after(simulation, at_press), from_press);
  EXPECT_FALSE(simulation.outcome().collapse_multiplier);
}

// The body force that the next stage lets fade does not pull at the load of a floor.
TEST(Checkpoint, AfterACollapseGoesOnWithALoadedFloor) {
  std::string text = read_input_file(QUOIN_SCENES "/floor_facade.toml");
  text = with(text, "mass = 40.0", "mass = 40.0\nload = 3000.0");
  const std::string after = "[[stage]]\nname = \"after\"\nramp_time = 0.5\nduration = 0.5\n";
  text = text.substr(0, text.find("[output]")) + after + text.substr(text.find("[output]"));
  const Scene scene =
      read_scene_text(text, "floor.toml",
                      {"stage.1.duration=0.05", "stage.1.ramp_time=0.05", "stage.2.ramp_time=0.05",
                       "stage.2.collapse.limit=0.061", "stage.2.collapse.rate=0.1", "stage.2.collapse.start=0.06"});
  Simulation run(scene), restored(scene);
  run_stages(run, 2);
  restored.restore(run.save());
  Observer nobody;
  run.run_stage(nobody, 100), restored.run_stage(nobody, 100);
  EXPECT_EQ(restored.hash(), run.hash());
}

}  // namespace
}  // namespace quoin
