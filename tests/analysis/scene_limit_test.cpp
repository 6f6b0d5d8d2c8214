// Limit analysis of scenes: which contact points count. Closed forms and symmetry; multipliers to 1e-4, since whole
// cones are solved to 1e-5.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "../scene_of_text.h"
#include "analysis/limit_of_scene.h"
#include "base/error.h"
#include "step/simulation.h"

namespace quoin {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string head(double friction_angle) {
  return fmt::format(R"([materials.stone]
density = 2000
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 4e8
friction_angle = {}
)",
                     friction_angle);
}

std::string block(const std::string& name, const std::string& keys, bool fixed = false) {
  return fmt::format("[[block]]\nname = \"{}\"\nmaterial = \"stone\"\nfixed = {}\n{}\n", name, fixed, keys);
}

SceneLimit limit_of_text(const std::string& text, const std::vector<double>& direction, double given = 0.0) {
  const Simulation simulation(scene_of_text(text + "[[stage]]\ngravity = [0, -9.81, 0]\nduration = 0.1\n"), 1);
  LimitOptions options;
  options.direction = direction, options.given = given, options.associated = true;
  return limit_of(simulation, options);
}

double multiplier_of(const std::string& text, const std::vector<double>& direction) {
  const SceneLimit limit = limit_of_text(text, direction);
  return limit.limit ? limit.limit->multiplier : std::nan("");
}

// A prism of 1 x 1 x 2 m on a cube. Corners are 10 um beside the planes of the others, a tenth of the joint tolerance.
// The prism turns over at 1/2 of its weight, from edges that are 10 um away over 2 m at most.
TEST(LimitOfScene, RoundedCornersLeaveAJointWhole) {
  const std::string text =
      head(45.0) +
      block("low",
            "vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 1e-5], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1.00001, 1], "
            "[0, 1, 1]]",
            true) +
      block("up",
            "vertices = [[0, 1, 0], [1, 1, 1e-5], [1, 3, 0], [0, 3, 0], [0, 1, 1], [1, 1.00001, 1], [1, 3, 1], "
            "[0, 3, 1]]");
  for (const auto& way : std::vector<std::vector<double>>{{1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}}) {
    const SceneLimit limit = limit_of_text(text, way);
    EXPECT_EQ(limit.point_count, 4u);
    double area = 0.0;
    for (const LimitPoint& p : limit.problem.points) area += p.area;
    EXPECT_NEAR(area, 1.0, 4e-5) << "four sides of 1 m, each moved by 10 um at most";
    ASSERT_TRUE(limit.limit);
    EXPECT_NEAR(limit.limit->multiplier, 0.5, 1e-4);
  }
}

// Two bricks that meet along an edge, one of them 10 um too long: their beds overlap by a strip of that width, which
// carries nothing. A strip ten times as wide as the tolerance of 10 um is a joint.
TEST(LimitOfScene, StripsOfRoundingAreNoJoints) {
  const auto bricks = [](double beyond) {
    return head(30.0) +
           block(
               "a",
               fmt::format("rotation = [0, 0, 10]\nbox = {{ lower = [0, 0, 0], size = [{}, 0.1, 0.2] }}", 0.3 + beyond),
               true) +
           block("b", "rotation = [0, 0, 10]\nbox = { lower = [0.3, 0.1, 0], size = [0.3, 0.1, 0.2] }");
  };
  EXPECT_THAT(
      [&] {
        limit_of_text(bricks(0.9e-5), {1, 0, 0});
      },
      testing::ThrowsMessage<Error>(testing::HasSubstr("no chain of joints")));
  EXPECT_EQ(limit_of_text(bricks(1e-4), {1, 0, 0}).point_count, 4u);
}

