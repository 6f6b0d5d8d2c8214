// Blocks in small displacements that touch new blocks, separate or fall: a run detects this in time, for any output.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <map>

#include "base/error.h"
#include "results/summary.h"
#include "scene/collapse_load.h"
#include "scene/read_scene.h"
#include "step/findings.h"
#include "step/large_motion.h"
#include "step/simulation.h"
#include "step/unjoined_blocks.h"

namespace quoin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A base of 1 x 0.2 x 0.2 m, with dry blocks of 0.2 m on and above it, without damping.
std::string stones(const std::string& blocks, const std::string& stages, bool fixed = true) {
  return fmt::format(
      "[solver]\ndamping = \"viscous\"\nmass_damping = 0\nstiffness_damping = 2e-4\n"
      "[materials.stone]\nyoung_modulus = 10e9\npoisson_ratio = 0.2\ndensity = 2000.0\n"
      "[joints.dry]\nlaw = \"coulomb_slip\"\ninitial_state = \"dry\"\nnormal_stiffness = 1e8\nshear_stiffness = 5e7\n"
      "friction_angle = 35\n"
      "[[block]]\nname = \"base\"\nmaterial = \"stone\"\nfixed = {}\n"
      "box = {{ lower = [-0.4, -0.2, 0], size = [1.0, 0.2, 0.2] }}\n{}{}[output]\nframes = 0\n",
      fixed, blocks, stages);
}

std::string block(const std::string& name, double bottom, const std::string& more = "") {
  return fmt::format(
      "[[block]]\nname = \"{}\"\nmaterial = \"stone\"\nbox = {{ lower = [0, {}, 0], size = [0.2, 0.2, 0.2] }}\n{}\n",
      name, bottom, more);
}

std::string falls(const std::string& more = "duration = 0.3") {
  return "[[stage]]\nname = \"fall\"\ngravity = [0, -9.81, 0]\n" + more + "\n";
}

struct Seen : Observer {
  std::vector<HistoryRow> rows;
  std::map<std::string, std::string> warnings;
  int promotions = 0;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  void on_warning(const Warning& w) override { warnings[w.about] = w.text; }
  void on_promotion(const Simulation&) override { ++promotions; }
};

Scene scene_of(const std::string& text, const std::vector<std::string>& more = {}) {
  return read_scene_text(text, "stones.toml", more);
}

std::string fault_of(const std::string& text, const std::vector<std::string>& more, Exit* code) {
  try {
    Simulation simulation(scene_of(text, more), 1);
    Seen seen;
    simulation.run(seen);
  } catch (const Error& error) {
    *code = error.exit_code;
    return error.what();
  }
  return "";
}

// A third block 0.1 m above the second falls for sqrt(2 * 0.1 / 9.81) = 0.143 s, then it lies there. Small
// displacements alone have no contact between them. Overlap: 1.4 m/s times sqrt(m/k) = sqrt(16 / (1e8 * 0.04)) = 2 ms
// is 3 mm.
TEST(SmallMotion, ABlockThatFallsLandsOnTheOneBelow) {
  const std::string text = stones(block("a", 0.0) + block("c", 0.3), falls());
  for (const char* kernels : {"automatic", "general"}) {
    Simulation simulation(scene_of(text, {std::string("solver.kernels=") + kernels, "output.monitor=c"}), 1);
    EXPECT_EQ(simulation.large_motion() == nullptr, kernels == std::string("automatic"));
    Seen seen;
    simulation.run(seen);
    EXPECT_EQ(seen.promotions, kernels == std::string("automatic"));
    double lowest = 0.0, at_landing = 0.0;
    for (const HistoryRow& row : seen.rows) {
      const double down = row.monitor_displacement[1];
      lowest = std::min(lowest, down);
      if (row.time <= 0.143) at_landing = down;
    }
    EXPECT_NEAR(at_landing, -0.1, 2e-3) << kernels;  // it moves 1.4 mm in a step
    EXPECT_GT(lowest, -0.104) << kernels;
  }
  Exit code{};
  EXPECT_THAT(fault_of(text, {"solver.large_motion=never"}, &code),
              HasSubstr("which no joint joins, have come as near to each other as 0.0"));
  EXPECT_EQ(code, Exit::numerical);
  // The general kernels refuse past_motion_bound = "warn".
  const std::string in_general = fault_of(text, {"solver.kernels=general", "solver.large_motion=never"}, &code);
  EXPECT_EQ(code, Exit::numerical);
  EXPECT_THAT(in_general, AllOf(HasSubstr("leave out solver.large_motion"), Not(HasSubstr("past_motion_bound"))));
  Simulation warns(scene_of(text, {"solver.large_motion=never", "solver.past_motion_bound=warn"}), 1);
  Seen seen;
  warns.run(seen);
  EXPECT_THAT(seen.warnings["small_displacements"], HasSubstr("which no joint joins"));
  EXPECT_THAT(summary_text(warns, seen.rows, {}), HasSubstr("\"within_bound\": false"));
}

