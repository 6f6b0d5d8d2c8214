// Floors, beams and walls in limit analysis, against mechanisms computed by hand. Tolerance 1e-4 of the linear
// programme unless stated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/limit_of_scene.h"
#include "base/error.h"
#include "scenes.h"

namespace quoin {
namespace {

using geometry::Vector;
using members_cases::box;
using members_cases::head;
using members_cases::tie;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kGravity = 9.81;

const std::string kWeight = "[[stage]]\ngravity = [0, -9.81, 0]\nduration = 0.1\n";

SceneLimit limit_of_text(const std::string& scene, const std::vector<double>& direction, bool associated = true) {
  const Simulation simulation(read_scene_text(scene + kWeight, "limit.toml"), 1);
  LimitOptions options;
  options.direction = direction, options.associated = associated;
  return limit_of(simulation, options);
}

const LimitMember& member_of(const SceneLimit& limit, const std::string& what) {
  const auto found = std::find_if(limit.members.begin(), limit.members.end(),
                                  [&](const LimitMember& member) { return member.what == what; });
  EXPECT_NE(found, limit.members.end()) << what;
  return *found;
}

// Returns a steel beam of 78.5 kg/m.
std::string beam(const std::string& points, const std::string& keys) {
  return fmt::format(
      "[[beam]]\nname = \"b\"\npoints = {}\nspacing = 0.25\narea = 0.01\ninertia = [1e-5, 1e-5]\ntorsion = "
      "1e-5\nyoung_modulus = 2e11\ndensity = 7850\n{}\n",
      points, keys);
}

// Fixed at both ends: hinges there and in the middle, w L^2/16 = My. The load is 1 + lambda times the weight.
TEST(LimitOfMembers, LintelFallsByThreeHinges) {
  const double length = 4.0, yield = 3e3, w = 78.5 * kGravity;
  const SceneLimit limit =
      limit_of_text(head(30.0) + box("left", "[-1, 0, 0]", "[1, 2, 1]", "fixed = true") +
                        box("right", "[4, 0, 0]", "[1, 2, 1]", "fixed = true") +
                        beam("[[-0.1, 1, 0.5], [0, 1, 0.5], [4, 1, 0.5], [4.1, 1, 0.5]]",
                             fmt::format("yield_moment = [{0}, {0}]\n[[beam.support]]\npoint = [0, 1, 0.5]\nblock = "
                                         "\"left\"\n[[beam.support]]\npoint = [4, 1, 0.5]\nblock = \"right\"",
                                         yield)),
                    {0, -1, 0});
  ASSERT_TRUE(limit.limit);
  EXPECT_NEAR(limit.limit->multiplier, 16.0 * yield / (w * length * length) - 1.0, 1e-4);
  EXPECT_EQ(limit.block_count, 3u);
  // The middle has the largest downward velocity.
  const LimitBody& body = limit.bodies.front();
  double fastest = 0.0;
  Vector at;
  for (int n = body.first; n < body.end; ++n) {
    const Vector& v = limit.limit->velocity[static_cast<std::size_t>(n)].force;
    if (-v.y > fastest) fastest = -v.y, at = limit.problem.blocks[static_cast<std::size_t>(n)].centre;
  }
  EXPECT_NEAR(at.x, 2.0, 1e-9);
  const MemberForce moment = largest_force(member_of(limit, "moment_up_Nm"), *limit.limit);
  EXPECT_NEAR(moment.largest, yield, 1e-6 * yield);
  EXPECT_GE(moment.at_strength, 3);
}

// Sway of a frame with fixed feet, with a hinge at x along the beam in place of its left corner. Its multiplier lambda
// is the smallest over all nodes of lambda (Wb + Wc) h + Wb x/2 = My (2 + 2 L/(L - x)), Wc for each column. For a short
// beam x = 0.
TEST(LimitOfMembers, PortalFrameSways) {
  const double h = 3.0, yield = 4e3;
  for (const double length : {2.0, 8.0}) {
    const SceneLimit limit = limit_of_text(
        head(30.0) + beam(fmt::format("[[0, 0, 0.5], [0, {0}, 0.5], [{1}, {0}, 0.5], [{1}, 0, 0.5]]", h, length),
                          fmt::format("up = [0, 0, 1]\nyield_moment = [{0}, {0}]\n[[beam.support]]\npoint = [0, 0, "
                                      "0.5]\n[[beam.support]]\npoint = [{1}, 0, 0.5]",
                                      yield, length)),
        {1, 0, 0});
    ASSERT_TRUE(limit.limit);
    const double w = 78.5 * kGravity, beam_weighs = w * length, column = w * h;
    double least = 1e300, hinge = 0.0;
    for (double x = 0.0; x < length; x += 0.25) {
      const double lambda =
          (yield * (2.0 + 2.0 * length / (length - x)) - beam_weighs * x / 2) / ((beam_weighs + column) * h);
      if (lambda < least) least = lambda, hinge = x;
    }
    EXPECT_NEAR(limit.limit->multiplier, least, 1e-4) << length;
    EXPECT_EQ(hinge > 0.0, length > 4.0);
  }
}

// A beam that rests on blocks slides at its friction: it is a separate block, with contact forces.
TEST(LimitOfMembers, BeamThatRestsSlidesAtItsFriction) {
  for (const bool associated : {true, false}) {
    const SceneLimit limit = limit_of_text(
        head(30.0) + box("left", "[-0.5, 0, 0]", "[1, 1, 1]", "fixed = true") +
            box("right", "[3.5, 0, 0]", "[1, 1, 1]", "fixed = true") +
            beam("[[0, 1, 0.5], [4, 1, 0.5]]",
                 "friction = 0.4\n[[beam.support]]\npoint = [0, 1, 0.5]\nblock = \"left\"\nhold = "
                 "\"resting\"\n[[beam.support]]\npoint = [4, 1, 0.5]\nblock = \"right\"\nhold = \"resting\""),
        {1, 0, 0}, associated);
    ASSERT_TRUE(limit.limit);
    EXPECT_NEAR(limit.limit->multiplier, 0.4, 1e-4);
    if (!associated) {
      ASSERT_TRUE(limit.without_dilation->settled);
      EXPECT_NEAR(limit.without_dilation->multiplier, 0.4, 0.004);
    }
  }
}

std::string floor_of(const std::string& corner, const std::string& along, const std::string& across,
                     const std::string& keys) {
  return fmt::format(
      "[[floor]]\nname = \"f\"\ncorner = {}\nalong = {}\nacross = {}\nspacing = 0.5\naxial_stiffness = [1e9, "
      "1e9]\nshear_stiffness = 1e7\nmass = 100\n{}\n",
      corner, along, across, keys);
}

// A diaphragm between two fixed walls, loaded along them: panels next to the walls yield. Each carries the load beyond
// its middle: lambda g m (L - a)/2 = ty.
TEST(LimitOfMembers, DiaphragmYieldsInShear) {
  const double length = 6.0, panel = 0.5, mass = 100.0, yield = 500.0;
  const SceneLimit limit = limit_of_text(
      head(30.0) + box("left", "[-1, 0, -1]", "[1, 1, 6]", "fixed = true") +
          box("right", "[6, 0, -1]", "[1, 1, 6]", "fixed = true") +
          floor_of("[0, 0.5, 0]", "[6, 0, 0]", "[0, 0, 4]",
                   fmt::format("shear_yield = {}\nspan = \"along\"\nconnector = {{ axial_stiffness = 1e9, "
                               "shear_stiffness = 1e9 }}",
                               yield)),
      {0, 0, 1});
  ASSERT_TRUE(limit.limit);
  EXPECT_NEAR(limit.limit->multiplier, yield / (kGravity * mass * 0.5 * (length - panel)), 1e-4);
  EXPECT_NEAR(largest_force(member_of(limit, "shear_N_per_m"), *limit.limit).largest, yield, 1e-6 * yield);
}

// A facade of one block rotates about its outer edge with the floor that it carries at the height y. The floor's
// anchors yield at the wall behind: lambda (W h/2 + Wf y) = W t/2 + Ta L y + Wf t/2. Half of the floor's weight acts on
// the facade's inner face.
TEST(LimitOfMembers, FacadeHeldByAFloorTurnsOver) {
  const double t = 0.3, h = 3.0, width = 3.0, y = 2.5, anchor = 800.0, load = 100.0 * kGravity;
  const double weight = h * t * width * 2000.0 * kGravity;
  const SceneLimit limit = limit_of_text(
      head(45.0) + box("facade", "[0, 0, 0]", fmt::format("[{}, {}, {}]", width, h, t)) +
          box("back", "[0, 0, -5]", fmt::format("[{}, 3, 1]", width), "fixed = true") +
          floor_of("[0, 2.5, -4]", "[3, 0, 0]", "[0, 0, 4]",
                   fmt::format("connector = {{ axial_stiffness = 1e9, shear_stiffness = 1e9, axial_strength = {} }}",
                               anchor)),
      {0, 0, 1});
  ASSERT_TRUE(limit.limit);
  const double floor_weighs = load * 4.0 * width;
  const double expected =
      (weight * t / 2 + anchor * width * y + floor_weighs * t / 2) / (weight * h / 2 + floor_weighs * y);
  EXPECT_NEAR(limit.limit->multiplier, expected, 1e-4);
  EXPECT_NEAR(largest_force(member_of(limit, "anchor_N_per_m"), *limit.limit).largest, anchor, 1e-6 * anchor);
}

// Mortar walls with a floor: 17 points in each joint, with tension, cohesion and crushing, and forces without bounds.
// Inscribed pyramids of 32 facets have 1.75350 by Clp, at most 0.5 % below the whole cones.
TEST(LimitOfMembers, BondedWallsWithAFloorAreSolvedByWholeCones) {
  const Simulation simulation(read_scene(QUOIN_SCENES "/floor_box.toml"), 1);
  LimitOptions options;
  options.direction = {0.0, 0.0, 1.0}, options.associated = true;
  const SceneLimit limit = limit_of(simulation, options);
  ASSERT_TRUE(limit.limit);
  EXPECT_EQ(limit.limit->facets, 0);
  EXPECT_GE(limit.limit->multiplier, 1.75350);
  EXPECT_LE(limit.limit->multiplier, 1.005 * 1.75350);
  EXPECT_LT(limit.limit->gap, 1e-5);
}

// A dowel yields in tension if a block rotates about its toe: lambda W h/2 = W b/2 + Ny d. If the block slides it has
// both axial and shear force: lambda W = mu (W + Ny) + V.
TEST(LimitOfMembers, DowelHoldsABlock) {
  const auto dowelled = [](double height, double force, double shear, bool associated = true) {
    return limit_of_text(head(30.0) + box("block", "[0, 0, 0]", fmt::format("[1, {}, 1]", height)) +
                             fmt::format("[[dowel]]\npoint = [0.25, 0, 0.5]\ndirection = [0, 1, 0]\naxial_stiffness = "
                                         "1e8\nshear_stiffness = 1e7\nyield_force = {}\nyield_shear = {}\n",
                                         force, shear),
                         {1, 0, 0}, associated);
  };
  const double tall = 2000.0 * 4.0 * kGravity, low = 2000.0 * 0.5 * kGravity, mu = std::tan(30.0 * M_PI / 180.0);
  const double turns = (tall * 0.5 + 2e4 * 0.75) / (tall * 2.0);
  EXPECT_NEAR(dowelled(4.0, 2e4, 1e6).limit->multiplier, turns, 1e-4);
  EXPECT_NEAR(dowelled(4.0, 2e4, 1e6, false).without_dilation->multiplier, turns, 1e-3 * turns) << "settled to 1e-3";
  EXPECT_NEAR(dowelled(0.5, 2e3, 1e3).limit->multiplier, mu * (1.0 + 2e3 / low) + 1e3 / low, 1e-4);
}

// A block of weight W slides. A member across the joint is not strained along its normal. Its force there is what it
// was: the pretension T0, or 0, however strong it is. A dowel adds its shear V, a beam 2 My over the length L that
// bends. An inclined tie is strained and yields at T, or is slack: mu (W + T sin) + T cos, or mu W. Sequences settle to
// 1e-3. A slope of strengths, with which the block sinks, gave 0.50 and 0.33 for dowel and beam, which carried its
// weight.
TEST(LimitOfMembers, WithoutDilationMembersAcrossASlidingJointAreNotStrained) {
  const double mu = std::tan(std::numbers::pi / 6.0), weight = 800.0 * kGravity;
  const auto dowel = [](double yield) {
    return fmt::format(
        "[[dowel]]\npoint = [0.5, 0, 0.5]\ndirection = [0, 1, 0]\naxial_stiffness = 1e8\nshear_stiffness = 2e7\n"
        "yield_force = {}\nyield_shear = 3e3\n",
        yield);
  };
  const auto rod = [](double foot, double pretension) {
    return tie("t", "base", fmt::format("[{}, -0.2, 0.5]", foot), "block", "[0.5, 0.2, 0.5]",
               fmt::format("area = 1e-4\nyoung_modulus = 2e11\nyield_stress = 1e8\npretension = {}", pretension));
  };
  const std::string bar =
      "[[beam]]\nname = \"l\"\npoints = [[0.5, -0.3, 0.5], [0.5, 0.3, 0.5]]\nup = [1, 0, 0]\nspacing = 0.3\narea = "
      "5e-4\ninertia = [2e-8, 2e-8]\nyoung_modulus = 2e11\ndensity = 7850\nyield_moment = [600, 600]\n"
      "[[beam.support]]\npoint = [0.5, -0.3, 0.5]\nblock = \"base\"\nhold = \"built_in\"\n"
      "[[beam.support]]\npoint = [0.5, 0.3, 0.5]\nblock = \"block\"\nhold = \"built_in\"\n";
  const double yields = mu + 1e4 * std::sqrt(0.5) * (mu + 1.0) / weight;
  for (const auto& [member, expected] : {std::pair{dowel(1e3), mu + 3e3 / weight},
                                         {dowel(5e4), mu + 3e3 / weight},
                                         {dowel(5e5), mu + 3e3 / weight},
                                         {bar, mu + 2.0 * 600.0 / 0.6 / weight},
                                         {rod(0.5, 0.0), mu},
                                         {rod(0.5, 1e4), mu * (1.0 + 1e4 / weight)},
                                         {rod(0.1, 0.0), yields},
                                         {rod(0.1, 5e3), yields},
                                         {rod(0.9, 5e3), mu}}) {
    const SceneLimit limit =
        limit_of_text(head(30.0) + box("block", "[0, 0, 0]", "[1, 0.4, 1]") + member, {1, 0, 0}, false);
    ASSERT_TRUE(limit.without_dilation && limit.without_dilation->settled) << member;
    EXPECT_NEAR(limit.without_dilation->multiplier / expected, 1.0, 2e-3) << member;
    EXPECT_LT(limit.without_dilation->apart, 0.01) << member;
  }
}

// A plate on two blocks distributes half of its tie force to each, and a point on the joint between them is refused.
TEST(LimitOfMembers, PlateSharesItsTie) {
  const double weight = 2000.0 * 3.0 * 0.3 * kGravity, yield = 4e3, y = 2.0;
  const auto with = [&](const std::string& plate) {
    return limit_of_text(
        head(45.0) + box("left", "[0, 0, 0]", "[1, 3, 0.3]") + box("right", "[1, 0, 0]", "[1, 3, 0.3]") +
            box("back", "[0, 0, -5]", "[2, 3, 1]", "fixed = true") +
            fmt::format(
                "[[tie]]\nfrom = {{ block = \"back\", point = [1, {0}, -4] }}\nto = {{ block = \"left\", point = "
                "[1, {0}, 0.3]{1} }}\narea = 1e-5\nyoung_modulus = 2e11\nyield_stress = {2}\n",
                y, plate, yield / 1e-5),
        {0, 0, 1});
  };
  const SceneLimit limit = with(", plate = [0.6, 0.6]");
  EXPECT_NEAR(limit.limit->multiplier, (weight * 0.15 + 0.5 * yield * y) / (weight * 1.5), 1e-4);
  try {
    with(", plate = [3.0, 0.6]");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("tie.1.to"), HasSubstr("reaches over the masonry at"), HasSubstr("0.25 m off")));
  }
}