// A cube that hovers by 1 mm above another, 10 times the joint tolerance.
TEST(LimitOfScene, OpenPointsCarryNothing) {
  const auto cubes = [](double gap) {
    return head(35.0) + block("low", "box = { lower = [0, 0, 0], size = [1, 1, 1] }", true) +
           block("up", fmt::format("box = {{ lower = [0, {}, 0], size = [1, 1, 1] }}", 1.0 + gap));
  };
  EXPECT_NEAR(multiplier_of(cubes(0.0), {1, 0, 0}), std::tan(35.0 * kDegree), 1e-4);
  EXPECT_THAT(
      [&] {
        limit_of_text(cubes(1e-3), {1, 0, 0});
      },
      testing::ThrowsMessage<Error>(testing::HasSubstr("no chain of joints")));
}

// A cube on its edge, turned by 60 degrees, which rests on the edge of another: no normal is that of the contact.
// Across the middle of the face, it is that of the face, and the cube falls over.
TEST(LimitOfScene, EdgesOnEdgesAreNoContacts) {
  const auto turned = [](double x) {
    return head(35.0) + block("low", "box = { lower = [0, 0, 0], size = [1, 1, 1] }", true) +
           block("up", fmt::format("box = {{ lower = [0, 0, 0], size = [1, 1, 1] }}\nposition = [{}, 1, 0]\n"
                                   "rotation = [0, 0, 60]",
                                   x));
  };
  EXPECT_THAT(
      [&] {
        limit_of_text(turned(1.0), {1, 0, 0});
      },
      testing::ThrowsMessage<Error>(testing::HasSubstr("no chain of joints")));
  const SceneLimit across = limit_of_text(turned(0.5), {1, 0, 0});
  EXPECT_GT(across.point_count, 0u);
  EXPECT_FALSE(across.stands.stands);
}

// A cross vault over a square bay is the same along x and z. The multiplier of an independent linear programme on the
// faces alone, with pyramids of 48 facets around the cones (within 1/cos(pi/48) = 1.002), is 0.66553.
TEST(LimitOfScene, ACrossVaultIsSymmetric) {
  constexpr int kCourses = 9;
  constexpr double kLow = 20.0 * kDegree, kStep = (std::numbers::pi - 2 * kLow) / kCourses, kInner = 1.85,
                   kOuter = 2.15;
  std::string text = head(35.0);
  for (int web = 0; web < 4; ++web) {
    const double cosine = std::array{1, 0, -1, 0}[size_t(web)], sine = std::array{0, 1, 0, -1}[size_t(web)];
    for (int course = -1; course <= kCourses; ++course) {
      std::string points;
      const auto add = [&](double x, double y, double z) {
        points += fmt::format("[{:.17g}, {:.17g}, {:.17g}], ", cosine * x - sine * z, y, sine * x + cosine * z);
      };
      for (const double r : {kInner, kOuter}) {
        for (const double a : {kLow + course * kStep, kLow + (course + 1) * kStep})
          add(r * std::cos(a), r * std::sin(a), std::abs(r * std::cos(a))),
              add(r * std::cos(a), r * std::sin(a), kOuter);
        if (course == kCourses / 2) add(0.0, r * std::sin(kLow + (course + 1) * kStep), 0.0);
      }
      text += block(fmt::format("{}/{}", web, course), "vertices = [" + points + "]", course < 0 || course == kCourses);
    }
  }
  const double along_x = multiplier_of(text, {1, 0, 0});
  EXPECT_NEAR(along_x, 0.66553, 2e-3 * 0.66553);
  for (const auto& way : std::vector<std::vector<double>>{{-1, 0, 0}, {0, 0, 1}, {0, 0, -1}})
    EXPECT_NEAR(multiplier_of(text, way), along_x, 1e-4);
}