// A block moves up by 0.1195 m at 0.1 m/s, against a fixed one 0.1 m above.
TEST(SmallMotion, ABlockThatRisesMeetsTheFixedOneAbove) {
  const std::string text =
      stones(block("a", 0.0) + block("lid", 0.3, "fixed = true"),
             "[[stage]]\nname = \"rise\"\nmonitor = \"lid\"\ndirection = \"y\"\nduration = 1.2\nramp_time = 0.01\n"
             "[[stage.velocity]]\nblock = \"a\"\nvelocity = [0, 0.1, 0]\n");
  Simulation simulation(scene_of(text), 1);
  Seen seen;
  simulation.run(seen);
  EXPECT_EQ(seen.promotions, 1);
  // 19.5 mm of overlap at the end; the last steps are 0.1 mm.
  EXPECT_NEAR(seen.rows.back().joint_force[1], 1e8 * 0.04 * 0.0195, 0.02 * 1e8 * 0.04 * 0.0195);
  Exit code{};
  EXPECT_THAT(fault_of(text, {"solver.large_motion=never"}, &code), HasSubstr("'lid'"));
}

// Neighbours at an edge without a joint may overlap up to the sliding bound. Two blocks touch at an edge above a base;
// the upper one is driven down beside the lower one and into it.
TEST(SmallMotion, BlocksThatTouchAtAnEdgeMayNotPassThroughEachOther) {
  const std::string upper =
      "[[block]]\nname = \"b\"\nmaterial = \"stone\"\nbox = { lower = [0.2, 0.2, 0], size = [0.2, 0.2, 0.2] }\n";
  const auto stage = [](const char* velocity) {
    return fmt::format("[[stage]]\nname = \"push\"\nduration = 0.2\n[[stage.velocity]]\nblock = \"b\"\nvelocity = {}\n",
                       velocity);
  };
  Exit code{};
  // 20 mm along both axes: 0.03 * 0.2 = 6 mm are allowed.
  EXPECT_THAT(fault_of(stones(block("a", 0.0) + upper, stage("[-0.1, -0.1, 0]")), {"solver.large_motion=never"}, &code),
              HasSubstr("overlap by 0.006"));
  // Motion along the faces only has no overlap.
  EXPECT_EQ(fault_of(stones(block("a", 0.0) + upper, stage("[0, -0.1, 0]")), {"solver.large_motion=never"}, &code), "");
}

// Joint rules with "none" apply also to small displacements.
TEST(SmallMotion, BlocksWithoutContactMayPassThroughEachOther) {
  const std::string text = stones(block("a", 0.0) + block("c", 0.3), falls("duration = 0.3") +
                                                                         "[[joint_rule]]\nfamily = \"none\"\n"
                                                                         "between = [\"a\", \"c\"]\n");
  Exit code{};
  const std::string fault = fault_of(text, {"solver.large_motion=never"}, &code);
  EXPECT_THAT(fault, HasSubstr("'base'")) << "through a, but not through the base";
}

// A block that is lifted off its bed without rotation or slip.
TEST(SmallMotion, AJointThatOpensFarIsPastTheBound) {
  const std::string text = stones(block("a", 0.0),
                                  "[[stage]]\nname = \"lift\"\nduration = 0.5\n"
                                  "[[stage.velocity]]\nblock = \"a\"\nvelocity = [0, 1, 0]\n");
  Exit code{};
  EXPECT_THAT(fault_of(text, {"solver.large_motion=never"}, &code), HasSubstr("have parted by 1"));
  Simulation simulation(scene_of(text), 1);
  Seen seen;
  simulation.run(seen);
  EXPECT_EQ(seen.promotions, 1);
}

