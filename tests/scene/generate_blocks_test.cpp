// Dry walls for the general kernels: ends of their units in closed form.
#include "scene/generate_blocks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include "../scene_of_text.h"
#include "base/error.h"
#include "one_block.h"
#include "scene/load_place.h"
#include "scene/read_masses.h"
#include "scene/size.h"

namespace quoin::blocks {
namespace {

constexpr double kLength = 0.3, kThickness = 0.2;
constexpr int kCourses = 7, kUnits = 4;

Scene scene_with(const std::string& keys) {
  return scene_of_text(kStone + R"([[dry_wall]]
material = "stone"
courses = 7
units_per_course = 4
unit = [0.3, 0.1, 0.2]
)" + keys + "[[stage]]\nduration = 0.1\n");
}

Assembly wall_with(const std::string& keys) { return assemble(scene_with(keys)); }

std::vector<Vector> corners(const Assembly& wall, const Block& block) {
  std::vector<Vector> result;
  for (const Vector& p : wall.shapes[size_t(block.shape)].vertices)
    result.push_back(block.position + geometry::matrix(block.orientation) * p);
  return result;
}

// Returns the x of the ends of the pieces of one course, from the left, in lengths of a unit.
std::vector<double> ends(const Assembly& wall, int course) {
  std::vector<double> result;
  for (const Block& block : wall.blocks) {
    if (block.course != course) continue;
    double left = 1e9, right = -1e9;
    for (const Vector& p : corners(wall, block)) left = std::min(left, p.x), right = std::max(right, p.x);
    if (result.empty()) result.push_back(left / kLength);
    EXPECT_NEAR(left / kLength, result.back(), 1e-12) << "a gap in course " << course;
    result.push_back(right / kLength);
  }
  return result;
}

// Returns the ends of a course whose units are shifted to the left by a share of a unit.
std::vector<double> moved_by(double shift) {
  std::vector<double> result{0.0};
  for (int i = 1; i <= kUnits; ++i) result.push_back(i - shift);
  if (shift > 0.0) result.push_back(kUnits);
  return result;
}

TEST(DryWall, UnitsOverlapAsTheirBondSays) {
  const struct {
    const char* keys;
    double (*shift)(int course);
  } bonds[] = {{"", [](int c) { return c % 2 / 2.0; }},
               {"bond = \"running\"\nfirst_course = \"half\"\n", [](int c) { return (c + 1) % 2 / 2.0; }},
               {"bond = \"third\"\n", [](int c) { return c % 3 / 3.0; }},
               {"bond = \"stack\"\n", [](int) { return 0.0; }},
               {"bond = \"stack\"\nfirst_course = \"half\"\n", [](int) { return 0.5; }}};
  for (const auto& [keys, shift] : bonds) {
    const Assembly wall = wall_with(keys);
    for (int c = 0; c < kCourses; ++c)
      EXPECT_THAT(ends(wall, c), testing::Pointwise(testing::DoubleNear(1e-12), moved_by(shift(c))))
          << keys << "course " << c;
  }
}

// Units are cut in their middle, for any end of the wall; there are no pieces shorter than a tenth of a unit.
TEST(DryWall, HalvesMeetInTheMiddleOfTheirUnit) {
  const Assembly wall = wall_with("bond = \"third\"\nmid_unit_joints = true\n");
  for (int c = 0; c < kCourses; ++c) {
    const double shift = c % 3 / 3.0;
    std::vector<double> expected = moved_by(shift);
    for (int i = 0; i <= kUnits; ++i) {
      if (const double middle = i + 0.5 - shift; middle > 0.1 && middle < kUnits - 0.1) expected.push_back(middle);
    }
    std::sort(expected.begin(), expected.end());
    EXPECT_THAT(ends(wall, c), testing::Pointwise(testing::DoubleNear(1e-12), expected)) << "course " << c;
  }
}

// The estimated size. A course of n units has one more if its bond cuts units at both ends: 7 (4 + 1) units, or 10
// halves in a course.
TEST(DryWall, ItsSizeCountsTheUnitsThatABondCuts) {
  const std::string third = "rigid = true\nbond = \"third\"\n";
  for (const auto& [keys, blocks] : {std::pair{third, 35.0}, {third + "mid_unit_joints = true\n", 70.0}}) {
    const double reported = size_of(scene_with(keys)).blocks, made = double(wall_with(keys).blocks.size());
    EXPECT_EQ(reported, blocks);
    EXPECT_GE(reported, made);
    EXPECT_LT(reported, 1.5 * made);
  }
}

// A trimmed end and the edge of an opening keep their positions for any distance; other cuts are moved. Lengths in
// units.
TEST(DryWall, SliversBetweenGivenEndsStay) {
  const Assembly wall = wall_with(
      "trim_start = [0.285, 0.0]\ntrim_end = [0.0, 0.29]\nopening = [{ from = 0.306, to = 0.606, sill = 0.0, head = "
      "0.1 }, "
      "{ from = 0.6, to = 0.9, sill = 0.1, head = 0.2 }]\n");
  const auto pieces = [&](int course) {
    std::vector<double> list;
    for (const Block& block : wall.blocks) {
      if (block.course != course) continue;
      double left = 1e9, right = -1e9;
      for (const Vector& p : corners(wall, block)) left = std::min(left, p.x), right = std::max(right, p.x);
      list.insert(list.end(), {left / kLength, right / kLength});
    }
    return list;
  };
  const auto are = [](std::vector<double> expected) {
    return testing::Pointwise(testing::DoubleNear(1e-12), std::move(expected));
  };
  EXPECT_THAT(pieces(0), are({0.95, 1.02, 2.02, 3.0, 3.0, 4.0}));
  EXPECT_THAT(pieces(1), are({0.0, 0.5, 0.5, 1.5, 1.5, 2.0, 3.0, 0.91 / 0.3}));
  EXPECT_THAT(pieces(2), are({0.95, 2.0, 2.0, 3.0, 3.0, 4.0}));
}

// A lintel from 0.53 to 1.47 lengths of a unit. Head joints of the course at 0.5 and 1.5, closer to its ends than a
// tenth of a unit, move to these ends.
TEST(DryWall, LintelsKeepTheirEnds) {
  const Assembly wall =
      wall_with("opening = [{ from = 0.201, to = 0.399, sill = 0.0, head = 0.1, bearing = 0.042 }]\n");
  EXPECT_THAT(ends(wall, 1),
              testing::Pointwise(testing::DoubleNear(1e-12), std::vector<double>{0.0, 0.53, 1.47, 2.5, 3.5, 4.0}));
}

TEST(DryWall, StandsInItsDirectionFromXTowardsZ) {
  const double angle = 30 * std::numbers::pi / 180;
  const Assembly wall = wall_with("direction = 30\norigin = [1, 2, 3]\n");
  Vector low{1e9, 1e9, 1e9}, high = -low;  // along the length, height and thickness of the wall
  for (const Block& block : wall.blocks) {
    for (const Vector& p : corners(wall, block)) {
      const Vector q = p - Vector{1, 2, 3};
      const Vector own{q.x * std::cos(angle) + q.z * std::sin(angle), q.y,
                       q.z * std::cos(angle) - q.x * std::sin(angle)};
      low = min(low, own), high = max(high, own);
    }
  }
  EXPECT_LT(norm(low), 1e-12);
  EXPECT_LT(norm(high - Vector{kUnits * kLength, 0.7, kThickness}), 1e-12);
}

// Returns the parts beside dry walls: blocks and arches of stone, with further joints.
Assembly assembled(const std::string& keys) {
  return assemble(scene_of_text("default_joint = \"dry\"\n" + kStone + R"([joints.mortar]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 5e8
[joints.weak]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 5e8
)" + keys));
}

std::string cube(const std::string& name, double x, double y, const std::string& more = "") {
  return "[[block]]\nname = \"" + name + "\"\nmaterial = \"stone\"\nbox = { lower = [" + std::to_string(x) + ", " +
         std::to_string(y) + ", 0], size = [1, 1, 1] }\n" + more;
}

// Three voussoirs from 30 to 120 degrees: each spans 30, between radii of 1.8 and 2.2 m and depths of 0 and 0.5 m.
TEST(Arches, VoussoirsAreOnTheirCircleBetweenFixedOnes) {
  const Assembly arch = assembled(
      "[[arch]]\nname = \"a\"\nmaterial = \"stone\"\ncentre = [1, 2, 3]\nradius = 2\nthickness = 0.4\ndepth = 0.5\n"
      "voussoirs = 3\nangles = [30, 120]\nrigid = false\nzone_edge = 0.2\n[[stage]]\nduration = 0.1\n");
  ASSERT_EQ(arch.blocks.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    const Block& block = arch.blocks[size_t(i)];
    EXPECT_EQ(block.name, "a/" + std::to_string(i - 1));
    EXPECT_EQ(block.fixed, i == 0 || i == 4);
    EXPECT_EQ(block.rigid, block.fixed) << "abutments are rigid";
    ASSERT_EQ(corners(arch, block).size(), 8u);
    for (const Vector& p : corners(arch, block)) {
      const Vector q = p - Vector{1, 2, 3};
      EXPECT_NEAR(std::abs(std::hypot(q.x, q.y) - 2.0), 0.2, 1e-12);
      EXPECT_NEAR(std::abs(q.z - 0.25), 0.25, 1e-12);
      EXPECT_NEAR(std::abs(std::atan2(q.y, q.x) * 180 / std::numbers::pi - (30.0 * i + 15.0)), 15.0, 1e-9);
    }
  }
}

// The first rule that fits: beds of a and b in either order, then joints inside units, then upright ones of any blocks.
TEST(JointRules, TheFirstThatFitsGivesTheFamily) {
  const Assembly blocks =
      assembled(cube("a/1", 0, 0, "unit = \"u\"\n") + cube("a/2", 1, 0, "unit = \"u\"\n") + cube("b/1", 0, 1) +
                cube("c", 1, 1) + cube("c2", 2, 0) +
                "[[joint_rule]]\nfamily = \"mortar\"\nnormal = \"vertical\"\nbetween = [\"a\", \"b\"]\n"
                "[[joint_rule]]\nfamily = \"weak\"\ninside_units = true\n"
                "[[joint_rule]]\nfamily = \"none\"\nnormal = \"horizontal\"\n"
                "[[stage]]\nduration = 0.1\n");
  const auto family = [&](int a, int b, const Vector& normal) {
    const int found = blocks.family_of({a, b, normal});
    return found < 0 ? "none" : blocks.families[size_t(found)].name;
  };
  const Vector up{0, 1, 0}, along{1, 0, 0};
  EXPECT_EQ(family(0, 2, up), "mortar");
  EXPECT_EQ(family(2, 0, -up), "mortar");
  EXPECT_EQ(family(0, 2, along), "none") << "the first rule is for beds";
  EXPECT_EQ(family(2, 3, up), "dry") << "b and c";
  EXPECT_EQ(family(0, 1, along), "weak") << "of one unit";
  EXPECT_EQ(family(0, 1, up), "weak");
  EXPECT_EQ(family(1, 4, along), "none");
  EXPECT_EQ(family(2, 3, normalized(Vector{1, 1.01, 0})), "dry") << "steeper than 45 degrees is a bed";
  EXPECT_EQ(family(2, 3, normalized(Vector{1.01, 1, 0})), "none");
}

// The pattern of a box differs where an odd number of hexahedra lies between it and the first one.
// Halves of 0.15 m have `along` of them, courses `up`.
TEST(DryWall, ZonesAlternateOverTheWholeWall) {
  for (const auto& [zones, along, up] : {std::tuple{"[1, 1, 1]", 1, 1}, {"[3, 2, 1]", 3, 2}}) {
    const Assembly wall = wall_with(std::string("rigid = false\nzones = ") + zones + "\n");
    for (const Block& block : wall.blocks) {
      double left = 1e9, right = -1e9;
      for (const Vector& p : corners(wall, block)) left = std::min(left, p.x), right = std::max(right, p.x);
      EXPECT_EQ(block.divisions[0], std::lround(along * (right - left) / 0.15)) << block.name;
      EXPECT_EQ(block.divisions[1], up);
      EXPECT_EQ(block.parity, (wall.blocks[0].parity + std::lround(along * left / 0.15) + block.course * up) % 2)
          << block.name;
    }
  }
}

TEST(Blocks, AFixedOneIsFreedWhereAStageLeavesAComponentOfItFree) {
  const auto freed = [](const char* velocity) {
    const Assembly blocks =
        assembled(cube("base", 0, 0, "fixed = true\n") + cube("held", 1, 0, "fixed = true\n") + cube("top", 0, 1) +
                  "[[stage]]\nduration = 0.1\n[[stage.velocity]]\nblock = \"base\"\nvelocity = " + velocity +
                  "\n[[stage.velocity]]\nblock = \"top\"\nvelocity = [0, \"free\", 0]\n");
    EXPECT_FALSE(blocks.blocks[1].freed || blocks.blocks[2].freed);
    return blocks.blocks[0].freed;
  };
  EXPECT_TRUE(freed("[0, \"free\", 0]"));
  EXPECT_FALSE(freed("[0, 0.1, 0]"));
}

// 1e-4 of the least extent of any block: 0.2 m.
TEST(Blocks, TheirJointToleranceIsAShareOfTheThinnest) {
  const std::string thin =
      "[[block]]\nname = \"t\"\nmaterial = \"stone\"\nbox = { lower = [3, 0, 0], size = [1, 0.2, 3] }\n";
  EXPECT_NEAR(joint_tolerance_of(assembled(cube("a", 0, 0) + thin + "[[stage]]\nduration = 0.1\n")), 2e-5, 1e-15);
  EXPECT_EQ(joint_tolerance_of(assembled(cube("a", 0, 0) + "[contact]\njoint_tolerance = 0.003\n[[stage]]\nduration = "
                                                           "0.1\n")),
            0.003);
}

// Boxes `low`, 2 x 1 x 1 m, and `high` above it; `tilted`, a cube of 1 m that is turned by 30 degrees about z.
Assembly three_blocks() {
  return assemble(scene_of_text(R"([materials.stone]
density = 2000
[joints.dry]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 5e8
[[block]]
name = "low"
material = "stone"
box = { lower = [0, 0, 0], size = [2, 1, 1] }
[[block]]
name = "high"
material = "stone"
box = { lower = [0, 3, 0], size = [0.6, 0.5, 1] }
[[block]]
name = "tilted"
material = "stone"
position = [3.5, 2, 0.5]
rotation = [0, 0, 30]
box = { lower = [-0.5, -0.5, -0.5], size = [1, 1, 1] }
[[stage]]
duration = 0.1
)"));
}

// A load meets the first face along its force. Above the middle of the tilted cube its upper face is at 0.5/cos 30; 0.5
// m beside it the face to the right is at (0.5 - 0.5 cos 30)/sin 30.
TEST(LoadPlace, IsTheFirstFaceAlongTheForce) {
  const Assembly assembly = three_blocks();
  const double c = std::cos(std::numbers::pi / 6);
  const struct {
    Vec3 from, to, force;
    std::vector<std::pair<int, Vector>> places;
  } loads[] = {{{0.5, 5, 0.5}, {1.5, 5, 0.5}, {0, -7, 0}, {{1, {0.5, 3.5, 0.5}}, {0, {1, 1, 0.5}}, {0, {1.5, 1, 0.5}}}},
               {{3.5, 5, 0.5}, {4, 5, 0.5}, {0, -7, 0}, {{2, {3.5, 2 + 0.5 / c, 0.5}}, {2, {4, 3 - c, 0.5}}}},
               {{0.5, 2, 0.5}, {9, 9, 9}, {0, 3, 0}, {{1, {0.5, 3, 0.5}}}},
               {{0.5, 0.25, 0.5}, {9, 9, 9}, {0, 3, 0}, {{0, {0.5, 0.25, 0.5}}}},
               {{-1, 0, 0.5}, {9, 9, 9}, {2, 1, 0}, {{0, {0, 0.5, 0.5}}}}};
  for (const auto& load : loads) {
    const auto found = places_of({load.from, load.to, load.force, int(load.places.size())}, assembly, "here");
    ASSERT_EQ(found.size(), load.places.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].block, load.places[i].first);
      EXPECT_LT(norm(found[i].at - load.places[i].second), 1e-12);
    }
  }
  EXPECT_THROW(places_of({{2.1, 5, 0.5}, {9, 9, 9}, {0, -1, 0}, 1}, assembly, "here"), Error);
  EXPECT_NEAR(distance_from(assembly, assembly.blocks[2], Vector{3.5, 2, 0.5} + 0.75 * Vector{c, 0.5, 0}), 0.25, 1e-12);
}

// A pressure acts on the blocks of a name that reach furthest, and on their faces that look that way.
TEST(LoadPlace, OuterFacesAreThoseOfTheBlocksThatReachFurthest) {
  Assembly assembly = three_blocks();
  assembly.shared_names = true;
  for (Block& block : assembly.blocks) block.name = "pier";
  const auto outer = [&](const Vector& towards) {
    std::vector<std::pair<int, Vector>> found;
    for (const BlockFace& f : outer_faces(assembly, "pier", towards, "here")) {
      const Block& b = assembly.blocks[size_t(f.block)];
      found.push_back({f.block, matrix(b.orientation) * assembly.shapes[size_t(b.shape)].normals[size_t(f.face)]});
    }
    return found;
  };
  const double c = std::cos(std::numbers::pi / 6);
  const struct {
    Vector towards;
    std::vector<std::pair<int, Vector>> faces;
  } cases[] = {{{0, 3, 0}, {{1, {0, 1, 0}}}},
               {{0, -1, 0}, {{0, {0, -1, 0}}}},
               {{2, 0.1, 0}, {{2, {c, 0.5, 0}}}},
               {{-1, 0, 0}, {{0, {-1, 0, 0}}, {1, {-1, 0, 0}}}}};
  for (const auto& [towards, faces] : cases) {
    const auto found = outer(towards);
    ASSERT_EQ(found.size(), faces.size()) << towards.x << " " << towards.y;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].first, faces[i].first);
      EXPECT_LT(norm(found[i].second - faces[i].second), 1e-12);
    }
  }
  EXPECT_EQ(block_at(assembly, "pier", {1.9, 1.1, 0.5}, "here"), 0);
  EXPECT_EQ(block_at(assembly, "pier", {3.0, 2.0, 0.5}, "here"), 2);
}