// A block on a plane is pushed by a part of its weight. It stands with the part over the friction that it has, however
// small the part is, and slides at tan(phi).
TEST(LimitOfScene, OneBlockNeedsTheFrictionOfItsPush) {
  for (const double angle : {8.0, 30.0, 45.0}) {
    const std::string text = head(angle) +
                             block("base", "box = { lower = [-5, -0.2, -5], size = [12, 0.2, 12] }", true) +
                             block("b", "box = { lower = [0, 0, 0], size = [1, 0.5, 1] }");
    const double friction = std::tan(angle * kDegree);
    for (const double given : {0.01, 0.05, 0.1}) {
      const SceneLimit limit = limit_of_text(text, {1, 0, 0}, given);
      EXPECT_TRUE(limit.stands.stands) << angle << " degrees, " << given;
      ASSERT_TRUE(limit.stands.friction && limit.limit);
      EXPECT_NEAR(*limit.stands.friction, given / friction, 2e-3 * given / friction) << "accurate to 0.1 %";
      EXPECT_NEAR(limit.limit->multiplier, friction, 1e-4);
    }
  }
}

// A law may have no strength in compression; a block on such joints does not stand. The message said "a strength below
// 0".
TEST(LimitOfScene, JointsWithoutCompressiveStrengthAreNamed) {
  const std::string text = R"([materials.stone]
density = 2000
[joints.soft]
law = "fracture_energy"
normal_stiffness = 1e9
shear_stiffness = 4e8
friction_angle = 30
compressive_strength = 0.0
)" + block("base", "box = { lower = [-5, -0.2, -5], size = [12, 0.2, 12] }", true) +
                           block("b", "box = { lower = [0, 0, 0], size = [1, 0.5, 1] }");
  try {
    limit_of_text(text, {1, 0, 0});
    ADD_FAILURE() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::bad_input);
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("joints.soft: compressive_strength = 0 Pa"),
                                             testing::HasSubstr("leave it out")));
  }
}

// A pressure acts on the top beam, a mass at a point beside it. Overturning of both about the right edge, by hand:
// (50000 0.5 + 9810 0.5 + 3850.4 0.5 + 3850.4 0.2)/(9810 0.5 + 2 3850.4 1.05) = 2.510, up to the corner of the joint.
// The pressure had moved to the common centre of mass: 1.932.
TEST(LimitOfScene, APointMassLeavesThePressureWhereItIs) {
  const Simulation simulation(scene_of_text(R"([materials.m]
density = 2000.0
young_modulus = 1e9
poisson_ratio = 0.2
[joints.d]
law = "coulomb_slip"
normal_stiffness = 1e10
shear_stiffness = 5e9
friction_angle = 60.0
[wall]
courses = 1
units_per_course = 1
unit = [1.0, 1.0, 0.5]
mid_unit_joints = false
rigid_units = true
unit_material = "m"
bed_joint = "d"
head_joint = "d"
beam_joint = "d"
[[mass]]
block = "top_beam"
mass = 392.5
point = [0.8, 1.05, 0.25]
[[stage]]
kind = "pressure"
pressure = 1e5
[[stage]]
name = "c"
gravity = [0, -9.81, 0]
collapse = { direction = [1, 0, 0], start = 0.1, rate = 0.1 }
)"),
                              1);
  LimitOptions options;
  options.associated = true;
  const SceneLimit limit = limit_of(simulation, options);
  ASSERT_TRUE(limit.limit);
  EXPECT_NEAR(limit.limit->multiplier, 2.510, 2e-3);
}

// The stage of collapse holds a slab along x and z. It lies on an equal plate, which slides between two faces at
// (W + 2 W) tan(35)/W. The slab counted as free and slid first, at tan(35).
TEST(LimitOfScene, WhatTheStageOfCollapseHoldsIsHeld) {
  const auto multiplier = [](const std::string& held) {
    const Simulation simulation(
        scene_of_text(head(35.0) + block("base", "box = { lower = [-5, -0.2, -5], size = [12, 0.2, 12] }", true) +
                      block("plate", "box = { lower = [0, 0, 0], size = [4, 0.4, 4] }") +
                      block("slab", "box = { lower = [0, 0.4, 0], size = [4, 0.4, 4] }") + R"([[stage]]
name = "push"
gravity = [0, -9.81, 0]
collapse = { direction = [1, 0, 0], start = 0.1, rate = 0.1 }
)" + held),
        1);
    return limit_of(simulation, {}).limit->multiplier;
  };
  const double friction = std::tan(35.0 * kDegree);
  EXPECT_NEAR(multiplier(""), friction, 1e-4);
  EXPECT_NEAR(multiplier("[[stage.velocity]]\nblock = \"slab\"\nvelocity = [0, \"free\", 0]\n"), 3.0 * friction, 3e-4);
}