// One joint of 0.1 x 0.05 m across each axis: opening by 0.03 m is 0.6 of its shorter side, closing counts as 0.
TEST(SmallMotion, OpeningIsOverTheShorterSideOfTheJoint) {
  const Vec3 size{0.2, 0.1, 0.05};
  for (std::size_t normal = 0; normal < 3; ++normal) {
    for (const int face : {static_cast<int>(2 * normal), static_cast<int>(2 * normal + 1)}) {
      Assembly assembly;
      assembly.bricks.resize(2);
      for (Brick& brick : assembly.bricks) brick.size = size;
      const bool first_below = face % 2 == 1;
      assembly.bricks[first_below ? 1 : 0].origin[normal] = size[normal];
      assembly.joints.push_back({0, 1, face, 0});
      const double shorter = std::min(size[(normal + 1) % 3], size[(normal + 2) % 3]);
      std::vector<WholeMotion> motion(2);
      motion[1].translation[normal] = first_below ? 0.03 : -0.03;
      MotionSeen parted, pressed;
      JointSliding(assembly).look(motion, &parted);
      EXPECT_NEAR(parted.opening, 0.03 / shorter, 1e-14) << face;
      motion[1].translation[normal] *= -1.0;
      JointSliding(assembly).look(motion, &pressed);
      EXPECT_EQ(pressed.opening, 0.0) << face;
      EXPECT_NEAR(pressed.translation, 0.03 / diagonal_of(assembly.bricks), 1e-14);
    }
  }
}

// The step of promotion to large motion does not depend on the output of rows and frames.
TEST(SmallMotion, RowsAndFramesDoNotDecideWhenARunGoesOver) {
  const std::string text = stones(block("a", 0.0) + block("b", 0.2),
                                  "[[stage]]\nname = \"slide\"\ngravity = [0, -9.81, 0]\nduration = 0.1\n"
                                  "[[stage.velocity]]\nblock = \"b\"\nvelocity = [0.3, \"free\", 0]\n");
  std::optional<std::pair<long, std::uint64_t>> first;
  for (const std::vector<std::string>& output : {std::vector<std::string>{},
                                                 {"output.record_interval=1e-6"},
                                                 {"output.record_interval=0.03"},
                                                 {"output.record_interval=10", "output.frames=7"},
                                                 {"stage.slide.record_interval=777", "output.energy=true"}}) {
    std::vector<std::string> settings = output;
    settings.push_back("solver.rotation_bound=0.1");  // and that of the sway, so that sliding comes first
    Simulation simulation(scene_of(text, settings), 1);
    Seen seen;
    simulation.run(seen);
    ASSERT_EQ(seen.promotions, 1);
    const std::pair<long, std::uint64_t> found{simulation.outcome().promotion->step, simulation.hash()};
    if (!first) first = found;
    EXPECT_EQ(found, *first) << (output.empty() ? "" : output[0]);
    // The bound is 0.03 * 0.2 m: promotion is not before it, and less than a sixteenth of it later.
    const double slid = motion_seen(simulation).sliding;
    EXPECT_GE(slid, 0.03);
    EXPECT_LT(slid, 0.032);
  }
}

// Compression is positive in vertical_force_N for either side of a joint, in small displacements and in large motion.
// The base carries blocks a and b of 2000 * 0.008 * 9.81 = 157 N each; block b has a force of one weight. The tolerance
// of 30 % is for vibration of up to 23 % as they begin to slide; a wrong sign is an error of 200 %.
TEST(SmallMotion, TheVerticalForceKeepsItsSignInLargeMotion) {
  const double weight = 2000.0 * 0.008 * 9.81;
  const std::string text =
      stones(block("a", 0.0) + block("b", 0.2),
             "[[stage]]\nname = \"weight\"\ngravity = [0, -9.81, 0]\nduration = 0.2\nramp_time = 0.1\n"
             "[[stage]]\nname = \"slide\"\ngravity = [0, -9.81, 0]\nduration = 0.1\n"
             "[[stage.velocity]]\nblock = \"b\"\nvelocity = [0.3, \"free\", 0]\n");
  const std::pair<const char*, double> expected[] = {{"base", 2 * weight}, {"a", weight}, {"b", weight}};
  for (const auto& [monitor, force] : expected) {
    for (const char* kernels : {"automatic", "general"}) {
      Simulation simulation(scene_of(text, {std::string("output.monitor=") + monitor, "solver.stiffness_damping=1e-3",
                                            std::string("solver.kernels=") + kernels}),
                            1);
      Seen seen;
      simulation.run(seen);
      EXPECT_NE(simulation.large_motion(), nullptr);
      int rows = 0;
      for (const HistoryRow& row : seen.rows) {
        if (row.stage == 0) continue;
        ++rows;
        EXPECT_NEAR(row.vertical_force, force, 0.3 * force) << monitor << ' ' << kernels << " at " << row.time << " s";
      }
      EXPECT_GT(rows, 5);
    }
  }
}

