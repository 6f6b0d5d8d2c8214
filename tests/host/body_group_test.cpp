// Rigid bodies side by side in lanes: as one by one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "scene/read_scene.h"
#include "step/state.h"
#include "support.h"

namespace quoin {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Model cube_wall(int size) {
  Assembly assembly = assemble(read_scene(QUOIN_SCENES "/cube_wall_" + std::to_string(size) + ".toml", {}));
  auto materials = make_materials(assembly);
  return Model(std::move(assembly), std::move(materials));
}

TEST(BodyGroup, EveryBodyHasALaneAndEveryPointASlotOnEachSide) {
  for (const int size : {10, 20}) {
    const Model model = cube_wall(size);
    std::vector<int> seen(model.bodies.size(), 0);
    for (const int b : model.lone_bodies) ++seen[at(b)];
    std::vector<int> sides(at(model.point_count), 0);
    for (const BodyGroup& group : model.body_groups) {
      for (int lane = 0; lane < group.body_count; ++lane) ++seen[at(group.body[at(lane)])];
      const BodySlots& slots = model.body_slots[at(group.slots)];
      for (int slot = 0; slot < slots.slot_count(); ++slot) {
        for (int lane = 0; lane < kLanes; ++lane) {
          const std::int32_t point = model.slot_point[at((group.first_slot + slot) * kLanes + lane)];
          if (point == model.point_count) continue;
          ++sides[at(point)];
          const auto& node = slots.sign[at(slot)] > 0.0 ? model.node_a : model.node_b;
          EXPECT_EQ(node[at(point)], (group.first_line + slot) * kLine + lane);
          const Vec3 &centre = model.bodies[at(group.body[at(lane)])].centre, &arm = slots.arm[at(slot)];
          for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(centre[c] + arm[c], model.point_position[at(point)][c], 1e-12);
        }
      }
    }
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
    EXPECT_TRUE(std::all_of(sides.begin(), sides.end(), [](int n) { return n == 2; }));
  }
}

// The reason why neighbours are put into the lanes of one group.
TEST(BodyGroup, MostContactPointsOfAWallNeedNoGathers) {
  const Model model = cube_wall(20);
  const auto gathered = std::count(model.slot_run.begin(), model.slot_run.end(), -1);
  EXPECT_LT(static_cast<double>(gathered), 0.25 * static_cast<double>(model.slot_run.size()));
}

// Everything that a step moves, with random values.
struct RandomState {
  explicit RandomState(const Model& model)
      : displacement(at(model.line_count * kLine), 0.0),
        velocity(displacement),
        bodies(model.bodies.size()),
        measured(model.bodies.size()) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> value(-1.0, 1.0);
    std::bernoulli_distribution rarely(0.2);
    for (auto& column : force) {
      for (int i = 0; i < model.point_count; ++i) column.push_back(100.0 * value(random));
      column.resize(column.size() + kLanes, 0.0);  // the dummy
    }
    for (BodyState& body : bodies) {
      for (std::size_t c = 0; c < 3; ++c) {
        body.displacement[c] = 1e-3 * value(random);
        body.rotation[c] = 1e-3 * value(random);
        body.velocity[c] = value(random);
        body.spin[c] = value(random);
        body.applied_force[c] = 50.0 * value(random);
        body.prescribed_velocity[c] = value(random);
      }
      for (bool& prescribed : body.prescribed) prescribed = rarely(random);
    }
  }
  void bind(StepData* step) {
    step->displacement = displacement.data();
    step->velocity = velocity.data();
    for (std::size_t c = 0; c < 3; ++c) step->force[c] = force[c].data();
  }
  LaneVector<double> displacement, velocity, force[3];
  std::vector<BodyState> bodies;
  std::vector<Measured> measured;
};

void expect_near(const Vec3& x, const Vec3& y, double scale) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(x[c], y[c], 1e-13 * scale);
}

class BodyGroupDamping : public testing::TestWithParam<DampingKind> {};

TEST_P(BodyGroupDamping, MovesAndMeasuresItsBodiesLikeOneByOne) {
  Model model = cube_wall(10);
  for (std::size_t b = 0; b < model.bodies.size(); b += 7)
    model.bodies[b].held = {false, false, true, true, true, false};
  RandomState together(model);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (model.bodies[b].held[2])
      together.bodies[b].velocity[2] = together.bodies[b].spin[0] = together.bodies[b].spin[1] = 0.0;
  }
  RandomState alone = together;
  Inertia inertia;
  for (const RigidBody& body : model.bodies) {
    inertia.body_mass.push_back(1.5 * body.mass);
    inertia.body_inertia.push_back({1.5 * body.inertia[0], 1.5 * body.inertia[1], 2.0 * body.inertia[2]});
  }
  StepData step;
  step.time_step = 1e-5;
  step.damping = GetParam();
  step.local_damping = 0.8;
  step.mass_damping = 30.0;
  step.gravity = {0.5, -9.81, 0.1};

  for (const BodyGroup& group : model.body_groups) {
    const BodyGroupLanes lanes = lanes_of(group, model, inertia, step.time_step);
    Measured of_group, sum;
    together.bind(&step);
    advance_bodies(model, group, lanes, step, together.bodies.data(), &of_group);
    alone.bind(&step);
    for (int lane = 0; lane < group.body_count; ++lane) {
      const std::size_t b = at(group.body[at(lane)]);
      Measured one;
      advance_body(model.bodies[b], inertia.body_mass[b], inertia.body_inertia[b], step, &alone.bodies[b], &one);
      sum.unbalanced_squared = std::max(sum.unbalanced_squared, one.unbalanced_squared);
      sum.kinetic += one.kinetic;
      sum.damping_before += one.damping_before;
      sum.damping_after += one.damping_after;
      sum.external_before += one.external_before;
      sum.external_after += one.external_after;

      const BodyState &x = together.bodies[b], &y = alone.bodies[b];
      expect_near(x.joint_force, y.joint_force, 1e3);
      expect_near(x.velocity, y.velocity, 1.0);
      expect_near(x.spin, y.spin, 1.0);
      expect_near(x.displacement, y.displacement, 1e-3);
      expect_near(x.rotation, y.rotation, 1e-3);
      for (const std::int32_t slave : model.bodies[b].slave) {
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t i = at(slave) + c * kLanes;
          EXPECT_NEAR(together.velocity[i], alone.velocity[i], 1e-13);
          EXPECT_NEAR(together.displacement[i], alone.displacement[i], 1e-16);
        }
      }
    }
    EXPECT_NEAR(of_group.unbalanced_squared, sum.unbalanced_squared, 1e-12 * sum.unbalanced_squared);
    EXPECT_NEAR(of_group.kinetic, sum.kinetic, 1e-12 * sum.kinetic);
    EXPECT_NEAR(of_group.damping_before, sum.damping_before, 1e-14);
    EXPECT_NEAR(of_group.damping_after, sum.damping_after, 1e-14);
    EXPECT_NEAR(of_group.external_before, sum.external_before, 1e-14);
    EXPECT_NEAR(of_group.external_after, sum.external_after, 1e-14);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, BodyGroupDamping,
                         testing::Values(DampingKind::none, DampingKind::local, DampingKind::viscous,
                                         DampingKind::block));

}  // namespace
}  // namespace quoin
