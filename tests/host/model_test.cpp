#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support.h"

namespace quoin {
namespace {

Model make_model(Assembly assembly) {
  auto materials = make_materials(assembly);
  return Model(std::move(assembly), std::move(materials));
}

std::vector<double> joint_areas(const Model& model) {
  std::vector<double> area(model.assembly.joints.size(), 0.0);
  for (std::int32_t p = 0; p < model.point_count; ++p) {
    area[static_cast<std::size_t>(model.point_joint[static_cast<std::size_t>(p)])] +=
        model.area[static_cast<std::size_t>(p)];
  }
  return area;
}

TEST(Model, SolidWallHasAllItsBlocksZonesAndContactPoints) {
  const Scene scene = wall_scene();
  const Model model = make_model(assemble(scene));
  EXPECT_EQ(model.assembly.bricks.size(), 146u);
  EXPECT_EQ(model.bodies.size(), 2u);
  EXPECT_EQ(model.zone_count(), 11520u);
  EXPECT_EQ(model.point_count, 3447);  // 17 x 9 beds of 15, 16 x 8 heads of 9
  EXPECT_EQ(model.groups.size(), 18u);
  EXPECT_EQ(model.templates.size(), 1u);
  EXPECT_NEAR(model.total_mass(), 1900 * 0.99 * 1.0 * 0.1 + 2 * 7850 * 0.99 * 0.1 * 0.1, 1e-9);
}

TEST(Model, AreasSumToTheJoint) {
  for (const auto& zones : {std::array{4, 2, 2}, std::array{3, 1, 2}, std::array{1, 1, 1}, std::array{3, 5, 3}}) {
    const Model model = make_model(brick_grid({2, 3, 2}, {0.11, 0.0625, 0.1}, zones));
    const auto area = joint_areas(model);
    for (std::size_t j = 0; j < area.size(); ++j) {
      const std::size_t n = static_cast<std::size_t>(model.assembly.joints[j].face_a / 2);
      const Vec3 size{0.11, 0.0625, 0.1};
      EXPECT_NEAR(area[j], size[(n + 1) % 3] * size[(n + 2) % 3], 1e-15);
    }
  }
}

TEST(Model, FacesWithOtherDiagonalsShareTheMeanOfBothSides) {
  Assembly assembly = brick_grid({2, 1, 1}, {0.1, 0.1, 0.1}, {1, 1, 1});
  assembly.bricks[1].parity = 0;  // with this parity the diagonals of the shared face cross
  const Model model = make_model(assembly);
  ASSERT_EQ(model.point_count, 4);
  for (double area : model.area) EXPECT_NEAR(area, 0.0025, 1e-15);  // mean of 1/3 and 1/6 of the face
}

TEST(Model, WholeUnitsLieOnTwo) {
  Scene scene = wall_scene(4, 3);
  scene.wall->mid_unit_joints = false;
  const Model model = make_model(assemble(scene));
  double bed = 0.0;
  const auto area = joint_areas(model);
  for (std::size_t j = 0; j < area.size(); ++j) {
    if (model.assembly.joints[j].face_a == 3) bed += area[j];
  }
  EXPECT_NEAR(bed, 5 * 0.66 * 0.1, 1e-12);
}

TEST(Model, HalfThicknessHoldsTheMiddlePlane) {
  Scene scene = wall_scene(3, 2);
  scene.wall->half_thickness = true;
  const Model model = make_model(assemble(scene));
  int held = 0, moving = 0;
  for (int block = 0; block < 12; ++block) {
    const auto& shape = model.templates[static_cast<std::size_t>(
        model.groups[static_cast<std::size_t>(model.place[static_cast<std::size_t>(block)].group)].brick_template)];
    for (int n = 0; n < shape.node_count; ++n) {
      const bool on_plane = shape.node[static_cast<std::size_t>(n)][2] == 0.0;
      EXPECT_EQ(model.node_free[dof(model, block, n, 2)], on_plane ? 0.0 : 1.0);
      EXPECT_EQ(model.node_free[dof(model, block, n, 0)], 1.0);
      (on_plane ? held : moving) += 1;
    }
  }
  EXPECT_EQ(held, 12 * 15);
  EXPECT_EQ(moving, 12 * 15);
}

TEST(Model, EveryPointIsInOneSlotOfEachSide) {
  const Model model = make_model(assemble(wall_scene(5, 2.5)));
  std::vector<int> seen(static_cast<std::size_t>(model.point_count) + 1, 0);
  for (std::int32_t p : model.slot_point) ++seen[static_cast<std::size_t>(p)];
  for (const RigidBody& body : model.bodies) {
    for (std::int32_t p : body.point) ++seen[static_cast<std::size_t>(p)];
  }
  seen.pop_back();  // the dummy
  EXPECT_THAT(seen, testing::Each(2));
}

TEST(Model, RigidFacesMeetAtTheirCorners) {
  Assembly assembly = brick_grid({1, 2, 1}, {0.4, 0.2, 0.3}, {1, 1, 1});
  for (Brick& brick : assembly.bricks) brick.rigid = true;
  assembly.bricks[1].origin[0] = 0.2;  // half of the brick overhangs
  const Model model = make_model(assembly);
  ASSERT_EQ(model.point_count, 4);
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_NEAR(model.area[p], 0.2 * 0.3 / 4, 1e-15);
    EXPECT_TRUE(std::abs(model.point_position[p][0] - 0.2) < 1e-12 ||
                std::abs(model.point_position[p][0] - 0.4) < 1e-12);
  }
}

// Rigid blocks with zones have contact points at the corners of zones in the common part: 0.2 by 0.3 m, 2 by 3 zones.
// Their areas are weights of the trapezoidal rule.
TEST(Model, RigidFacesOfZonesMeetOnAGrid) {
  for (const std::size_t axis : {0u, 1u, 2u}) {
    const std::size_t s = (axis + 1) % 3, t = (axis + 2) % 3;
    std::array<int, 3> count{1, 1, 1}, zones{1, 1, 1};
    Vec3 size{0.1, 0.1, 0.1};
    count[axis] = 2, size[s] = 0.4, zones[s] = 4, size[t] = 0.3, zones[t] = 3;
    Assembly assembly = brick_grid(count, size, zones);
    for (Brick& brick : assembly.bricks) brick.rigid = true;
    assembly.bricks[1].origin[s] += 0.2;
    const Model model = make_model(assembly);
    ASSERT_EQ(model.point_count, 3 * 4);
    double area = 0.0;
    for (std::size_t p = 0; p < 12; ++p) {
      const double i = (model.point_position[p][s] - 0.2) / 0.1, j = model.point_position[p][t] / 0.1;
      EXPECT_NEAR(i, std::round(i), 1e-9);
      EXPECT_NEAR(j, std::round(j), 1e-9);
      EXPECT_TRUE(i > -0.1 && i < 2.1 && j > -0.1 && j < 3.1);
      EXPECT_NEAR(model.point_position[p][axis], 0.1, 1e-12);
      const bool end_i = std::abs(i - 1) > 0.5, end_j = std::abs(j - 1.5) > 1;
      EXPECT_NEAR(model.area[p], 0.01 * (end_i ? 0.5 : 1.0) * (end_j ? 0.5 : 1.0), 1e-15);
      area += model.area[p];
    }
    EXPECT_NEAR(area, 0.2 * 0.3, 1e-15);
  }
}

TEST(Model, RefusesWhatDoesNotFit) {
  Assembly apart = brick_grid({2, 1, 1}, {0.1, 0.1, 0.1}, {1, 1, 1});
  apart.bricks[1].origin[0] += 0.001;
  EXPECT_THROW(make_model(apart), Error);
  Assembly unlike = brick_grid({2, 1, 1}, {0.1, 0.1, 0.1}, {1, 1, 1});
  unlike.bricks[1].origin[1] += 0.05;
  EXPECT_THROW(make_model(unlike), Error);
  Assembly soft = brick_grid({1, 1, 1}, {0.1, 0.1, 0.1}, {1, 1, 1});
  soft.materials[0].poisson_ratio = 0.5;
  EXPECT_THROW(make_model(soft), Error);
}

}  // namespace
}  // namespace quoin