// Stages of the given text; `multiplied` of their loads.
SceneLimit limit_of_loads(const std::string& text, Multiplied multiplied, double given = 0.0, bool associated = true) {
  const Simulation simulation(for_limit(scene_of_text(text), multiplied), 1);
  LimitOptions options;
  options.multiplied = multiplied, options.given = given, options.associated = associated;
  return limit_of(simulation, options);
}

const std::string kBase = block("base", "box = { lower = [-5, -0.2, -5], size = [12, 0.2, 12] }", true);
const std::string kPushed = "[[stage]]\nname = \"push\"\ngravity = [0, -9.81, 0]\nduration = 0.1\n";

// A block of 1 x 2 x 1 m is pushed by a force F at height h. It slides at F = mu W, or topples at F = W b/(2h).
TEST(LimitOfScene, AForceMovesABlockAtTheLesserOfSlidingAndToppling) {
  const double weight = 2000.0 * 2.0 * 9.81, force = 1000.0, friction = std::tan(30.0 * kDegree);
  for (const double h : {0.4, 0.8, 0.9, 1.3, 2.0}) {
    const SceneLimit limit = limit_of_loads(
        head(30.0) + kBase + block("b", "box = { lower = [0, 0, 0], size = [1, 2, 1] }") + kPushed +
            fmt::format("[[stage.force]]\nblock = \"b\"\npoint = [0, {}, 0.5]\nforce = [{}, 0, 0]\n", h, force),
        Multiplied::forces);
    ASSERT_TRUE(limit.limit) << h;
    const bool slides = friction < 0.5 / h;
    EXPECT_NEAR(limit.limit->multiplier, weight * std::min(friction, 0.5 / h) / force, 1e-4 * weight / force) << h;
    const std::vector<JointMotion> joints = joint_motions(limit);
    ASSERT_EQ(joints.size(), 1u);
    EXPECT_EQ(limit.families[size_t(joints[0].family)], "dry");
    EXPECT_EQ(joints[0].hinges, !slides) << h;
    EXPECT_NEAR(slides ? joints[0].sliding : joints[0].opening, 1.0, 1e-6) << h;
    EXPECT_EQ(slides ? joints[0].opening : joints[0].sliding, 0.0) << h << ": below 1e-3";
  }
}

// A force F lifts a block of weight W at W/F. At an edge it needs W/(2F), and the other edge is a hinge.
TEST(LimitOfScene, AJointThatOpensAllOverHasNoHinge) {
  const double weight = 2000.0 * 2.0 * 9.81;
  for (const bool at_edge : {false, true}) {
    const SceneLimit limit =
        limit_of_loads(head(30.0) + kBase + block("b", "box = { lower = [0, 0, 0], size = [1, 2, 1] }") + kPushed +
                           fmt::format("[[stage.force]]\nblock = \"b\"\npoint = [{}, 2, 0.5]\nforce = [0, 1000, 0]\n",
                                       at_edge ? 1.0 : 0.5),
                       Multiplied::forces);
    ASSERT_TRUE(limit.limit);
    EXPECT_NEAR(limit.limit->multiplier, weight / 1000.0 * (at_edge ? 0.5 : 1.0), 1e-3) << at_edge;
    const std::vector<JointMotion> joints = joint_motions(limit);
    ASSERT_EQ(joints.size(), 1u);
    EXPECT_EQ(joints[0].hinges, at_edge);
    EXPECT_NEAR(joints[0].opening, 1.0, 1e-6);
    EXPECT_EQ(joints[0].sliding, 0.0);
    EXPECT_EQ(joints[0].crushing, 0.0);
  }
}

