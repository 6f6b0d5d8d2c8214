// The wall generator: numbers of the paper, bonds, openings and conforming diagonals.
#include "scene/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "scene/brick_overlap.h"
#include "scene/masonry_place.h"
#include "scene/read_scene.h"

namespace quoin {
namespace {

struct Counts {
  int blocks = 0, zones = 0, unit_points = 0, head_points = 0, bed_points = 0;
};

// Counts contact points of joints between blocks of equal size: one for each gridpoint of the face.
Counts count(const Assembly& a) {
  Counts c;
  for (const Brick& b : a.bricks) {
    if (!b.rigid) ++c.blocks, c.zones += 5 * b.zones[0] * b.zones[1] * b.zones[2];
  }
  for (const Joint& j : a.joints) {
    const Brick& b = a.bricks[static_cast<size_t>(j.block_a)];
    const Brick& zoned = b.rigid ? a.bricks[static_cast<size_t>(j.block_b)] : b;
    const auto& z = zoned.zones;
    const int points = j.face_a < 2 ? (z[1] + 1) * (z[2] + 1) : (z[0] + 1) * (z[2] + 1);
    (j.face_a == 3                                              ? c.bed_points
     : a.families[static_cast<size_t>(j.family)].name == "unit" ? c.unit_points
                                                                : c.head_points) += points;
  }
  return c;
}

Scene solid_wall(const std::vector<std::string>& overrides = {}) {
  return read_scene(QUOIN_SCENES "/solid_wall_030.toml", overrides);
}

TEST(GenerateWall, SolidWallHasThePapersSizes) {
  const Assembly a = assemble(solid_wall());
  const Counts c = count(a);
  EXPECT_EQ(c.blocks, 144);
  EXPECT_EQ(c.zones, 11520);
  EXPECT_EQ(c.unit_points + c.head_points, 1152);
  EXPECT_EQ(c.bed_points, 2295);
  EXPECT_EQ(a.bricks.size(), 146u);  // including two beams
  EXPECT_EQ(a.bricks[144].body, "bottom_beam");
  EXPECT_EQ(a.bricks[145].body, "top_beam");
  EXPECT_DOUBLE_EQ(a.bricks[145].origin[1], 1.0);
  EXPECT_DOUBLE_EQ(a.bricks[145].size[0], 0.99);
  EXPECT_NEAR(bed_area(*solid_wall().wall), 0.099, 1e-15);
}

TEST(GenerateWall, ScenesDifferOnlyInPressure) {
  const double pressures[] = {0.30e6, 1.21e6, 2.12e6};
  const char* names[] = {"030", "121", "212"};
  for (int i = 0; i < 3; ++i) {
    const Scene s = read_scene(std::string(QUOIN_SCENES "/solid_wall_") + names[i] + ".toml");
    EXPECT_NEAR(s.stages.at(0).controls.at(1).force[1], -pressures[i] * 0.099, 1e-9);
    EXPECT_EQ(s.joints.at("mortar").properties.size(), 10u);
    EXPECT_EQ(count(assemble(s)).zones, 11520);
  }
}

// Running bond: 4 whole units and a half, which is at the right end of even courses and at the left end of odd ones.
TEST(GenerateWall, RunningBondMovesByHalfAUnit) {
  const Assembly a = assemble(solid_wall({"wall.mid_unit_joints=false"}));
  EXPECT_EQ(count(a).blocks, 16 * 5);
  EXPECT_EQ(count(a).zones, 11520);
  for (const Brick& b : a.bricks) {
    if (b.rigid) continue;
    const bool half = b.size[0] < 0.2;
    EXPECT_EQ(b.zones[0], half ? 4 : 8);
    if (half) {
      EXPECT_NEAR(b.origin[0], b.course % 2 == 0 ? 0.88 : 0.0, 1e-12);
    }
  }
  // Each bed of 9 half units has 9 overlaps; the beams' beds have 5 units.
  int beds = 0;
  std::set<std::pair<int, int>> pairs;
  for (const Joint& j : a.joints) {
    if (j.face_a == 3) ++beds;
    EXPECT_TRUE(pairs.insert({j.block_a, j.block_b}).second) << "a pair of blocks joined twice";
  }
  EXPECT_EQ(beds, 15 * 9 + 2 * 5);
}

TEST(GenerateWall, FirstCourseMayStartWithAHalf) {
  const Assembly a = assemble(solid_wall({"wall.mid_unit_joints=false", "wall.first_course=half"}));
  EXPECT_NEAR(a.bricks[0].size[0], 0.11, 1e-12);
}

TEST(GenerateWall, StackBondPutsHeadJointsAboveEachOther) {
  const Assembly a = assemble(solid_wall({"wall.mid_unit_joints=false", "wall.bond=stack", "wall.units_per_course=4"}));
  for (const Brick& b : a.bricks) {
    if (!b.rigid) {
      EXPECT_NEAR(b.size[0], 0.22, 1e-12);
    }
  }
  EXPECT_EQ(count(a).blocks, 64);
}

TEST(GenerateWall, OpeningsLeaveHalfUnits) {
  const std::string opening = "wall.opening=[{first_half_unit = 4, half_units = 2, first_course = 5, courses = 6}]";
  const Assembly with_mid = assemble(solid_wall({opening}));
  EXPECT_EQ(count(with_mid).blocks, 144 - 12);
  const Assembly whole = assemble(solid_wall({opening, "wall.mid_unit_joints=false"}));
  EXPECT_EQ(count(whole).zones, 11520 - 12 * 80);
  for (const Brick& b : whole.bricks) {
    const bool beside = b.course >= 5 && b.course < 11 && !b.rigid;
    if (beside) {
      EXPECT_TRUE(b.origin[0] + b.size[0] < 0.44 + 1e-9 || b.origin[0] > 0.66 - 1e-9);
    }
  }
}

// Returns the area of the bed joints below a course, m2, from the overlap of blocks, independent of the contact points.
double bed_area_below(const Assembly& a, double y) {
  double area = 0.0;
  for (const Joint& j : a.joints) {
    const Brick &below = a.bricks[static_cast<size_t>(j.block_a)], &above = a.bricks[static_cast<size_t>(j.block_b)];
    if (j.face_a != 3 || std::abs(above.origin[1] - y) > 1e-9) continue;
    double overlap = 1.0;
    for (const size_t c : {size_t{0}, size_t{2}})
      overlap *= std::min(below.origin[c] + below.size[c], above.origin[c] + above.size[c]) -
                 std::max(below.origin[c], above.origin[c]);
    area += overlap;
  }
  return area;
}

const char* const kLintel =
    "wall.opening=[{first_half_unit = 2, half_units = 5, first_course = 5, courses = 6, bearing = 0.11}]";

// An opening of 5 half units whose lintel has a bearing of one half unit at each end: one block in place of 7 half
// units.
TEST(GenerateWall, ALintelIsOneBlock) {
  const Assembly a = assemble(solid_wall({kLintel}));
  const Counts c = count(a);
  EXPECT_EQ(c.blocks, 144 - 5 * 6 - 6);
  EXPECT_EQ(c.zones, (144 - 5 * 6) * 80);
  std::vector<const Brick*> lintels;
  for (const Brick& b : a.bricks) {
    if (!b.rigid && b.size[0] > 0.2) lintels.push_back(&b);
  }
  ASSERT_EQ(lintels.size(), 1u);
  const Brick& lintel = *lintels.front();
  EXPECT_EQ(lintel.course, 11);
  EXPECT_NEAR(lintel.origin[0], 0.11, 1e-12);
  EXPECT_NEAR(lintel.origin[1], 11 * 0.0625, 1e-12);
  EXPECT_NEAR(lintel.size[0], 0.77, 1e-12);
  EXPECT_EQ(lintel.zones, (std::array<int, 3>{28, 2, 2}));
  EXPECT_EQ(a.materials[static_cast<size_t>(lintel.material)].name, solid_wall().wall->unit_material);

  // Mortar on all sides: a joint with each half unit in contact, none of them inside a unit.
  int beds = 0, heads = 0;
  std::set<std::pair<int, int>> pairs;
  for (const Joint& j : a.joints) {
    EXPECT_TRUE(pairs.insert({j.block_a, j.block_b}).second) << "a pair of blocks joined twice";
    EXPECT_NE(j.block_a, j.block_b);
    const bool here =
        &a.bricks[static_cast<size_t>(j.block_a)] == &lintel || &a.bricks[static_cast<size_t>(j.block_b)] == &lintel;
    if (!here) continue;
    ++(j.face_a == 3 ? beds : heads);
    EXPECT_EQ(a.families[static_cast<size_t>(j.family)].name, "mortar");
  }
  EXPECT_EQ(beds, 2 + 7);
  EXPECT_EQ(heads, 2);
  EXPECT_NEAR(bed_area_below(a, 11 * 0.0625), (0.99 - 5 * 0.11) * 0.1, 1e-12);
  EXPECT_NEAR(bed_area_below(a, 12 * 0.0625), 0.99 * 0.1, 1e-12);
}

// Half units on both sides of a lintel are not one unit, and units keep their position in the bond.
TEST(GenerateWall, ALintelCutsUnits) {
  for (const char* mid : {"true", "false"}) {
    const Assembly a = assemble(solid_wall({kLintel, std::string("wall.mid_unit_joints=") + mid}));
    EXPECT_EQ(count(a).zones, (144 - 5 * 6) * 80) << mid;
    double length = 0.0;
    std::map<int, double> unit_length;
    for (const Brick& b : a.bricks) {
      if (b.course != 11) continue;
      length += b.size[0];
      unit_length[b.unit] += b.size[0];
    }
    EXPECT_NEAR(length, 0.99, 1e-12);
    // Course 11 starts with a half; the lintel replaces half units 1 to 7.
    EXPECT_EQ(unit_length.size(), 3u) << mid;
    for (const auto& [unit, of_unit] : unit_length) EXPECT_TRUE(of_unit < 0.12 || of_unit > 0.76) << mid;
  }
}

TEST(GenerateWall, ALintelHasAMaterialOfItsOwn) {
  const Assembly a = assemble(
      solid_wall({"materials.concrete={young_modulus = 25e9, poisson_ratio = 0.2, density = 2400}",
                  "wall.opening=[{first_half_unit = 2, half_units = 3, first_course = 0, courses = 6, bearing = 0.22, "
                  "lintel_material = \"concrete\"}]"}));
  int found = 0;
  for (const Brick& b : a.bricks) {
    if (a.materials[static_cast<size_t>(b.material)].name != "concrete") continue;
    ++found;
    EXPECT_NEAR(b.size[0], 7 * 0.11, 1e-12);
  }
  EXPECT_EQ(found, 1);
}

TEST(GenerateWall, ALintelOfRigidUnitsIsRigid) {
  const Assembly a = assemble(read_scene(
      QUOIN_SCENES "/cube_wall_10.toml",
      {"wall.opening=[{first_half_unit = 4, half_units = 4, first_course = 2, courses = 3, bearing = 0.1}]"}));
  EXPECT_EQ(a.bricks.size(), 100u - 2 * 3 - 3);
  int found = 0;
  for (const Brick& b : a.bricks) {
    EXPECT_TRUE(b.rigid);
    if (b.size[0] < 0.15) continue;
    ++found;
    EXPECT_NEAR(b.size[0], 0.4, 1e-12);
  }
  EXPECT_EQ(found, 1);
}

TEST(GenerateWall, HalfThickness) {
  const Assembly a = assemble(solid_wall({"wall.half_thickness=true"}));
  EXPECT_EQ(a.symmetry_factor, 2.0);
  EXPECT_TRUE(a.symmetry_plane_z0);
  EXPECT_EQ(a.bricks[0].zones[2], 1);
  EXPECT_DOUBLE_EQ(a.bricks[0].size[2], 0.05);
}

// Joints with a beam have the family of beams, bed joints between units that of beds; found by positions of blocks.
TEST(GenerateWall, JointsOfBeamsHaveAFamilyOfTheirOwn) {
  const std::vector<std::string> families{
      "joints.beds={law = \"elastic\", normal_stiffness = 1e9, shear_stiffness = 1e9}",
      "joints.beams={law = \"elastic\", normal_stiffness = 2e9, shear_stiffness = 1e9}"};
  const auto with = [&](const char* scene, const std::string& table) {
    std::vector<std::string> settings = families;
    settings.push_back(table + ".bed_joint=beds");
    settings.push_back(table + ".beam_joint=beams");
    return assemble(read_scene(std::string(QUOIN_SCENES) + scene, settings));
  };
  for (const Assembly& a : {with("/solid_wall_030.toml", "wall"), with("/pavia_door.toml", "building")}) {
    double top = 0.0;  // height of the masonry, m
    for (const Brick& b : a.bricks) {
      if (b.unit >= 0) top = std::max(top, b.origin[1] + b.size[1]);
    }
    int beds = 0, at_foot = 0, at_top = 0;
    for (const Joint& j : a.joints) {
      if (j.face_a != 2 && j.face_a != 3) continue;
      const Brick &below = a.bricks[static_cast<size_t>(j.face_a == 3 ? j.block_a : j.block_b)],
                  &above = a.bricks[static_cast<size_t>(j.face_a == 3 ? j.block_b : j.block_a)];
      const bool foot = below.origin[1]<-1e-9, head = above.origin[1]> top - 1e-9;
      EXPECT_EQ(a.families[static_cast<size_t>(j.family)].name, foot || head ? "beams" : "beds") << above.origin[1];
      (foot ? at_foot : head ? at_top : beds) += 1;
    }
    EXPECT_GE(at_foot, 5);
    EXPECT_EQ(at_top > 0, a.bricks.back().body == "top_beam");
    EXPECT_GT(beds, 40);
  }
}

TEST(GenerateWall, RigidUnitsAreWholeAndNamedByRow) {
  const Assembly a = assemble(read_scene(QUOIN_SCENES "/cube_wall_10.toml"));
  ASSERT_EQ(a.bricks.size(), 100u);
  EXPECT_EQ(a.joints.size(), 180u);
  for (const Brick& b : a.bricks) {
    EXPECT_TRUE(b.rigid && !b.beam);
    EXPECT_NEAR(b.size[0], 0.1, 1e-15);
    EXPECT_EQ(b.zones, (std::array<int, 3>{1, 1, 1}));
    EXPECT_EQ(b.body, b.course == 0 ? "bottom_course" : b.course == 9 ? "top_course" : "");
  }
}

// Hexahedra of the whole wall alternate like a chessboard, for any number of layers, so that the diagonals of adjacent
// faces coincide.
TEST(GenerateWall, PatternsOfFacingBlocksConform) {
  for (const char* zones : {"[4, 2, 2]", "[3, 1, 1]", "[3, 2, 1]", "[2, 1, 1]"}) {
    for (const char* mid : {"true", "false"}) {
      const Assembly a = assemble(
          solid_wall({kLintel, std::string("wall.zones=") + zones, std::string("wall.mid_unit_joints=") + mid}));
      for (const Brick& b : a.bricks) {
        if (b.rigid) continue;
        const auto column = std::lround(b.origin[0] / b.size[0] * b.zones[0]);
        const auto row = std::lround(b.origin[1] / b.size[1] * b.zones[1]);
        EXPECT_EQ(b.parity, (column + row) % 2) << zones << " " << mid;
      }
    }
  }
}

TEST(MasonryPlace, HalvesOfAUnitHaveOneNumberAndLooseBlocksTheirOwn) {
  EXPECT_EQ(unit_key(4, {0, 0}), unit_key(5, {0, 0}));
  EXPECT_EQ(unit_key(9, {3, 1}), unit_key(2, {3, 7}));
  std::set<std::uint64_t> keys;
  for (int i = 0; i < 5; ++i) keys.insert({unit_key(10 + i, {i, 0}), unit_key(i, {-1, -1})});
  EXPECT_EQ(keys.size(), 10u);
  EXPECT_EQ(joint_key(3, 5), joint_key(5, 3));
  EXPECT_NE(joint_key(3, 5), joint_key(3, 6));
}

// Half units of transverse walls are along z: their zones are rotated with them, and none is beside its corner.
TEST(GenerateBuilding, TransverseWallsAreTheSameBricksTurned) {
  const Scene scene = read_scene(QUOIN_SCENES "/pavia_window.toml");
  const BuildingSpec& spec = *scene.building;
  EXPECT_EQ(spec.walls[0].axis, 0);
  EXPECT_EQ(spec.walls[1].axis, 2);
  const Assembly a = assemble(scene);
  int along_x = 0, along_z = 0;
  for (const Brick& b : a.bricks) {
    if (b.rigid || b.beam) continue;
    const bool thick_x = std::abs(b.size[0] - spec.thickness) < 1e-9,
               thick_z = std::abs(b.size[2] - spec.thickness) < 1e-9;
    ASSERT_TRUE(thick_x || thick_z);
    if (thick_x && thick_z) continue;  // a corner
    const size_t length = thick_z ? 0 : 2;
    const Vec3& size = b.size;
    const double half_unit = spec.walls[thick_z ? 0 : 1].half_unit;
    EXPECT_NEAR(size[length] / b.zones[length], half_unit / spec.zones[0], 1e-9);
    EXPECT_EQ(b.zones[1], spec.zones[1]);
    EXPECT_EQ(b.zones[2 - length], spec.zones[2]);
    (thick_z ? along_x : along_z) += b.zones[length] / spec.zones[0];
  }
  // Wall B less six windows of 5 half units by 6 courses; walls A and C without openings.
  EXPECT_EQ(along_x, 28 * 40 - 6 * 5 * 6);
  EXPECT_EQ(along_z, 2 * 19 * 40);
}

// Running bond: the first two half units of a wall are one unit in every other course.
TEST(GenerateBuilding, UnitsAreTwoHalvesInEveryOtherCourse) {
  const Assembly a = assemble(read_scene(QUOIN_SCENES "/pavia_door.toml"));
  std::map<int, std::map<double, int>> units;  // course -> x -> unit
  for (const Brick& b : a.bricks)
    if (!b.rigid && !b.beam) units[b.course][b.origin[0]] = b.unit;
  for (int course = 0; course + 1 < 10; ++course) {
    const auto together = [&](int of) { return units[of].begin()->second == std::next(units[of].begin())->second; };
    EXPECT_NE(together(course), together(course + 1)) << course;
  }
}

// All faces that meet have one joint, of the family of its place, and no others have. The zones on both sides
// alternate.
void expect_joints_where_faces_meet(const Scene& scene, const std::array<std::string, 4>& beam_bed_unit_head) {
  const Assembly a = assemble(scene);
  std::map<std::pair<int, int>, const Joint*> joints;
  for (const Joint& j : a.joints)
    EXPECT_TRUE(joints.emplace(std::minmax(j.block_a, j.block_b), &j).second) << "two joints of a pair";
  std::size_t meetings = 0;
  for (int i = 0; i < static_cast<int>(a.bricks.size()); ++i) {
    for (int k = 0; k < i; ++k) {
      const Brick &one = a.bricks[size_t(k)], &other = a.bricks[size_t(i)];
      const Overlap shared = overlap_of(one, other);
      size_t touching = 3, beside = 0;
      for (size_t c = 0; c < 3; ++c) {
        if (std::abs(shared.gap(c)) < 1e-9) touching = c;
        if (shared.gap(c) < -1e-9) ++beside;
      }
      if (touching == 3 || beside < 2) continue;
      const auto found = joints.find({k, i});
      const bool cut = one.beam && other.beam;  // parts of a beam
      ASSERT_EQ(found == joints.end(), cut) << k << " " << i;
      if (cut) continue;
      ++meetings;
      const Joint& joint = *found->second;
      EXPECT_EQ(joint.face_a, static_cast<int>(2 * touching + 1));
      const Brick &lower = a.bricks[size_t(joint.block_a)], &upper = a.bricks[size_t(joint.block_b)];
      EXPECT_NEAR(lower.origin[touching] + lower.size[touching], upper.origin[touching], 1e-9);
      const bool at_beam = lower.course < 0 || upper.course < 0;
      EXPECT_EQ(a.families[size_t(joint.family)].name, beam_bed_unit_head[at_beam                    ? 0
                                                                          : touching == 1            ? 1
                                                                          : lower.unit == upper.unit ? 2
                                                                                                     : 3]);
      if (lower.rigid || upper.rigid) continue;
      long squares = lower.zones[touching];
      for (size_t c = 0; c < 3; ++c)
        if (c != touching) squares += std::lround((upper.origin[c] - lower.origin[c]) * upper.zones[c] / upper.size[c]);
      EXPECT_EQ(upper.parity, (lower.parity + std::abs(squares)) % 2) << k << " " << i;
    }
  }
  EXPECT_EQ(meetings, joints.size());
}

TEST(GenerateWall, JointsAreWhereFacesMeet) {
  expect_joints_where_faces_meet(solid_wall({kLintel, "wall.bottom_beam_cuts=[3, 5]",
                                             "joints.bed={law=\"elastic\",normal_stiffness=1e9,"
                                             "shear_stiffness=1e9}",
                                             "joints.beam={law=\"elastic\",normal_stiffness=1e9,shear_stiffness=1e9}",
                                             "wall.bed_joint=\"bed\"", "wall.beam_joint=\"beam\""}),
                                 {"beam", "bed", "unit", "mortar"});
}

TEST(GenerateBuilding, JointsAreWhereFacesMeet) {
  expect_joints_where_faces_meet(read_scene(QUOIN_SCENES "/pavia_window.toml",
                                            {"joints.bed={law=\"elastic\",normal_stiffness=1e9,shear_stiffness=1e9}",
                                             "joints.beam={law=\"elastic\",normal_stiffness=1e9,shear_stiffness=1e9}",
                                             "building.bed_joint=\"bed\"", "building.beam_joint=\"beam\""}),
                                 {"beam", "bed", "unit", "mortar"});
}

}  // namespace
}  // namespace quoin