// A wall of one block overturns away from the soil, which has the pressure Ka, or into it, against Kp: moments about a
// toe.
TEST(LimitOfMembers, WallTurnsAwayFromSoilAndIntoIt) {
  const double h = 4.0, b = 2.0, weight = 2000.0 * h * b * kGravity, gamma = 5e3;
  for (const double way : {-1.0, 1.0}) {
    const SceneLimit limit = limit_of_text(
        head(45.0) + box("wall", "[0, 0, 0]", "[2, 4, 1]") +
            fmt::format("[[fill]]\nblock = \"wall\"\ntowards = [1, 0, 0]\nsurface = [0, 4, 0]\nunit_weight = "
                        "{}\nfriction_angle = 30\nstiffness = 1e7\n",
                        gamma),
        {way, 0, 0});
    ASSERT_TRUE(limit.limit);
    const double coefficient = way < 0.0 ? -1.0 / 3.0 : 3.0;
    const double soil = coefficient * gamma * h * h / 2.0 * h / 3.0;
    EXPECT_NEAR(limit.limit->multiplier, (weight * b / 2.0 + soil) / (weight * h / 2.0), 1e-4) << way;
  }
}

// A slab on a pier of 1 m width: P (|x| - 1/2) = W/2, no limit above the pier.
TEST(LimitOfMembers, MovingLoadIsWorstAtTheEnds) {
  const auto moving = [](const std::string& from) {
    return members_cases::head(45.0) + box("pier", "[-0.5, 0, 0]", "[1, 1, 1]", "fixed = true") +
           box("slab", "[-2, 1, 0]", "[4, 0.2, 1]") +
           fmt::format(
               "[[stage]]\nname = \"crossing\"\ngravity = [0, -9.81, 0]\nduration = 1.0\nmoving_load = {{ from = {}, "
               "to "
               "= [2, 3, 0.5], force = [0, -1000, 0], positions = 17 }}\n",
               from);
  };
  LimitOptions options;
  options.moving = options.associated = true;
  const Simulation simulation(read_scene_text(moving("[-2, 3, 0.5]"), "moving.toml"), 1);
  const SceneLimit limit = limit_of(simulation, options);
  ASSERT_EQ(limit.moving.size(), 17u);
  const double weight = 2000.0 * 0.8 * kGravity;
  for (const MovingLimit& here : limit.moving) {
    EXPECT_NEAR(here.at.y, 1.2, 1e-9);
    const double arm = std::abs(here.at.x) - 0.5;
    ASSERT_EQ(here.multiplier.has_value(), arm > 1e-6) << here.at.x;
    if (here.multiplier) {
      EXPECT_NEAR(*here.multiplier / (0.5 * weight / arm / 1000.0), 1.0, 1e-6) << here.at.x;
    }
  }
  EXPECT_NEAR(std::abs(limit.moving[limit.worst].at.x), 2.0, 1e-9);
  EXPECT_EQ(json_of("", limit, options)["moving"]["positions"].size(), 17u);
  try {
    limit_of(Simulation(read_scene_text(moving("[-12, 3, 0.5]"), "moving.toml"), 1), options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("meets no block from its position 1 of 17 at (-12, 3, 0.5)"));
  }
}