// The kinetic energy of rows is equal with and without output.energy: that of the velocities at the time of the forces.
// A rigid block and a deformable one have initial velocities, on the lattice until one has passed the sliding bound.
TEST(SmallMotion, KineticEnergyIsTheSameWhateverIsWritten) {
  for (const char* damping : {"viscous", "block"}) {
    const std::string soft =
        "[[block]]\nname = \"s\"\nmaterial = \"stone\"\nrigid = false\ndivisions = [1, 1, 1]\n"
        "box = { lower = [0.3, 0, 0], size = [0.2, 0.2, 0.2] }\n";
    std::string text = stones(block("a", 0.0) + soft,
                              "[[stage]]\nname = \"throw\"\ngravity = [0, -9.81, 0]\nduration = 0.03\n"
                              "[[stage.velocity]]\nblock = \"a\"\nvelocity = [0.5, \"free\", 0]\n");
    if (damping == std::string("block"))
      text.replace(text.find("damping = \"viscous\""), text.find("[materials") - text.find("damping = \"viscous\""),
                   "damping = \"block\"\ndeformation_inertia = 16\n");
    std::vector<double> kinetic[2];
    for (const int with : {0, 1}) {
      Simulation simulation(scene_of(text, {fmt::format("output.energy={}", with == 1)}), 1);
      Seen seen;
      simulation.run(seen);
      EXPECT_NE(simulation.large_motion(), nullptr);
      for (const HistoryRow& row : seen.rows) kinetic[with].push_back(row.kinetic_energy);
    }
    EXPECT_EQ(kinetic[0], kinetic[1]) << damping;
    EXPECT_GT(*std::max_element(kinetic[0].begin(), kinetic[0].end()), 0.0);
  }
}

// No block is fixed, so all blocks fall. A stage that ends only at equilibrium must stop with a message.
TEST(Supports, AModelThatNothingHoldsSaysSo) {
  const std::string rest = falls("equilibrium_ratio = 1e-3");
  for (const char* kernels : {"automatic", "general"}) {
    const std::string of_kernels = std::string("solver.kernels=") + kernels;
    Simulation simulation(scene_of(stones(block("a", 0.0), rest, false), {of_kernels}), 1);
    Seen seen;
    try {
      simulation.run(seen);
      FAIL() << "came to rest";
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::numerical);
      EXPECT_THAT(error.what(), HasSubstr("nothing holds it"));
    }
    EXPECT_THAT(seen.warnings["free_fall"], HasSubstr("stage 'fall' holds nothing against gravity"));
    EXPECT_LT(simulation.time(), 0.7);  // a fall by the diagonal, 1.04 m, takes 0.46 s; by 1.7 m around spheres, 0.59 s
    RunInfo info;
    info.warnings = simulation.outcome().warnings;
    EXPECT_THAT(summary_text(simulation, seen.rows, info), HasSubstr("\"free_fall\""));
    const Supports supports = supports_in(simulation, 0);
    EXPECT_TRUE(supports.held.empty());
    EXPECT_EQ(supports.loose, (std::vector<int>{0, 1}));

    // A block that falls beside the base.
    Exit code{};
    const std::string beside =
        "[[block]]\nname = \"c\"\nmaterial = \"stone\"\nbox = { lower = [0.8, 0.1, 0], size = [0.2, 0.2, 0.2] }\n";
    EXPECT_THAT(fault_of(stones(block("a", 0.0) + beside, rest), {of_kernels}, &code), HasSubstr("block #2"));
    EXPECT_EQ(code, Exit::numerical);
    EXPECT_EQ(fault_of(stones(block("a", 0.0), rest), {of_kernels, "solver.mass_damping=50"}, &code), "");
    Simulation held(scene_of(stones(block("a", 0.0) + beside, rest), {of_kernels}), 1);
    EXPECT_EQ(supports_in(held, 0).held, std::vector<std::string>{"base: x y z"});
    EXPECT_EQ(supports_in(held, 0).loose, std::vector<int>{2});
  }
}