// Joints of blocks 1 to 5 on block 0, of friction 0.5, with points 1 m apart. Rates are over the largest, of 1 m/s.
// Block 1 turns about its left point, 2 slides up its dilation, 3 slides and is pressed in. 4 and 5 lift by about 1e-3.
TEST(LimitOfScene, RatesOfJointsAreOverTheLargest) {
  using geometry::Vector;
  const Vector velocities[] = {
      {}, {-0.4, 0.4, 0}, {1, 0.5, 0}, {0.2, -0.3, 0}, {0, 0.9e-3, 0}, {0, 1.1e-3, 0}, {0, 0.9e-4, 0}};
  SceneLimit limit;
  limit.limit.emplace();
  limit.families = {"dry"};
  for (int b = 0; b < 7; ++b) {
    limit.problem.blocks.push_back({{0.5, 0.5, 0}, b == 0, {}, {}});
    limit.limit->velocity.push_back({velocities[b], {0, 0, b == 1 ? 0.8 : 0.0}});
    limit.names.push_back(""), limit.labels.push_back("");
    for (int end = 0; end < 2 && b > 0 && b < 6; ++end)
      limit.problem.points.push_back({0, b, {double(end), 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0.5});
  }
  for (LimitPoint& p : limit.problem.points) p.family = 0;
  limit.point_count = limit.problem.points.size();
  const struct {
    int block;
    double opening, sliding, crushing;
    const char* text;
  } expected[] = {{2, 0, 1, 0, "slides"},
                  {1, 0.8, 0, 0, "hinges"},
                  {3, 0, 0.2, 0.3, "slides and crushes"},
                  {5, 1.1e-3, 0, 0, "opens"}};
  const std::vector<JointMotion> joints = joint_motions(limit);
  const auto json = json_of("", limit, {})["moving_joints"];
  ASSERT_EQ(joints.size(), std::size(expected));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    EXPECT_EQ(joints[i].b, expected[i].block);
    EXPECT_NEAR(joints[i].opening, expected[i].opening, 1e-15) << i;
    EXPECT_NEAR(joints[i].sliding, expected[i].sliding, 1e-15) << i;
    EXPECT_NEAR(joints[i].crushing, expected[i].crushing, 1e-15) << i;
    EXPECT_EQ(json[i]["motion"], expected[i].text);
  }
  limit.margin = -0.9e-6;
  EXPECT_EQ(moving_without_load(limit), (std::vector{1, 2, 3, 4, 5}));
  limit.margin = 1.1e-6;
  EXPECT_TRUE(moving_without_load(limit).empty());
}

// A wall of height H and thickness b has a constant force P on top. A lateral pressure p turns it over: p H^2/2 =
// W b/2 + P b/2. Where P grows with p from P0 and p0: p (H^2/2 - P0/p0 b/2) = W b/2.
TEST(LimitOfScene, APressureTurnsAWallOver) {
  const double height = 2.0, b = 0.5, weight = 2000.0 * 9.81 * height * b, top = 3000.0, pressure = 500.0;
  const std::string text = head(60.0) + kBase + block("wall", "box = { lower = [0, 0, 0], size = [0.5, 2, 1] }") +
                           kPushed +
                           "[[stage.pressure]]\nblock = \"wall\"\nnormal = [-1, 0, 0]\npressure = 500\n"
                           "[[stage.force]]\nblock = \"wall\"\npoint = [0.25, 2, 0.5]\nforce = [0, -3000, 0]\n";
  const double overturns = pressure * height * height / 2.0;
  EXPECT_NEAR(limit_of_loads(text, Multiplied::pressures).limit->multiplier, (weight + top) * b / 2.0 / overturns,
              1e-3);
  EXPECT_NEAR(limit_of_loads(text, Multiplied::loads).limit->multiplier, weight * b / 2.0 / (overturns - top * b / 2.0),
              2e-2);
  const SceneLimit given = limit_of_loads(text, Multiplied::pressures, 2.0);
  EXPECT_NEAR(given.limit->multiplier, (weight + top) * b / 2.0 / overturns, 1e-3);
  EXPECT_NEAR(*given.margin, given.limit->multiplier - 2.0, 1e-9);
}

