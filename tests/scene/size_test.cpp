// Sizes that are told before a model is made, beside those that `quoin check` counts in the model.
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
  EXPECT_GE(wall.points, 3447);  // of the model: an upper bound
  EXPECT_LE(wall.points, 3 * 3447);
  // Twice as many of all in each direction.
  const SceneSize larger = size_with("solid_wall_030", {"wall.courses=32", "wall.units_per_course=9"});
  EXPECT_EQ(larger.blocks, 4 * wall.blocks);
  EXPECT_NEAR(larger.bytes, 4 * wall.bytes, 1e-9 * larger.bytes);
  EXPECT_EQ(size_with("solid_wall_030", {"wall.zones=[8,4,4]"}).zones, 8 * wall.zones);
  EXPECT_EQ(size_with("solid_wall_030", {"wall.half_thickness=true"}).zones, wall.zones / 2);
  // Beyond any machine, and beyond any integer.
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
  EXPECT_GT(zoned.zones, 1000);
}

}  // namespace
}  // namespace quoin
