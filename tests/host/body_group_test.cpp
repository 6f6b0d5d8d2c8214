// Rigid bodies in the lanes of a SIMD group move as single bodies do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <random>

#include "../../benchmarks/step/hot_arrays.h"
#include "base/index.h"
#include "scene/read_scene.h"
#include "step/rigid_bodies.h"
#include "support.h"

namespace quoin {
namespace {

Model wall_of_cubes(int size) {
  Assembly assembly = assemble(read_scene(QUOIN_SCENES "/cube_wall_" + std::to_string(size) + ".toml", {}));
  auto materials = make_materials(assembly);
  return Model(std::move(assembly), std::move(materials));
}

TEST(BodyGroup, EveryBodyHasALaneAndEveryPointASlotOnEachSide) {
  for (const int size : {10, 20}) {
    const Model model = wall_of_cubes(size);
    std::vector<int> seen(model.bodies.size(), 0);
    for (const int b : model.lone_bodies) ++seen[at(b)];
    std::vector<int> sides(at(model.point_count), 0);
    for (const BodyGroup& group : model.body_groups) {
      for (int lane = 0; lane < group.body_count; ++lane) ++seen[at(group.body[at(lane)])];
      const BodySlots& slots = model.body_slots[at(group.slots)];
      for (int slot = 0, face = 0; slot < slots.slot_count(); ++slot) {
        while (slot >= slots.face[at(face)].slot_end) ++face;
        const std::size_t n = at(face / 2), s = (n + 1) % 3, t = (n + 2) % 3;
        Vec3 arm;
        arm[n] = slots.face[at(face)].normal_arm;
        arm[s] = slots.arm[at(slot)][0];
        arm[t] = slots.arm[at(slot)][1];
        for (int lane = 0; lane < kLanes; ++lane) {
          const std::int32_t point = model.slot_point[at((group.first_slot + slot) * kLanes + lane)];
          if (point == model.point_count) continue;
          ++sides[at(point)];
          EXPECT_EQ(model.point_axis[at(point)], n);
          const auto& node = face % 2 == 1 ? model.node_a : model.node_b;
          EXPECT_EQ(node[at(point)], (group.first_line + slot) * kLine + lane);
          const Vec3& centre = model.bodies[at(group.body[at(lane)])].centre;
          for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(centre[c] + arm[c], model.point_position[at(point)][c], 1e-12);
        }
      }
    }
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
    EXPECT_TRUE(std::all_of(sides.begin(), sides.end(), [](int n) { return n == 2; }));
  }
}

// The arrays that the step benchmark counts for the processor's caches.
TEST(BodyGroup, HotArraysAreWhatAStepReads) {
  const Simulation simulation(read_scene(QUOIN_SCENES "/cube_wall_10.toml", {}));
  const Model& model = simulation.model();
  std::map<std::string, std::size_t> bytes;
  for (const HotArray& array : hot_arrays(simulation))
    if (array.of != HotOf::block) bytes[array.what] = array.bytes;
  const std::size_t points = at(model.point_count);
  EXPECT_EQ(bytes["traction"], points * 24);
  EXPECT_EQ(bytes["offsets of the two gridpoints"], points * 8);
  std::size_t slots = 0;  // of all groups; each has three doubles in a lane, and one integer for its points in a row
  for (const BodyGroup& group : model.body_groups) slots += at(model.body_slots[at(group.slots)].slot_count());
  EXPECT_GE(slots * kLanes, 2 * points) << "both sides of every point";
  EXPECT_EQ(bytes["gridpoints: displacement along the normal, velocity across"], slots * kLanes * 24);
  EXPECT_EQ(bytes["where slots find their points in a row"], slots * 4);
}

// The order of contact points exists for this.
TEST(BodyGroup, MostContactPointsOfAWallNeedNoGathers) {
  const Model model = wall_of_cubes(20);
  const auto gathered = std::count(model.slot_run.begin(), model.slot_run.end(), -1);
  EXPECT_LT(static_cast<double>(gathered), 0.15 * static_cast<double>(model.slot_run.size()));
}

using Quantity = BodyLanes::Quantity BodyLanes::*;

double random_value(std::mt19937_64& random) { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); }

// One random body in all lanes.
BodyLanes random_body(std::mt19937_64& random, const RigidBody& body) {
  BodyLanes lanes;
  const auto fill = [&](Quantity quantity, std::size_t c, double size) {
    const double value = size * random_value(random);
    for (double& x : (lanes.*quantity)[c]) x = value;
  };
  for (std::size_t c = 0; c < 3; ++c) {
    fill(&BodyLanes::displacement, c, 1e-3);
    fill(&BodyLanes::rotation, c, 1e-3);
    fill(&BodyLanes::velocity, c, body.held[c] ? 0.0 : 1.0);
    fill(&BodyLanes::spin, c, body.held[3 + c] ? 0.0 : 1.0);
    fill(&BodyLanes::applied_force, c, 50.0);
    fill(&BodyLanes::prescribed_velocity, c, 1.0);
  }
  for (auto& prescribed : lanes.prescribed) {
    const double on = std::bernoulli_distribution(0.2)(random) ? 1.0 : 0.0;
    lanes.any_prescribed = lanes.any_prescribed || on != 0.0;
    for (double& x : prescribed) x = on;
  }
  return lanes;
}

void copy_lane(const BodyLanes& from, int lane, BodyLanes* to) {
  const auto i = at(lane);
  for (const Quantity quantity : {&BodyLanes::displacement, &BodyLanes::rotation, &BodyLanes::velocity,
                                  &BodyLanes::spin, &BodyLanes::applied_force, &BodyLanes::prescribed_velocity}) {
    for (std::size_t c = 0; c < 3; ++c) (to->*quantity)[c][i] = (from.*quantity)[c][i];
  }
  for (std::size_t dof = 0; dof < 6; ++dof) to->prescribed[dof][i] = from.prescribed[dof][i];
  to->any_prescribed = to->any_prescribed || from.any_prescribed;
}

// Displacements and velocities that bodies give to contact points.
struct Field {
  explicit Field(const Model& model) : displacement(at(model.line_count * kLine), 0.0), velocity(displacement) {}
  LaneVector<double> displacement, velocity;
};

// A step with all actions on bodies, and random forces of the contact points.
struct StepInput {
  StepInput(const Model& model, const Damping& damping, std::mt19937_64& random) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (int i = 0; i < model.point_count; ++i) force[c].push_back(100.0 * random_value(random));
      force[c].resize(force[c].size() + kLanes, 0.0);  // the dummy
      step.force[c] = force[c].data();
    }
    step.time_step = 1e-5;
    step.eq1 = damping.eq1, step.local_damping = damping.gamma, step.mass_damping = damping.alpha;
    step.gravity = {0.5, -9.81, 0.1};
  }
  LaneVector<double> force[3];
  StepData step;
};