// Returns a dry wall of 0.8 x 0.8 x 0.2 m.
std::string wall(const std::string& keys) {
  return R"([materials.brick]
density = 2000.0
young_modulus = 5e9
poisson_ratio = 0.2
[joints.mortar]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e10
shear_stiffness = 0.5e10
friction_angle = 40
[wall]
courses = 4
units_per_course = 2
unit = [0.4, 0.2, 0.2]
beam_height = 0.2
beam_density = 2000.0
mid_unit_joints = false
unit_material = "brick"
bed_joint = "mortar"
head_joint = "mortar"
beam_joint = "mortar"
)" + keys;
}

const std::string kZones = "zones = [2, 2, 2]\n";
const std::string kPressed = "[[stage]]\nkind = \"pressure\"\npressure = 1e4\ngravity = [0, -9.81, 0]\n";
constexpr double kCourse = 0.2 * 0.8 * 0.2 * 2000.0 * kGravity;  // weight of a course, and of the beam, N
constexpr double kPressure = 1e4 * 0.8 * 0.2;                    // N

SceneLimit limit_of_wall(const std::string& scene, const std::vector<double>& direction) {
  LimitOptions options;
  options.direction = direction, options.associated = true;
  return limit_of(Simulation(read_scene_text(scene, "wall.toml"), 1), options);
}