// A block that a stage moves by 5 m along x is free across; it has not left its supports. Of a fall along y it is
// warned.
TEST(Supports, AWayThatAStageImposesIsNoFall) {
  for (const auto& [velocity, warned] : {std::pair{"[10, \"free\", \"free\"]", false}, {"[\"free\", 10, 0]", false}}) {
    for (const char* kernels : {"automatic", "general"}) {
      Simulation simulation(
          scene_of(stones(block("a", 0.0), fmt::format("[[stage]]\nname = \"move\"\nduration = 0.5\n[[stage.velocity]]"
                                                       "\nblock = \"a\"\nvelocity = {}\n",
                                                       velocity)),
                   {std::string("solver.kernels=") + kernels}),
          1);
      Seen seen;
      simulation.run(seen);
      EXPECT_EQ(seen.warnings.contains("free_fall"), warned) << velocity << kernels;
    }
  }
}

// A block of 0.4 x 0.2 x 0.3 m lies on a fixed one of 1 x 0.2 x 1 m. A third one beside it stands on the last 0.2 m.
// Joints are given from either side.
TEST(JointSliding, IsMeasuredOverTheSidesOfTheJoint) {
  Assembly assembly;
  assembly.bricks.resize(3);
  assembly.bricks[0].size = {1.0, 0.2, 1.0}, assembly.bricks[0].fixed = true;
  assembly.bricks[1].origin = {0.1, 0.2, 0.1}, assembly.bricks[1].size = {0.4, 0.2, 0.3};
  assembly.bricks[2].origin = {0.8, 0.2, 0.1}, assembly.bricks[2].size = {0.5, 0.4, 0.3};
  assembly.joints = {{0, 1, 3, 0}, {2, 0, 2, 0}};  // upwards from the first; downwards from the third
  const auto look = [&](const WholeMotion& of_second, const WholeMotion& of_third, int upright = 1) {
    MotionSeen kept, recomputed;
    JointSliding(assembly).look({{}, of_second, of_third}, &kept, upright);
    JointSliding(assembly, JointSliding::Places::recomputed).look({{}, of_second, of_third}, &recomputed, upright);
    EXPECT_EQ(kept.sliding, recomputed.sliding);
    EXPECT_EQ(kept.opening, recomputed.opening);
    return kept;
  };
  const double diagonal = std::sqrt(1.3 * 1.3 + 0.6 * 0.6 + 1.0);
  MotionSeen seen = look({{4e-3, 0, 0}, {}}, {});
  EXPECT_NEAR(seen.sliding, 4e-3 / 0.4, 1e-15);
  EXPECT_EQ(seen.slid_joint, 0);
  EXPECT_NEAR(seen.translation, 4e-3 / diagonal, 1e-15);
  EXPECT_EQ(seen.moved_block, 1);
  EXPECT_NEAR(seen.sway, 4e-3 / 1.2, 1e-15) << "over both free blocks, from 0.1 to 1.3 m";
  EXPECT_EQ(seen.swaying_block, 1);
  EXPECT_EQ(seen.opening, 0.0);
  // Across, of the third: over 0.3 m along z, 0.2 m along x.
  seen = look({}, {{-1e-3, 2e-3, 3e-3}, {}});
  EXPECT_NEAR(seen.sliding, 3e-3 / 0.3, 1e-15);
  EXPECT_EQ(seen.slid_joint, 1);
  EXPECT_NEAR(seen.opening, 2e-3 / 0.2, 1e-15) << "over the shorter side";
  EXPECT_EQ(seen.opened_joint, 1);
  EXPECT_NEAR(seen.sway, 3e-3 / 0.3, 1e-15);
  EXPECT_EQ(seen.swaying_block, 2);
  EXPECT_NEAR(look({}, {{0, 0, -1e-3}, {}}).sway, 1e-3 / 0.3, 1e-15);
  EXPECT_NEAR(look({}, {{0, 2e-3, 0}, {}}, 2).sway, 2e-3 / 0.4, 1e-15) << "with the weight along z";
  EXPECT_EQ(look({}, {{0, 2e-3, 0}, {}}).sway, 0.0);
  // A rotation about z moves the foot of the second, 0.1 m below its centre, by 0.1 w along x.
  seen = look({{}, {0, 0, 4e-3}}, {});
  EXPECT_NEAR(seen.sliding, 4e-4 / 0.4, 1e-15);
  EXPECT_EQ(seen.rotation, 4e-3);
  EXPECT_EQ(seen.turned_block, 1);
  // The joint of the third is 0.15 m from its centre along x: about z it rises by 0.15 w and moves by 0.2 w.
  seen = look({}, {{}, {0, 0, -4e-3}});
  EXPECT_NEAR(seen.opening, 0.15 * 4e-3 / 0.2, 1e-15);
  EXPECT_NEAR(seen.sliding, 0.2 * 4e-3 / 0.2, 1e-15);
  EXPECT_NEAR(JointSliding(assembly).centre(1)[0], 0.9, 1e-15);
  EXPECT_NEAR(JointSliding(assembly).centre(1)[1], 0.2, 1e-15);
  EXPECT_NEAR(JointSliding(assembly).centre(1)[2], 0.25, 1e-15);
}