class BodyGroupDamping : public testing::TestWithParam<Damping> {};

TEST_P(BodyGroupDamping, MovesAndMeasuresItsBodiesLikeOneByOne) {
  Model model = wall_of_cubes(10);
  for (std::size_t b = 0; b < model.bodies.size(); b += 7)
    model.bodies[b].held = {false, false, true, true, true, false};
  std::mt19937_64 random(1);
  StepInput input(model, GetParam(), random);
  Field together(model), alone(model);
  Inertia inertia;
  for (const RigidBody& body : model.bodies) {
    inertia.body_mass.push_back(1.5 * body.mass);
    inertia.body_inertia.push_back({1.5 * body.inertia[0], 1.5 * body.inertia[1], 2.0 * body.inertia[2]});
  }
  StepData& step = input.step;
  const auto use = [&](Field& field) {
    step.displacement = field.displacement.data();
    step.velocity = field.velocity.data();
  };

  for (const BodyGroup& group : model.body_groups) {
    BodyLanes all;
    std::vector<BodyLanes> single;
    for (int lane = 0; lane < group.body_count; ++lane) {
      single.push_back(random_body(random, model.bodies[at(group.body[at(lane)])]));
      copy_lane(single.back(), lane, &all);
    }
    Measured of_group, sum;
    use(together);
    advance_bodies(model, group, inertia_of(group, model, inertia, step.time_step), step, &all, &of_group);
    use(alone);
    for (int lane = 0; lane < group.body_count; ++lane) {
      const std::size_t b = at(group.body[at(lane)]);
      Measured one;
      advance_body(model.bodies[b], inertia.body_mass[b], inertia.body_inertia[b], step, &single[at(lane)], &one);
      sum.unbalanced_squared = std::max(sum.unbalanced_squared, one.unbalanced_squared);
      sum.kinetic += one.kinetic;
      sum.damping_before += one.damping_before;
      sum.damping_after += one.damping_after;
      sum.external_before += one.external_before;
      sum.external_after += one.external_after;

      const auto expect_same = [&](Quantity quantity, double scale) {
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR((all.*quantity)[c][at(lane)], (single[at(lane)].*quantity)[c][0], 1e-13 * scale);
      };
      expect_same(&BodyLanes::velocity, 1.0);
      expect_same(&BodyLanes::spin, 1.0);
      expect_same(&BodyLanes::displacement, 1e-3);
      expect_same(&BodyLanes::rotation, 1e-3);
      for (std::size_t i = 0; i < model.bodies[b].slave.size(); ++i) {
        const std::size_t slave = at(model.bodies[b].slave[i]), n = model.point_axis[at(model.bodies[b].point[i])];
        const std::size_t normal = slave + n * kLanes;
        EXPECT_NEAR(together.displacement[normal], alone.displacement[normal], 1e-16);
        for (const std::size_t across : {slave + (n + 1) % 3 * kLanes, slave + (n + 2) % 3 * kLanes})
          EXPECT_NEAR(together.velocity[across], alone.velocity[across], 1e-13);
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

// Bodies at rest are skipped by the step, which is correct only if a step changes no bit of them.
TEST_P(BodyGroupDamping, ABodyHeldStillIsNotChangedByAStep) {
  const Model model = wall_of_cubes(10);
  std::mt19937_64 random(2);
  StepInput input(model, GetParam(), random);
  Inertia inertia;
  for (const RigidBody& body : model.bodies) {
    inertia.body_mass.push_back(body.mass);
    inertia.body_inertia.push_back(body.inertia);
  }
  Field field(model);
  StepData& step = input.step;
  step.displacement = field.displacement.data();
  step.velocity = field.velocity.data();

  for (const BodyGroup& group : model.body_groups) {
    BodyLanes held;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        held.displacement[c][lane] = 1e-3 * random_value(random);
        held.rotation[c][lane] = 1e-3 * random_value(random);
        held.prescribed[c][lane] = held.prescribed[3 + c][lane] = 1.0;
      }
    }
    held.any_prescribed = true;
    Measured measured;
    const auto advance = [&](BodyLanes* lanes) {
      advance_bodies(model, group, inertia_of(group, model, inertia, step.time_step), step, lanes, &measured);
    };
    advance(&held);  // writes the gridpoints, which do not change in later steps
    const Field before = field;
    BodyLanes after = held;
    advance(&after);
    for (const Quantity quantity :
         {&BodyLanes::displacement, &BodyLanes::rotation, &BodyLanes::velocity, &BodyLanes::spin})
      EXPECT_EQ(std::memcmp(held.*quantity, after.*quantity, sizeof(BodyLanes::Quantity)), 0);
    EXPECT_EQ(field.displacement, before.displacement);
    EXPECT_EQ(field.velocity, before.velocity);
    for (const double x : {measured.unbalanced_squared, measured.kinetic, measured.damping_before,
                           measured.damping_after, measured.external_before, measured.external_after})
      EXPECT_EQ(x, 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, BodyGroupDamping,
                         testing::Values(Damping{}, Damping{.eq1 = Eq1::gridpoints, .gamma = 0.8},
                                         Damping{.alpha = 30.0}, Damping{.eq1 = Eq1::rigid_motion, .gamma = 0.8}));

}  // namespace
}  // namespace quoin