// A wall of 4 courses turns over its lower edge: lambda (4 W h/2 + Wb y) = (4 W + Wb + P + T) t/2. Wb and y are of the
// top beam and what it carries, T of a tie that yields. Masses and ties, without a stage that acts on blocks, were
// refused as if nothing held the wall; load_height was left out.
TEST(LimitOfWalls, WallTurnsOverWithWhatItsBeamCarries) {
  const double added = 300.0 * kGravity, tie = 1000.0;
  struct Case {
    std::string keys;
    double beam, y, tie;
  };
  for (const Case& c :
       {Case{"", kCourse, 0.9, 0.0}, Case{"load_height = 2.0\n[solver]\nlarge_motion = \"never\"\n", kCourse, 2.0, 0.0},
        Case{"[[mass]]\nblock = \"top_beam\"\nmass = 300\n", kCourse + added, 0.9, 0.0},
        Case{"[[mass]]\nblock = \"top_beam\"\nmass = 300\npoint = [0.4, 1.5, 0.1]\n", kCourse + added,
             (0.9 * kCourse + 1.5 * added) / (kCourse + added), 0.0},
        Case{"[[tie]]\nname = \"rod\"\nfrom = { block = \"bottom_beam\", point = [0.4, -0.1, 0.1] }\n"
             "to = { block = \"top_beam\", point = [0.4, 0.9, 0.1] }\narea = 1e-5\nyoung_modulus = 2e11\n"
             "yield_stress = 1e8\n",
             kCourse, 0.9, tie}}) {
    const SceneLimit limit = limit_of_wall(wall(kZones + c.keys) + kPressed, {0, 0, 1});
    ASSERT_TRUE(limit.limit);
    const double expected = (4.0 * kCourse + c.beam + kPressure + c.tie) * 0.1 / (4.0 * kCourse * 0.4 + c.beam * c.y);
    EXPECT_NEAR(limit.limit->multiplier, expected, 1e-4) << c.keys;
  }
}