// Cubes of 0.2 m: h = 0.1 m. Two at 0.07 m may approach to 0.035 m. All numbers follow from the rule in the header.
class Unjoined : public ::testing::Test {
 protected:
  static constexpr double kSize = 0.2, kSlides = 0.03;
  double look(const Vec3& from, const WholeMotion& of_second, bool have_contact = true, double acceleration = 0.0) {
    Assembly assembly;
    assembly.bricks.resize(2);
    for (Brick& brick : assembly.bricks) brick.size = {kSize, kSize, kSize};
    assembly.bricks[1].origin = from;
    UnjoinedBlocks blocks(assembly);
    seen_ = {}, axis_ = -1;
    const auto ask = [&](int, int, int axis) { return axis_ = axis, have_contact; };
    const WholeMotion still{{}, {}, 0.3};
    for (const WholeMotion& motion : {WholeMotion{}, of_second})
      time_ = blocks.look({still, motion}, kSlides, acceleration, ask, &seen_);
    return time_;
  }
  MotionSeen seen_;
  double time_ = 0.0;
  int axis_ = -1;
};

TEST_F(Unjoined, BlocksMayApproachToHalfOfTheirDistance) {
  look({0, 0.27, 0}, {{0, -0.034, 0}, {}, 0.3});
  EXPECT_NEAR(seen_.gap, 0.036, 1e-12);
  EXPECT_NEAR(seen_.nearness, 0.035 / 0.036, 1e-12);
  EXPECT_EQ(seen_.near_block[0], 0);
  EXPECT_EQ(seen_.near_block[1], 1);
  EXPECT_NEAR(time_, (0.036 - 0.0175) / 0.6, 1e-12) << "to half of 0.035 m";
  // With an acceleration a: v t + a t^2/2 = way.
  const double t = look({0, 0.27, 0}, {{0, -0.034, 0}, {}, 0.3}, true, 2.0);
  EXPECT_NEAR(0.6 * t + t * t, 0.036 - 0.0175, 1e-12);
  // Corners come nearer under a rotation, by half of the diagonal of the faces.
  look({0, 0.27, 0}, {{0, -0.02, 0}, {0, 0.01, 0}, 0.3});
  EXPECT_NEAR(seen_.gap, 0.05 - 0.5 * 0.2 * std::sqrt(2.0) * 0.01, 1e-12);
  // About x the middle of the gap, 0.135 m below the centre of the upper block, moves along z alone.
  look({0, 0.27, 0}, {{0, -0.02, 0}, {0.01, 0, 0}, 0.3});
  EXPECT_NEAR(seen_.gap, 0.05 - 0.5 * 0.2 * std::sqrt(2.0) * 0.01, 1e-12);
  // Pairs that are not near yet: a quarter of h at twice the largest speed.
  EXPECT_NEAR(look({0, 0.5, 0}, {{}, {}, 0.5}), 0.025 / 1.0, 1e-12);
  EXPECT_EQ(seen_.nearness, 0.0);
}

