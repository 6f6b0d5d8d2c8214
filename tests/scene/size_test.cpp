// Estimated sizes of a model before it is built, against the numbers of `quoin check` in the model.
#include "scene/size.h"

#include <gtest/gtest.h>

#include "scene/read_scene.h"

namespace quoin {
namespace {

SceneSize size_with(const std::string& scene, const std::vector<std::string>& overrides = {}) {
  return size_of(read_scene(std::string(QUOIN_SCENES) + "/" + scene + ".toml", overrides));
}

TEST(Size, OfAWallIsCountedBeforeItIsMade) {
  const SceneSize wall = size_with("solid_wall_030");
  EXPECT_EQ(wall.blocks, 144);
  EXPECT_EQ(wall.zones, 11520);
  EXPECT_EQ(wall.points, 144 * (3 * 3 + 5 * 3)) << "a head and a bed joint of each; 3447 of the model, which has ends";
  // Twice the number of courses and units.
  const SceneSize larger = size_with("solid_wall_030", {"wall.courses=32", "wall.units_per_course=9"});
  EXPECT_EQ(larger.blocks, 4 * wall.blocks);
  EXPECT_NEAR(larger.bytes, 4 * wall.bytes, 1e-9 * larger.bytes);
  EXPECT_EQ(size_with("solid_wall_030", {"wall.zones=[8,4,4]"}).zones, 8 * wall.zones);
  EXPECT_EQ(size_with("solid_wall_030", {"wall.half_thickness=true"}).zones, wall.zones / 2);
  // Whole units: half the number of blocks, with twice the hexahedra along them.
  const SceneSize whole = size_with("solid_wall_030", {"wall.mid_unit_joints=false"});
  EXPECT_EQ(whole.blocks, 72);
  EXPECT_EQ(whole.zones, wall.zones);
  EXPECT_EQ(whole.points, 72 * (3 * 3 + 2 * 5 * 3)) << "a head joint, and a bed joint on each half of the unit below";
  // 28 half units and two corners in 40 courses, without subtraction of openings.
  const SceneSize building = size_with("pavia_door");
  EXPECT_EQ(building.blocks, 30 * 40);
  EXPECT_EQ(building.zones, 30 * 40 * 80);
  // Too large for any machine and any integer.
  const SceneSize huge =
      size_with("solid_wall_030", {"wall.courses=10000", "wall.units_per_course=10000", "wall.zones=[64,64,64]"});
  EXPECT_EQ(huge.zones, 2e8 * 5 * 64 * 64 * 64);
  EXPECT_GT(huge.bytes, 1e15);
}

TEST(Size, OfBlocksFollowsTheirEdgesAndPoints) {
  const SceneSize arch = size_with("arch");
  EXPECT_EQ(arch.zones, 0);
  EXPECT_EQ(arch.blocks, 7 + 2) << "voussoirs and abutments";
  EXPECT_EQ(arch.points, 12 * arch.blocks) << "the corners of one face in each direction";
  const SceneSize dense = size_with("arch", {"contact.point_spacing=0.001"});
  EXPECT_GT(dense.points, 100 * arch.points);
  EXPECT_EQ(dense.blocks, arch.blocks);
  const SceneSize zoned = size_with("arch", {"arch.arch.rigid=false", "arch.arch.zone_edge=0.01"});
  // A voussoir has 157.5/7 degrees at 10.75 m, is 1.5 m thick and 1 m deep: 423, 150 and 100 hexahedra of 5 zones.
  EXPECT_EQ(zoned.blocks, 7);
  EXPECT_EQ(zoned.zones, 7.0 * 5 * 423 * 150 * 100);
}

// Numbers of hexahedra by hand: a dry wall of halves and whole units, and blocks with sizes given in each way.
TEST(Size, OfEachWayToGiveABlockIsThatOfItsHexahedra) {
  const std::string begin =
      "[materials.stone]\ndensity = 2000\nyoung_modulus = 1e10\npoisson_ratio = 0.2\n[joints.dry]\nlaw = "
      "\"elastic\"\nnormal_stiffness = 1e9\nshear_stiffness = 5e8\n";
  const std::string end = "[[stage]]\nduration = 0.1\n";
  const auto size = [&](const std::string& blocks) { return size_of(read_scene_text(begin + blocks + end, "s", {})); };
  const auto expect = [](const SceneSize& s, double blocks, double zones, double points) {
    EXPECT_EQ(s.blocks, blocks);
    EXPECT_EQ(s.zones, zones);
    EXPECT_EQ(s.points, points);
  };
  const auto faces = [](double x, double y, double z) {
    return (x + 1) * (y + 1) + (y + 1) * (z + 1) + (z + 1) * (x + 1);
  };
  const std::string wall =
      "[[dry_wall]]\nmaterial = \"stone\"\ncourses = 3\nunits_per_course = 4\nunit = [0.4, 0.2, 0.3]\n";
  // A course of 4 units has at most 5 pieces, with head joints, and two bed joints for each unit. Elastic joints may
  // have the 17 points that integrate bending, unless corners are requested.
  expect(size(wall), 15, 0, 15 * (17 + 2 * 17));
  expect(size(wall + end + "[contact]\ncubic_points = false\n"), 15, 0, 15 * (4 + 2 * 4));
  expect(size(wall + "rigid = false\nzones = [2, 3, 4]\n"), 15, 15 * 5 * 4 * 3 * 4, 15 * (4 * 5 + 2 * 3 * 5));
  expect(size(wall + "rigid = false\nzones = [2, 3, 4]\nmid_unit_joints = true\n"), 30, 30 * 5 * 2 * 3 * 4,
         30 * (4 * 5 + 3 * 5));
  expect(size(wall + "rigid = false\nzone_edge = 0.15\nmid_unit_joints = true\n"), 30, 30 * 5 * 2 * 2 * 2,
         30 * (3 * 3 + 3 * 3));
  const std::string block = "[[block]]\nmaterial = \"stone\"\n", soft = "rigid = false\n";
  const std::string box = "box = { lower = [7, 8, 9], size = [0.6, 0.3, 0.2] }\n";
  expect(size(block + box + soft + "zone_edge = 0.15\n"), 1, 5 * 4 * 2 * 2, faces(4, 2, 2));
  expect(size(block + box + soft + "divisions = [3, 1, 2]\n"), 1, 5 * 3 * 1 * 2, faces(3, 1, 2));
  expect(size(block + box + end + "[contact]\npoint_spacing = 0.2\n"), 1, 0, faces(3, 2, 1));
  const std::string corners = "vertices = [[-0.2, 1, 0], [0.4, 1, 0], [-0.2, 1.3, 0], [-0.2, 1, 0.2]]\n";
  expect(size(block + corners + soft + "zone_edge = 0.15\n"), 1, 5 * 4 * 2 * 2, faces(4, 2, 2));
  expect(size(block + corners + soft + "tetrahedra = [[0, 1, 2, 3]]\n"), 1, 1, 4);
}

// Against the measured peak memory of runs, less that of a run of six blocks. (VmHWM, one thread, a few steps, on a
// machine with pages of 4 kB; benchmarks/RANKS.md has the list.) Tolerance of a third, beyond which the estimate must
// be updated.
TEST(Size, OfMemoryIsWhatRunsTake) {
  const auto reported = [](const std::vector<std::string>& overrides) {
    return size_of(read_scene(std::string(QUOIN_SCENES) + "/../../tests/cli/small_wall.toml", overrides)).bytes / 1e6;
  };
  const auto expect = [&](double measured, const std::vector<std::string>& overrides) {
    EXPECT_NEAR(reported(overrides) / measured, 1.0, 0.33) << overrides.back();
  };
  expect(275, {"wall.courses=200", "wall.units_per_course=200"});
  expect(63, {"wall.courses=100", "wall.units_per_course=100"});
  expect(43, {"wall.courses=100", "wall.units_per_course=100", "wall.zones=[1, 1, 1]"});
  expect(47, {"wall.courses=50", "wall.units_per_course=50", "wall.zones=[4, 2, 2]"});
  expect(37, {"wall.courses=20", "wall.units_per_course=20", "wall.zones=[8, 4, 4]"});
  expect(168, {"wall.courses=100", "wall.units_per_course=100", "solver.large_motion='always'"});
  expect(34, {"wall.courses=30", "wall.units_per_course=30", "wall.zones=[4, 2, 2]", "solver.large_motion='always'"});
}

// A rank on the lattice has its part and the outline of the whole model.
TEST(Size, OfARankIsItsPartAndTheOutline) {
  const std::vector<std::string> wall{"wall.courses=200", "wall.units_per_course=200"};
  const auto size = [&](std::vector<std::string> overrides) {
    overrides.insert(overrides.end(), wall.begin(), wall.end());
    return size_of(read_scene(std::string(QUOIN_SCENES) + "/../../tests/cli/small_wall.toml", overrides));
  };
  const SceneSize lattice = size({}), in_motion = size({"solver.large_motion='always'"});
  EXPECT_EQ(lattice.bytes_of_rank(1), lattice.bytes);
  // Measured: the rank with the largest memory of 2, 4 and 8, less that of a rank with a wall of six blocks.
  EXPECT_NEAR(lattice.bytes_of_rank(2) / 180e6, 1.0, 0.25);
  EXPECT_NEAR(lattice.bytes_of_rank(4) / 116e6, 1.0, 0.25);
  EXPECT_NEAR(lattice.bytes_of_rank(8) / 86e6, 1.0, 0.25);
  EXPECT_LT(in_motion.bytes_of_rank(8), 0.5 * in_motion.bytes);
  // A quarter of the wall in large motion, 2 and 4 ranks.
  const SceneSize quarter =
      size_of(read_scene(std::string(QUOIN_SCENES) + "/../../tests/cli/small_wall.toml",
                         {"wall.courses=100", "wall.units_per_course=100", "solver.large_motion='always'"}));
  EXPECT_NEAR(quarter.bytes_of_rank(2) / 112e6, 1.0, 0.3);
  EXPECT_NEAR(quarter.bytes_of_rank(4) / 90e6, 1.0, 0.3);
}

}  // namespace
}  // namespace quoin