// Without a bottom beam the lowest course is the ground: three courses turn over, lambda h/2 = t/2.
TEST(LimitOfWalls, BottomCourseIsTheGround) {
  const std::string beams = "bottom_beam = false\ntop_beam = false\n";
  const std::string weight = "[[stage]]\nkind = \"custom\"\ngravity = [0, -9.81, 0]\nduration = 0.1\n";
  const std::string held = "[[stage.control]]\nbody = \"bottom_course\"\n";
  const SceneLimit limit = limit_of_wall(wall("rigid_units = true\n" + beams) + weight + held, {0, 0, 1});
  ASSERT_TRUE(limit.limit);
  EXPECT_NEAR(limit.limit->multiplier, 0.1 / 0.3, 1e-4);
  try {
    limit_of_wall(wall(kZones + beams) + weight, {0, 0, 1});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("give wall.bottom_beam = true"));
  }
}

// A wall of half its thickness stands for the whole: nothing leaves the plane of symmetry. The half has half of the
// force, at any place across its thickness. It fell across that plane at half of the multiplier of the whole.
TEST(LimitOfWalls, HalfOfAWallStaysOnItsPlaneOfSymmetry) {
  const auto pressed_at = [](double force, double z) {
    return fmt::format(
        "[[stage]]\ngravity = [0, -9.81, 0]\nduration = 1.0\n[[stage.force]]\nblock = \"top_beam\"\n"
        "point = [0.4, 1.0, {}]\nforce = [0, {}, 0]\n",
        z, -force);
  };
  const std::string half = wall(kZones + "half_thickness = true\n");
  const SceneLimit whole = limit_of_wall(wall(kZones) + pressed_at(1600.0, 0.1), {1, 0, 0});
  ASSERT_TRUE(whole.limit);
  for (const double z : {0.0, 0.05, 0.1}) {
    const SceneLimit limit = limit_of_wall(half + pressed_at(800.0, z), {1, 0, 0});
    ASSERT_TRUE(limit.limit);
    EXPECT_NEAR(limit.limit->multiplier, whole.limit->multiplier, 1e-5) << z;
    for (const auto& [v, w] : limit.limit->velocity) {
      EXPECT_NEAR(v.z, 0.0, 1e-5);
      EXPECT_NEAR(std::hypot(w.x, w.y), 0.0, 1e-5);
    }
  }
  const SceneLimit margin = limit_of_wall(half + pressed_at(800.0, 0.1), {});
  ASSERT_TRUE(margin.margin);
  EXPECT_NEAR(*margin.margin, whole.limit->multiplier, 1e-5);
  EXPECT_EQ(margin.margin_direction.z, 0.0);
  try {
    limit_of_wall(half + kPressed, {1, 0, 0.1});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("across the plane of symmetry"), HasSubstr("half_thickness false")));
  }
}

TEST(LimitOfMembers, CablesAreRefused) {
  try {
    limit_of_text(head(30.0) +
                      "[[beam]]\nname = \"c\"\npoints = [[0, 0, 0], [4, 0, 0]]\nspacing = 0.5\narea = "
                      "1e-4\nyoung_modulus = 2e11\ndensity = 7850\n[[beam.support]]\npoint = [0, 0, "
                      "0]\n[[beam.support]]\npoint = [4, 0, 0]\n",
                  {0, 0, 1});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("beam 'c' does not bend both ways (inertia)"));
  }
}

}  // namespace
}  // namespace quoin