TEST_F(Unjoined, BlocksThatAreNearLaterAreFound) {
  look({0, 0.4, 0}, {{0, -0.12, 0}, {}, 0.3});
  EXPECT_NEAR(seen_.gap, 0.08, 1e-12);
  EXPECT_NEAR(seen_.nearness, 0.05 / 0.08, 1e-12) << "half of h at most";
}

TEST_F(Unjoined, OnlyPairsWithContactCount) {
  look({0.27, 0, 0}, {{-0.04, 0, 0}, {}, 0.3}, false);
  EXPECT_EQ(axis_, 0);
  EXPECT_NEAR(seen_.nearness, 0.035 / 0.07, 1e-12) << "that of the start stays";
  look({0.27, 0, 0}, {{-0.04, 0, 0}, {}, 0.3}, true);
  EXPECT_NEAR(seen_.nearness, 0.035 / 0.03, 1e-12);
}

// Blocks that touch at an edge may overlap by 0.03 of 0.2 m.
TEST_F(Unjoined, BlocksAtAnEdgeMayOverlapByTheSlidingBound) {
  look({0.2, 0.2, 0}, {{-0.01, -0.003, 0}, {}, 0.3});
  EXPECT_NEAR(seen_.gap, -0.003, 1e-12);
  EXPECT_NEAR(seen_.nearness, 0.003 / 0.006, 1e-12);
  look({0.2, 0.2, 0}, {{-0.01, 0.003, 0}, {}, 0.3});
  EXPECT_EQ(seen_.nearness, 0.0) << "apart";
}

// A wall whose bottom beam a stage lets go.
TEST(Supports, AWallWithoutABottomBeamThatIsHeldSaysSo) {
  const std::string wall =
      "[materials.brick]\nyoung_modulus = 16.7e9\npoisson_ratio = 0.15\ndensity = 1900.0\n"
      "[joints.mortar]\nlaw = \"coulomb_slip\"\nnormal_stiffness = 82e9\nshear_stiffness = 36e9\nfriction_angle = 35\n"
      "[wall]\ncourses = 2\nunits_per_course = 1.5\nunit = [0.22, 0.0625, 0.1]\nzones = [1, 1, 1]\n"
      "mid_unit_joints = false\nunit_material = \"brick\"\nbed_joint = \"mortar\"\nhead_joint = \"mortar\"\n"
      "beam_joint = \"mortar\"\n[output]\nframes = 0\n"
      "[[stage]]\nname = \"own\"\nkind = \"custom\"\ngravity = [0, -9.81, 0]\nduration = 0.0005\n";
  const std::string held = "[[stage.control]]\nbody = \"bottom_beam\"\nvelocity = [0, 0, 0]\n",
                    free =
                        "[[stage.control]]\nbody = \"bottom_beam\"\nvelocity = [\"free\", \"free\", "
                        "\"free\"]\nrotation_held = false\n";
  for (const bool with : {false, true}) {
    for (const char* kernels : {"lattice", "general"}) {
      Simulation simulation(
          read_scene_text(wall + (with ? held : free), "wall.toml", {std::string("solver.kernels=") + kernels}), 1);
      Seen seen;
      simulation.run(seen);
      EXPECT_EQ(seen.warnings.contains("free_fall"), !with) << kernels;
      EXPECT_EQ(supports_in(simulation, 0).held.size(), with ? 1u : 0u);
      EXPECT_EQ(supports_in(simulation, 0).loose.empty(), with);
    }
  }
}