// Blocks of one name share a mass; a mass with a place is of one block. Each body of a floor has its part of the mass.
TEST(Masses, AreSharedByTheBlocksOfTheirName) {
  Assembly assembly = three_blocks();
  Scene scene;
  scene.masses = {{"high", 5.0, std::nullopt, {}}, {"tilted", 7.0, Vec3{4, 2, 0.5}, {}}};
  add_masses(scene, &assembly);
  EXPECT_EQ(assembly.blocks[1].spread_mass, 5.0);
  ASSERT_EQ(assembly.blocks[2].masses.size(), 1u);
  EXPECT_EQ(assembly.blocks[2].masses[0].mass, 7.0);
  EXPECT_EQ(assembly.blocks[2].masses[0].at.x, 4.0);
  EXPECT_EQ(assembly.blocks[2].spread_mass, 0.0);
  assembly.shared_names = true;
  for (Block& block : assembly.blocks) block.name = "pier";
  scene.masses = {{"pier", 30.0, std::nullopt, {}}};
  add_masses(scene, &assembly);
  EXPECT_EQ(assembly.blocks[0].spread_mass, 10.0);
  EXPECT_EQ(assembly.blocks[1].spread_mass, 15.0);
  scene.masses[0].point = Vec3{1, 0.5, 0.5};
  EXPECT_THAT([&] { add_masses(scene, &assembly); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("3 blocks are called 'pier'")));

  BuildingSpec building;
  building.floors.resize(2);
  building.floors[0].half_units = {0, 1}, building.floors[0].name = "loft";
  building.floors[1].half_units = {0, 1, 4, 5}, building.floors[1].mass = 100.0, building.floors[1].name = "roof";
  const std::vector<AddedMass> of_floors = masses_of_floors(building);
  ASSERT_EQ(of_floors.size(), 4u);
  for (const AddedMass& added : of_floors) EXPECT_EQ(added.mass, 25.0);
  EXPECT_EQ(of_floors[3].block, "roof_4");
}

}  // namespace
}  // namespace quoin::blocks