// A flat arch of two blocks, of length 1 and height 0.4 m, between ends of the same size.
std::string flat_arch(bool left_is_fixed, bool right_is_fixed) {
  return head(45.0) + block("left", "box = { lower = [-1, 0, 0], size = [1, 0.4, 1] }", left_is_fixed) +
         block("a", "box = { lower = [0, 0, 0], size = [1, 0.4, 1] }") +
         block("b", "box = { lower = [1, 0, 0], size = [1, 0.4, 1] }") +
         block("right", "box = { lower = [2, 0, 0], size = [1, 0.4, 1] }", right_is_fixed) + kPushed;
}

// One end of a flat arch of two blocks, of length a and height h, yields. Thrust H rises from the lower edge at the
// ends to the upper edge in the middle: w a/2 = H h. Friction at the ends carries w with less thrust.
TEST(LimitOfScene, ASupportYieldsAtTheThrustOfTheArch) {
  const double a = 1.0, h = 0.4, weight = 2000.0 * 9.81 * a * h;
  const std::string arch = flat_arch(true, false) +
                           "[[stage.velocity]]\nblock = \"right\"\nvelocity = [\"free\", 0, 0]\n"
                           "[[stage.force]]\nblock = \"right\"\npoint = [3, 0.2, 0.5]\nforce = [1000, 0, 0]\n";
  const SceneLimit limit = limit_of_loads(arch, Multiplied::forces, -30.0);  // held by 30 kN
  ASSERT_TRUE(limit.limit);
  EXPECT_NEAR(limit.limit->multiplier, -weight * a / (2.0 * h) / 1000.0, 1e-3);
  const std::vector<JointMotion> joints = joint_motions(limit);
  ASSERT_EQ(joints.size(), 3u);
  for (const JointMotion& joint : joints) EXPECT_TRUE(joint.hinges);
  EXPECT_FALSE(limit_of_loads(arch, Multiplied::forces).stands.stands) << "nothing holds the arch";
}

// The same where the stage moves the end outwards: the thrust that is left acts against the motion.
TEST(LimitOfScene, AMotionHasTheForceAlongIt) {
  const double a = 1.0, h = 0.4, weight = 2000.0 * 9.81 * a * h;
  const std::string velocity = "[[stage.velocity]]\nblock = \"right\"\nvelocity = [0.01, 0, 0]\n";
  for (const bool fixed : {false, true}) {
    const SceneLimit limit = limit_of_loads(flat_arch(true, fixed) + velocity, Multiplied::motion, 0.0, false);
    EXPECT_TRUE(limit.stands.stands) << "the end is held until it moves";
    ASSERT_TRUE(limit.limit) << fixed;
    EXPECT_NEAR(limit.limit->multiplier, -weight * a / (2.0 * h), 1e-4 * weight) << fixed;
    EXPECT_EQ(joint_motions(limit).size(), 3u);
    EXPECT_TRUE(moving_without_load(limit).empty()) << "the thrust resists";
    ASSERT_TRUE(limit.without_dilation && limit.without_dilation->settled) << "multipliers below 0 rose as if by jumps";
    EXPECT_NEAR(limit.without_dilation->multiplier, limit.limit->multiplier, 2e-3 * weight) << "hinges alone";
  }
  EXPECT_THAT([] { multiplied_named("settlement"); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("A displacement has no multiplier")));
}

