// Buildings: corners that conform and interlock, floors on rigid beams, equal forces at the floors.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "scene/quality.h"
#include "support.h"

namespace quoin {
namespace {

constexpr double kHalf = 0.2, kHeight = 0.16, kThickness = 0.25;

// Wall B along x between two corners, with transverse walls A and C; a floor of two beams near the top.
Scene small_building(int courses) {
  Scene scene;
  scene.materials["brick"] = {"brick", 2.4e9, 0.2, 1750.0};
  scene.joints["mortar"] = elastic_family(20e9, 8.3e9);
  scene.joints["mortar"].name = "mortar";
  scene.joints["unit"] = elastic_family(120e9, 50e9);
  scene.joints["unit"].name = "unit";
  BuildingSpec b;
  b.courses = courses;
  b.course_height = kHeight;
  b.thickness = kThickness;
  b.unit_material = "brick";
  b.bed_joint = b.head_joint = b.beam_joint = "mortar";
  b.unit_joint = "unit";
  b.walls = {{"B", 0, {kThickness, 0.0}, 3, kHalf, "whole", {}, {}},
             {"A", 2, {0.0, kThickness}, 2, kHalf, "whole", {}, {}},
             {"C", 2, {kThickness + 3 * kHalf, kThickness}, 2, kHalf, "whole", {}, {}}};
  b.corners = {{{0.0, 0.0}, 0, 1, {}}, {{kThickness + 3 * kHalf, 0.0}, 2, 0, {}}};
  for (int floor = 0; floor < 2; ++floor)
    b.floors.push_back({"floor_" + std::to_string(floor + 1), 0, floor * (courses / 2), {0, 2}, 10e3, {}});
  scene.building = b;
  return scene;
}

TEST(Building, CornersConformAndInterlock) {
  const Scene scene = small_building(4);
  const Assembly assembly = assemble(scene);
  EXPECT_EQ(assembly.bricks.size(), 4u * (3 + 2 + 2 + 2) + 1);
  const double plan = kThickness * (3 * kHalf + 2 * 2 * kHalf + 2 * kThickness);
  const Model model(assembly, make_materials(assembly));

  // Every bed has the area of the plan, less what two rigid blocks would share: the areas of joints are whole.
  std::map<long, double> bed;
  for (std::int32_t i = 0; i < model.point_count; ++i) {
    const auto p = static_cast<std::size_t>(i);
    if (model.point_axis[p] == 1) bed[std::lround(model.point_position[p][1] / kHeight)] += model.area[p];
  }
  ASSERT_EQ(bed.size(), 4u);
  for (const auto& [course, area] : bed) EXPECT_NEAR(area, plan, 1e-9 * plan) << course;

  // At a corner one of the two joints is inside a unit, and in the next course the other one.
  std::map<int, std::map<int, int>> inside;  // course, axis: joints of the left corner inside a unit
  for (const Joint& joint : assembly.joints) {
    const Brick &a = assembly.bricks[static_cast<std::size_t>(joint.block_a)],
                &c = assembly.bricks[static_cast<std::size_t>(joint.block_b)];
    const bool corner = !a.rigid && !c.rigid && a.origin[0] == 0.0 && a.origin[2] == 0.0 && joint.face_a != 3;
    if (!corner) continue;
    const bool unit = assembly.families[static_cast<std::size_t>(joint.family)].name == "unit";
    EXPECT_EQ(unit, a.unit == c.unit);
    inside[a.course][joint.face_a / 2] += unit;
  }
  ASSERT_FALSE(inside.empty());
  for (const auto& [course, axes] : inside) {
    if (axes.contains(0)) {
      EXPECT_EQ(axes.at(0), course % 2 == 0) << course;
    }
    if (axes.contains(2)) {
      EXPECT_EQ(axes.at(2), course % 2 == 1) << course;
    }
  }
}

struct Last : Observer {
  void on_row(const HistoryRow& row) override { last = row; }
  HistoryRow last;
};

// Stage 'push' of the whiffletree on the floors of a building, everything else free.
Stage push_floors(const BuildingSpec& building, double stiffness, double velocity) {
  Stage push;
  push.name = "push";
  BodyControl bottom;
  bottom.body = "bottom_beam";
  push.controls = {bottom};
  Whiffletree tree;
  for (const auto& floor : building.floors) {
    tree.floors.push_back(floor.bodies());
    for (const std::string& body : floor.bodies()) {
      BodyControl c;
      c.body = body;
      c.kind = {DofKind::free, DofKind::free, DofKind::free};
      c.may_turn = true;
      push.controls.push_back(c);
    }
  }
  tree.stiffness = stiffness;
  tree.velocity = velocity;
  push.whiffletree = tree;
  push.monitor = "bottom_beam";
  return push;
}

// The shear force at the ground for a roof displacement is that of the structure, whatever the tree's own stiffness.
double base_shear(double stiffness) {
  Scene scene = small_building(4);
  Stage push = push_floors(*scene.building, stiffness, 2e-3);
  push.displacement = 4e-5;
  push.ramp_time = 0.01;
  scene.stages = {push};
  Assembly assembly = assemble(scene);
  Simulation simulation(std::move(scene), std::move(assembly));
  Last last;
  simulation.run(last);
  EXPECT_NEAR(last.last.displacement, 4e-5, 1e-6);
  return last.last.resistance / last.last.displacement;
}

TEST(Building, TheWhiffletreeAddsNoStrength) {
  const double soft = base_shear(2e7), stiff = base_shear(2e8);
  EXPECT_GT(soft, 1e7);
  EXPECT_NEAR(soft / stiff, 1.0, 0.03);
}

// A tree so stiff that it sets the time step is a spring like others: stable to its limit. Were its force a step late,
// u(t + dt) - 2 u(t) + u(t - dt) = -(omega dt)^2 u(t - dt) would grow by sqrt(1 + (omega dt)^2) a step, at any step.
TEST(Building, TheWhiffletreeIsASpringWithinTheTimeStep) {
  const auto kinetic_energy = [](double fraction) {
    Scene scene = small_building(4);
    scene.solver.damping = DampingKind::none;
    scene.solver.time_step_fraction = fraction;
    scene.stages = {push_floors(*scene.building, 1e14, 1e-3)};
    const Assembly assembly = assemble(scene);
    Simulation simulation(scene, assembly);
    simulation.advance(500);
    return std::abs(simulation.measure().kinetic_energy);  // m v(-1/2) v(+1/2) / 2: negative when v alternates
  };
  EXPECT_LT(kinetic_energy(0.98), 1.0);
  EXPECT_GT(kinetic_energy(1.02), 1e6);
}

// Eq. 1 makes the springs of what moves one way throughout uneven: (1 - gamma) k where they push it ahead, (1 + gamma)
// k where they hold it back. Near four steps a period, from omega dt/2 = 1/sqrt(2) to 1/sqrt(2 (1 - gamma^2)), uneven
// springs feed drift into vibration until that is as fast as the drift and brakes it. Beams that were halves of units
// vibrated there against the other halves, along the drift and without viscosity: what remained of a blow did not die.
TEST(Building, BeamsThatDriftComeToRestAfterABlow) {
  Scene scene = small_building(12);
  scene.building->zones = {2, 2, 2};
  scene.building->walls = {{"B", 0, {0.0, 0.0}, 12, kHalf, "whole", {}, {}}};
  scene.building->corners.clear();
  scene.building->floors = {{"floor_1", 0, 8, {3, 5, 7, 9}, 0.0, {}}};
  scene.solver = quality_named("standard").solver;
  scene.stages = {push_floors(*scene.building, 1e8, 0.04)};
  scene.stages.front().ramp_time = 0.01;
  const Assembly assembly = assemble(scene);
  Simulation simulation(scene, assembly);
  simulation.advance(400);
  const auto count = static_cast<int>(assembly.bricks.size());
  for (int block = 0; block < count; ++block) {
    if (assembly.bricks[static_cast<std::size_t>(block)].rigid) continue;
    for (int n = 0; n < 27; ++n)
      simulation.velocity()[dof(simulation.model(), block, n, 0)] += block % 2 == 0 ? 5e-3 : -5e-3;
  }
  simulation.advance(1000);
  double drift = 0.0, change = 0.0;  // of the velocities of the beams, in a step
  for (int step = 0; step < 12; ++step) {
    std::vector<double> before;
    for (int block = 0; block < count; ++block) before.push_back(simulation.block_velocity(block).front()[0]);
    simulation.advance(1);
    for (int block = 0; block < count; ++block) {
      const Brick& brick = assembly.bricks[static_cast<std::size_t>(block)];
      if (!brick.rigid || brick.body == "bottom_beam") continue;
      const double now = simulation.block_velocity(block).front()[0];
      change = std::max(change, std::abs(now - before[static_cast<std::size_t>(block)]));
      drift = std::max(drift, now);
    }
  }
  EXPECT_GT(drift, 1e-3);
  EXPECT_LT(change, 0.3 * drift);
}

}  // namespace
}  // namespace quoin