// A block of 0.2 x 0.4 m overturns at the multiplier 0.2/0.4. If the block does not carry the start multiplier, it
// moves because of the ramp. The result then has no multiplier: the ramp exceeds the answer or, if short, overturns the
// block dynamically from below it.
TEST(Collapse, AStartNearOrAboveTheAnswerGivesNoMultiplier) {
  const std::string tall =
      "[[block]]\nname = \"t\"\nmaterial = \"stone\"\nbox = { lower = [0, 0, 0], size = [0.2, 0.4, 0.2] }\n";
  const auto stages = [](double start, double ramp) {
    return fmt::format(
        "[[stage]]\nname = \"weight\"\ngravity = [0, -9.81, 0]\nramp_time = 0.1\nduration = 0.3\n"
        "[[stage]]\nname = \"tilt\"\nramp_time = {}\n"
        "collapse = {{ direction = [1, 0, 0], start = {}, rate = 0.05, displacement = 0.01, limit = 1.0 }}\n",
        ramp, start);
  };
  const auto run = [&](double start, double ramp, Seen* seen) {
    Simulation simulation(scene_of(stones(tall, stages(start, ramp)),
                                   {"joints.dry.friction_angle=45", "joints.dry.normal_stiffness=1e9"}),
                          1);
    simulation.run(*seen);
    return simulation.outcome().collapse_multiplier;
  };
  for (const double start : {0.0, 0.2, 0.4, 0.499}) {
    Seen seen;
    const std::optional<double> multiplier = run(start, 0.5, &seen);
    ASSERT_TRUE(multiplier) << start;
    std::printf("from %g: %.4f\n", start, *multiplier);
    EXPECT_NEAR(*multiplier, 0.5, 0.03) << start;
    EXPECT_FALSE(seen.warnings.contains("collapse_multiplier"));
  }
  for (const auto& [start, ramp] : {std::pair{0.8, 0.5}, {0.6, 2.0}, {0.49, 0.01}}) {
    Seen seen;
    EXPECT_EQ(run(start, ramp, &seen), std::nullopt) << start;
    EXPECT_THAT(seen.warnings["collapse_multiplier"], HasSubstr("before they came to rest under collapse.start"));
  }
}

// This block with a load that waits for equilibrium. The result is within 1 % of 0.5 from any start below, with the lag
// printed; a start above the answer is reported.
TEST(Collapse, ALoadThatWaitsIsNoFurtherAheadThanItSays) {
  const auto run = [&](double start, double displacement, Seen* seen, Outcome* outcome) {
    const std::string tall =
        "[[block]]\nname = \"t\"\nmaterial = \"stone\"\nbox = { lower = [0, 0, 0], size = [0.2, 0.4, 0.2] }\n";
    const std::string stages = fmt::format(
        "[[stage]]\nname = \"weight\"\ngravity = [0, -9.81, 0]\nramp_time = 0.1\nduration = 0.3\n"
        "[[stage]]\nname = \"tilt\"\n"
        "collapse = {{ direction = [1, 0, 0], start = {}, rate = \"auto\", displacement = {}, limit = 1.0 }}\n",
        start, displacement);
    Simulation simulation(
        scene_of(stones(tall, stages), {"joints.dry.friction_angle=45", "joints.dry.normal_stiffness=1e9"}), 1);
    simulation.run(*seen);
    *outcome = simulation.outcome();
    return collapse_lag(simulation.scene(), outcome->collapse_multiplier);
  };
  for (const auto& [start, displacement] : {std::pair{0.3, 0.01}, {0.45, 0.01}, {0.45, 0.05}}) {
    Seen seen;
    Outcome outcome;
    const auto lag = run(start, displacement, &seen, &outcome);
    ASSERT_TRUE(outcome.collapse_multiplier && lag) << start;
    std::printf("from %g to %g m: %.4f, lag %.4f\n", start, displacement, *outcome.collapse_multiplier, *lag);
    EXPECT_NEAR(*outcome.collapse_multiplier, 0.5, 0.005) << start;
    EXPECT_GE(*lag, 0.0);
    EXPECT_LE(*lag, 0.006 * *outcome.collapse_multiplier);
    EXPECT_LE(*outcome.collapse_multiplier - *lag, 0.5);  // without the lag: a load that the block carries
  }
  for (const double start : {0.51, 0.6, 0.8}) {
    Seen seen;
    Outcome outcome;
    run(start, 0.01, &seen, &outcome);
    EXPECT_FALSE(outcome.collapse_multiplier.has_value()) << start;
    EXPECT_THAT(seen.warnings["collapse_multiplier"], HasSubstr("before they came to rest under collapse.start"));
  }
}

TEST(Supports, GroundThatMovesNeedsAFixedBlock) {
  const std::string quake =
      "[[stage]]\nname = \"quake\"\ngravity = [0, -9.81, 0]\nduration = 0.01\n"
      "ground_motion = { direction = [1, 0, 0], time = [0, 0.01], acceleration = [1, 1] }\n";
  Exit code{};
  EXPECT_THAT(fault_of(stones(block("a", 0.0), quake, false), {}, &code), HasSubstr("none is fixed"));
  EXPECT_EQ(code, Exit::bad_input);
  EXPECT_EQ(fault_of(stones(block("a", 0.0), quake), {}, &code), "");
}

}  // namespace
}  // namespace quoin