// Both ends move outwards, so that no block is fixed: each has the thrust w a/(2h).
TEST(LimitOfScene, SupportsThatMoveHoldTheOthers) {
  const double weight = 2000.0 * 9.81 * 0.4;
  const SceneLimit limit = limit_of_loads(flat_arch(true, true) +
                                              "[[stage.velocity]]\nblock = \"left\"\nvelocity = [-0.01, 0, 0]\n"
                                              "[[stage.velocity]]\nblock = \"right\"\nvelocity = [0.01, 0, 0]\n",
                                          Multiplied::motion);
  ASSERT_TRUE(limit.limit);
  EXPECT_NEAR(limit.limit->multiplier, -2.0 * weight / (2.0 * 0.4), 1e-4 * weight);
}

// Forces are those of the whole wall, of which half is modelled.
TEST(LimitOfScene, HalfOfAWallHasTheForceOfTheWhole) {
  std::vector<double> found;
  for (const char* half : {"true", "false"}) {
    const Simulation simulation(read_scene(QUOIN_SCENES "/wall_2m_60.toml", {std::string("wall.half_thickness=") + half,
                                                                             "wall.zones=[2, 2, 2]", "wall.courses=4"}),
                                1);
    LimitOptions options;
    options.multiplied = Multiplied::motion, options.associated = true;
    const SceneLimit limit = limit_of(simulation, options);
    ASSERT_TRUE(limit.limit);
    found.push_back(limit.limit->multiplier);
  }
  EXPECT_NEAR(found[0], found[1], 1e-4 * found[1]);
}

// A slab of length L rests on piers of width c, one of which settles. The slab turns about the inner edge of the other
// and rests with its end on this one: R = W (L/2 - c)/(L - c). R and the pier's weight act along the motion.
TEST(LimitOfScene, ASupportThatSettlesKeepsItsLeastReaction) {
  const double length = 4.0, c = 0.5, slab = 2000.0 * 9.81 * length * 0.4, pier = 2000.0 * 9.81 * c;
  const SceneLimit limit =
      limit_of_loads(head(30.0) + block("left", "box = { lower = [0, -1, 0], size = [0.5, 1, 1] }", true) +
                         block("right", "box = { lower = [3.5, -1, 0], size = [0.5, 1, 1] }", true) +
                         block("slab", "box = { lower = [0, 0, 0], size = [4, 0.4, 1] }") + kPushed +
                         "[[stage.velocity]]\nblock = \"right\"\nvelocity = [0, -0.001, 0]\n",
                     Multiplied::motion);
  ASSERT_TRUE(limit.limit);
  const double reaction = slab * (length / 2.0 - c) / (length - c);
  EXPECT_NEAR(limit.limit->multiplier, -(reaction + pier), 1e-4 * slab);
}

// A block of weight W moves at half of the speed of one of 2 W. The force at the speed of the faster has the power of
// both: mu (2 W + W/2). One alone that may turn topples at W b/(2h), where h is the height of its centre.
TEST(LimitOfScene, BodiesThatMoveTogetherShareTheForce) {
  const double weight = 2000.0 * 9.81, friction = std::tan(20.0 * kDegree);
  const auto velocity = [](const std::string& name, double speed, const char* more = "") {
    return fmt::format("[[stage.velocity]]\nblock = \"{}\"\nvelocity = [{}, \"free\", \"free\"]\n{}", name, speed,
                       more);
  };
  const SceneLimit slides =
      limit_of_loads(head(20.0) + kBase + block("a", "box = { lower = [0, 0, 0], size = [1, 1, 1] }") +
                         block("b", "box = { lower = [3, 0, 0], size = [1, 2, 1] }") + kPushed + velocity("a", 0.01) +
                         velocity("b", 0.02),
                     Multiplied::motion);
  ASSERT_TRUE(slides.limit);
  EXPECT_NEAR(slides.limit->multiplier, 2.5 * weight * friction, 1e-4 * weight);
  const SceneLimit topples =
      limit_of_loads(head(60.0) + kBase + block("b", "box = { lower = [0, 0, 0], size = [1, 2, 1] }") + kPushed +
                         velocity("b", 0.01, "rotation_held = false\n"),
                     Multiplied::motion);
  ASSERT_TRUE(topples.limit);
  EXPECT_NEAR(topples.limit->multiplier, 2.0 * weight * 0.5 / 1.0, 1e-4 * weight);
}

// A pier of five blocks, 0.4 m wide, under equal forces F/2 at the middle of its third and fifth course. They carry 1
// kN and 3 kN in the middle. It turns about its foot: F (0.5 + 0.9)/2 = (W + 4 kN) 0.2.
TEST(LimitOfScene, AWhiffletreePushesFloorsEqually) {
  const auto floor = [](const std::string& name, int course, double load) {
    return fmt::format(
        "[[building.floor]]\nname = \"{}\"\nwall = \"D\"\ncourse = {}\nhalf_units = [0]\n"
        "rigid_beams = false\nload = {}\n",
        name, course, load);
  };
  const SceneLimit limit =
      limit_of_loads(R"([materials.stone]
density = 2000
young_modulus = 2e9
poisson_ratio = 0.2
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e10
shear_stiffness = 4e9
friction_angle = 60
[building]
courses = 5
course_height = 0.2
thickness = 0.5
zones = [2, 2, 2]
unit_material = "stone"
bed_joint = "dry"
head_joint = "dry"
unit_joint = "dry"
beam_joint = "dry"
[[building.wall]]
name = "D"
axis = "x"
start = [0.0, 0.0]
half_units = 1
half_unit = 0.4
)" + floor("middle", 2, 1000.0) +
                         floor("roof", 4, 3000.0) +
                         "[[stage]]\nkind = \"weight\"\nduration = 0.2\n[[stage]]\nkind = \"push\"\n"
                         "velocity = 0.02\nstiffness = 1e8\ndisplacement = 0.025\n",
                     Multiplied::motion);
  ASSERT_TRUE(limit.limit);
  const double weight = 2000.0 * 9.81 * 0.4 * 0.5 * 1.0;
  EXPECT_NEAR(limit.limit->multiplier, (weight + 4000.0) * 0.2 / 0.7, 1e-4 * weight);
}

// Loads of the named stage count, else of the first that has some.
TEST(LimitOfScene, TheStageOfTheLoadsIsGiven) {
  const auto stage = [](const std::string& name, double force) {
    return fmt::format(
        "[[stage]]\nname = \"{}\"\ngravity = [0, -9.81, 0]\nduration = 0.1\n[[stage.force]]\n"
        "block = \"b\"\npoint = [0, 0.1, 0.5]\nforce = [{}, 0, 0]\n",
        name, force);
  };
  const Simulation simulation(
      scene_of_text(head(30.0) + kBase + block("b", "box = { lower = [0, 0, 0], size = [1, 1, 1] }") +
                    stage("one", 1000.0) + stage("two", 4000.0)),
      1);
  LimitOptions options;
  options.multiplied = Multiplied::forces, options.associated = true;
  const double first = limit_of(simulation, options).limit->multiplier;
  options.stage = &simulation.scene().stages[1];
  EXPECT_NEAR(limit_of(simulation, options).limit->multiplier, first / 4.0, 1e-4);
  options.multiplied = Multiplied::pressures;
  EXPECT_THAT([&] { limit_of(simulation, options); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("the stage has no pressures to multiply")));
}

// Stones on which the interior point method stalled in units of the supports' weight. Pyramids of 32 facets give
// 0.77915 to 0.790 by their orientation, an independent linear programme with 1024 facets 0.7900 (four digits).
TEST(LimitOfScene, WholeConesSolveRubble) {
  const Simulation simulation(read_scene(QUOIN_RUBBLE), 1);
  LimitOptions options;
  options.direction = {-0.3512590748204204, 0.10661449342949125, -0.98794242465224136}, options.associated = true;
  const SceneLimit limit = limit_of(simulation, options);
  ASSERT_TRUE(limit.limit);
  EXPECT_EQ(limit.limit->facets, 0);
  EXPECT_NEAR(limit.limit->multiplier, 0.7900, 1.5e-4);
}

}  // namespace
}  // namespace quoin
