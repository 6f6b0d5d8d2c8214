// Buildings: corners that conform and interlock, floors on rigid beams, equal forces at the floors.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.h"
#include "base/input_file.h"
#include "model/motion.h"
#include "model/world_results.h"
#include "scene/quality.h"
#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"
#include "thread_ranks.h"

namespace quoin {
namespace {

constexpr double kHalf = 0.2, kHeight = 0.16, kThickness = 0.25;

// Wall B along x between two corners, with transverse walls A and C. A floor of two beams near the top, rigid ones or
// half units.
Scene small_building(int courses, bool rigid_beams = true) {
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
    b.floors.push_back(
        {"floor_" + std::to_string(floor + 1), 0, floor * (courses / 2), {0, 2}, 10e3, 0.0, {}, rigid_beams});
  scene.building = b;
  return scene;
}

TEST(Building, CornersConformAndInterlock) {
  const Scene scene = small_building(4);
  const Assembly assembly = assemble(scene);
  EXPECT_EQ(assembly.bricks.size(), 4u * (3 + 2 + 2 + 2) + 1);
  const double plan = kThickness * (3 * kHalf + 2 * 2 * kHalf + 2 * kThickness);
  const Model model(assembly, make_materials(assembly));

  // Every bed has the area of the plan, except for faces between two rigid blocks: no joint is missing.
  std::map<long, double> bed;
  for (std::int32_t i = 0; i < model.point_count; ++i) {
    const auto p = static_cast<std::size_t>(i);
    if (model.point_axis[p] == 1) bed[std::lround(model.point_position[p][1] / kHeight)] += model.area[p];
  }
  ASSERT_EQ(bed.size(), 4u);
  for (const auto& [course, area] : bed) EXPECT_NEAR(area, plan, 1e-9 * plan) << course;

  // At a corner one of the two joints is inside a unit; in the next course it is the other one.
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

// Returns stage 'push': the whiffletree acts on the floors of a building; all else is free.
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

// Returns the base shear at a roof displacement. It depends on the structure, not on the stiffness of the whiffletree.
double base_shear(double stiffness, bool rigid_beams) {
  Scene scene = small_building(4, rigid_beams);
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
  for (const bool rigid_beams : {true, false}) {
    const double soft = base_shear(2e7, rigid_beams), stiff = base_shear(2e8, rigid_beams);
    EXPECT_GT(soft, 1e7);
    EXPECT_NEAR(soft / stiff, 1.0, 0.03) << rigid_beams;
  }
}

// A whiffletree so stiff that it sets the time step is stable up to the critical step, as other springs are. With a
// force that is a step late, u(t + dt) - 2 u(t) + u(t - dt) = -(omega dt)^2 u(t - dt). That grows in each step by
// sqrt(1 + (omega dt)^2), for any dt.
TEST(Building, TheWhiffletreeIsASpringWithinTheTimeStep) {
  const auto kinetic_energy = [](double fraction, bool rigid_beams, LargeMotion motion) {
    Scene scene = small_building(4, rigid_beams);
    scene.solver.large_motion = motion;
    scene.solver.damping = DampingKind::none;
    scene.solver.time_step_fraction = fraction;
    scene.stages = {push_floors(*scene.building, 1e14, 1e-3)};
    const Assembly assembly = assemble(scene);
    Simulation simulation(scene, assembly);
    try {
      simulation.advance(500);
    } catch (const Error& e) {  // large motion: positions are not finite
      EXPECT_EQ(e.exit_code, Exit::numerical) << e.what();
      return std::numeric_limits<double>::infinity();
    }
    return std::abs(simulation.measure().kinetic_energy);  // m v(-1/2) v(+1/2) / 2: negative when v alternates
  };
  for (const bool rigid_beams : {true, false}) {
    for (const LargeMotion motion : {LargeMotion::automatic, LargeMotion::always}) {
      EXPECT_LT(kinetic_energy(0.98, rigid_beams, motion), 1.0) << rigid_beams;
      EXPECT_GT(kinetic_energy(1.02, rigid_beams, motion), 1e6) << rigid_beams;
    }
  }
}

// A force on a free deformable block is distributed by mass. The block accelerates by F/m without deformation, and the
// work is F^2 t^2/(2 m).
TEST(Building, ALoadOnADeformableBlockMovesIt) {
  for (const double deformation_inertia : {1.0, 64.0}) {
    Scene scene = bare_scene(0.6);
    scene.solver.deformation_inertia = deformation_inertia;
    scene.output.energy = true;
    Assembly assembly = brick_grid({2, 1, 1}, {kHalf, kHeight, kThickness}, {4, 2, 2});
    assembly.joints.clear();
    assembly.bricks[1].body = "loaded";
    Stage push;
    push.name = "push";
    BodyControl control;
    control.body = "loaded";
    control.kind = {DofKind::free, DofKind::free, DofKind::free};
    control.force = {300.0, -200.0, 100.0};
    push.controls = {control};
    push.duration = 1.0;
    scene.stages = {push};
    Simulation simulation(scene, assembly, 1);
    simulation.advance(200);
    const double mass = kDensity * kHalf * kHeight * kThickness, t = simulation.time();
    for (const Vec3& v : block_velocity(simulation, 1)) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[c], control.force[c] / mass * t, 1e-9 * 300.0 / mass * t);
    }
    for (const Vec3& v : block_velocity(simulation, 0)) EXPECT_EQ(v[0], 0.0);
    for (const auto& stress : block_stress(simulation, 1)) EXPECT_NEAR(stress[1], 0.0, 1e-3);
    const double squared = 300.0 * 300.0 + 200.0 * 200.0 + 100.0 * 100.0;
    const Energies energies = *simulation.measure().energies;
    // Energies are those at the time of the last forces, one step before, with velocities half a step before and after.
    const double then = t - simulation.time_step_report().time_step;
    EXPECT_NEAR(energies.external, 0.5 * squared * then * then / mass, 0.01 * energies.external);
    EXPECT_NEAR(energies.balance_error(), 0.0, 1e-9 * energies.external);

    control.kind[0] = DofKind::velocity;
    control.force = {};
    scene.stages[0].controls = {control};
    Simulation held(scene, assembly, 1);
    EXPECT_THROW(held.advance(1), Error);
  }
}

// The ground carries the weight of the walls and the loads of the floors.
TEST(Building, TheGroundCarriesWeightAndLoads) {
  for (const bool rigid_beams : {true, false}) {
    Scene scene = small_building(4, rigid_beams);
    scene.solver = quality_named("standard").solver;
    Stage weight;
    weight.name = "weight";
    weight.gravity = {0.0, -9.81, 0.0};
    weight.ramp_time = 0.005;
    weight.equilibrium_ratio = 1e-5;
    weight.max_steps = 100000;
    weight.monitor = "bottom_beam";
    BodyControl bottom;
    bottom.body = "bottom_beam";
    weight.controls = {bottom};
    for (const auto& floor : scene.building->floors) {
      for (const std::string& body : floor.bodies()) {
        BodyControl c;
        c.body = body;
        c.kind = {DofKind::free, DofKind::free, DofKind::free};
        c.force = {0.0, -floor.load / static_cast<double>(floor.half_units.size()), 0.0};
        c.may_turn = true;
        weight.controls.push_back(c);
      }
    }
    scene.stages = {weight};
    const Assembly assembly = assemble(scene);
    Simulation simulation(scene, assembly, 1);
    Last last;
    simulation.run(last);
    double masonry = 0.0;
    for (const Brick& b : assembly.bricks) {
      if (b.body != "bottom_beam") masonry += 1750.0 * b.size[0] * b.size[1] * b.size[2];
    }
    // At equilibrium the largest unbalanced force is 1e-5 of the mean contact force.
    EXPECT_NEAR(last.last.vertical_force, 9.81 * masonry + 2 * 10e3, 1e-4 * 9.81 * masonry) << rigid_beams;
  }
}

TEST(Building, ARunWithLoadedBlocksGoesOnBitForBit) {
  Scene scene = small_building(4, false);
  Stage push = push_floors(*scene.building, 1e8, 0.1);
  push.ramp_time = 1e-3;
  push.controls.back().force = {0.0, -5e3, 0.0};
  scene.stages = {push};
  const Assembly assembly = assemble(scene);
  Simulation whole(scene, assembly), first(scene, assembly), second(scene, assembly);
  whole.advance(300);
  first.advance(120);
  second.restore(first.save());
  second.advance(180);
  EXPECT_EQ(second.hash(), whole.hash());
  EXPECT_EQ(second.measure().dynamic_force, whole.measure().dynamic_force);
}

// Wall B with a window and its lintel, which ends at a corner: the corner is then a separate unit, and all faces
// conform.
// A wall with an odd number of half units owns both of its corners in the same courses. Units of these courses had
// three halves at its end.
TEST(Building, UnitsHaveTwoHalves) {
  Scene scene = small_building(4);
  scene.building->corners[1].first = 0, scene.building->corners[1].second = 2;
  std::map<int, int> halves;
  for (const Brick& brick : assemble(scene).bricks) ++halves[brick.unit];
  for (const auto& [unit, count] : halves) EXPECT_LE(count, 2) << unit;
  scene.building->walls[0].first_course = "half";
  EXPECT_THROW(assemble(scene), Error) << "a corner starts the wall";
}

// Walls that cross have blocks in each other, which the lattice took: the run ended by a segmentation fault.
TEST(Building, WallsThatOverlapAreRefused) {
  const auto refused = [](const Scene& scene, const std::string& reason) {
    try {
      assemble(scene);
      ADD_FAILURE() << "accepted: " << reason;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
    }
  };
  Scene scene = small_building(4);
  scene.building->walls.push_back({"T", 2, {kThickness + kHalf, 0.0}, 3, kHalf, "whole", {}, {}});
  refused(scene, "wall 'T' overlaps wall 'B' in plan");
  scene = small_building(4);
  scene.building->walls.push_back(scene.building->walls[1]);
  refused(scene, "wall 'A' overlaps wall 'A' in plan");
  scene = small_building(4);
  scene.building->corners.push_back(scene.building->corners[0]);
  refused(scene, "the corner at (0, 0) overlaps the corner at (0, 0) in plan");
}

// Walls that touch without a corner had no joint on the lattice, and passed through each other.
TEST(Building, WallsThatTouchHaveJoints) {
  Scene scene = small_building(4);
  scene.stages.emplace_back();
  ASSERT_FALSE(choose_motion(scene).shapes) << "on the lattice";
  scene.building->walls.push_back({"T", 2, {kThickness + kHalf, kThickness}, 2, kHalf, "whole", {}, {}});
  ASSERT_TRUE(choose_motion(scene).shapes);
  const Simulation run(scene);
  const blocks::Model& m = *run.large_motion();
  const auto in_t = [&](int block) {
    const geometry::Vector x = position_of(m, block);
    return x.z > kThickness && x.x > kThickness + kHalf && x.x < 2 * kThickness + kHalf && x.y > 0.0;
  };
  const auto in_b = [&](int block) { return position_of(m, block).z < kThickness && position_of(m, block).y > 0.0; };
  EXPECT_GE(std::ranges::count_if(m.contacts.list,
                                  [&](const blocks::Contact& c) {
                                    return c.count >= 4 &&
                                           ((in_t(c.pair.a) && in_b(c.pair.b)) || (in_t(c.pair.b) && in_b(c.pair.a)));
                                  }),
            4);
  scene.building->walls.back().start[1] += 1e-3;  // a gap
  ASSERT_FALSE(choose_motion(scene).shapes);
  scene.building->walls.back().start[1] -= 1e-3;
  scene.solver.large_motion = LargeMotion::never;
  EXPECT_THROW(choose_motion(scene), Error);
}

TEST(Building, LintelsMayEndAtCorners) {
  for (const int axis : {0, 2}) {
    Scene scene = small_building(5);
    auto& walls = scene.building->walls;
    (axis == 0 ? walls[0] : walls[1]).half_units = 5;
    walls[2].start[0] = scene.building->corners[1].at[0] = kThickness + walls[0].half_units * kHalf;
    (axis == 0 ? walls[0] : walls[1]).openings = {{1, 3, 1, 2, 1, ""}};
    scene.building->floors[1].course = 4;
    scene.building->floors[1].half_units = {1};
    const Assembly assembly = assemble(scene);
    const Model model(assembly, make_materials(assembly));
    int lintels = 0;
    for (const Brick& brick : assembly.bricks) {
      if (brick.rigid || brick.zones[static_cast<std::size_t>(axis)] != 20) continue;
      ++lintels;
      EXPECT_EQ(std::count_if(assembly.bricks.begin(), assembly.bricks.end(),
                              [&](const Brick& other) { return other.unit == brick.unit; }),
                1);
    }
    EXPECT_EQ(lintels, 1);
    double bed = 0.0, plan = 0.0;  // m2: joint area on top of the lintel; plan area of the course above
    for (std::int32_t i = 0; i < model.point_count; ++i) {
      const auto p = static_cast<std::size_t>(i);
      if (model.point_axis[p] == 1 && std::abs(model.point_position[p][1] - 4 * kHeight) < 1e-9) bed += model.area[p];
    }
    for (const Brick& brick : assembly.bricks) {
      if (brick.course == 4) plan += brick.size[0] * brick.size[2];
    }
    EXPECT_NEAR(bed, plan, 1e-9 * plan) << axis;
  }
}

// Under local damping (eq. 1) a body that drifts in one direction has uneven springs. Their stiffness is (1 - gamma) k
// where they accelerate it, (1 + gamma) k where they decelerate it. Near a period of four steps, from omega dt/2 =
// 1/sqrt(2) to 1/sqrt(2 (1 - gamma^2)), uneven springs transfer energy from drift to vibration. The vibration grows to
// the velocity of the drift and brakes it. Beams that are halves of units may vibrate so against the other halves,
// along the drift and without viscosity. Vibration after an impact would then not decay.
TEST(Building, BeamsThatDriftComeToRestAfterABlow) {
  Scene scene = small_building(12);
  scene.building->zones = {2, 2, 2};
  scene.building->walls = {{"B", 0, {0.0, 0.0}, 12, kHalf, "whole", {}, {}}};
  scene.building->corners.clear();
  scene.building->floors = {{"floor_1", 0, 8, {3, 5, 7, 9}, 0.0, 0.0, {}}};
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
      lattice_velocity(simulation)[dof(simulation.model(), block, n, 0)] += block % 2 == 0 ? 5e-3 : -5e-3;
  }
  simulation.advance(1000);
  double drift = 0.0, change = 0.0;  // velocity of the beams, m/s; its change in a step
  for (int step = 0; step < 12; ++step) {
    std::vector<double> before;
    for (int block = 0; block < count; ++block) before.push_back(block_velocity(simulation, block).front()[0]);
    simulation.advance(1);
    for (int block = 0; block < count; ++block) {
      const Brick& brick = assembly.bricks[static_cast<std::size_t>(block)];
      if (!brick.rigid || brick.body == "bottom_beam") continue;
      const double now = block_velocity(simulation, block).front()[0];
      change = std::max(change, std::abs(now - before[static_cast<std::size_t>(block)]));
      drift = std::max(drift, now);
    }
  }
  EXPECT_GT(drift, 1e-3);
  EXPECT_LT(change, 0.3 * drift);
}

// Returns the mean vertical force at the ground less the weight while the roof moves from 1 to 2 mm, N. The wall rises
// as it cracks, and damping that brakes it presses on the ground. Other forces have no mean: the inertia of 15 t that
// moves by micrometres in 0.05 s is some newtons.
double brake_on_the_door_wall(const std::vector<std::string>& overrides) {
  std::vector<std::string> settings{"output.frames=0", "stage.push.velocity=0.04", "stage.push.displacement=0.002"};
  settings.insert(settings.end(), overrides.begin(), overrides.end());
  Scene scene = read_scene(QUOIN_SCENES "/pavia_door.toml", settings);
  struct Mean : Observer {
    void on_row(const HistoryRow& row) override {
      if (row.stage == 0) weight = row.vertical_force;
      if (row.stage == 0 || row.displacement < 1e-3) return;
      sum += row.vertical_force;
      ++count;
    }
    double weight = 0.0, sum = 0.0;
    long count = 0;
  } mean;
  const Assembly assembly = assemble(scene);
  Simulation simulation(std::move(scene), assembly, 1);
  simulation.run(mean);
  return mean.sum / static_cast<double>(mean.count) - mean.weight;
}

// Two floors; the beam of the first lies on top of the wall and slides off it at the force of its bed, about 5 kN. The
// roof carries 100 kN, whose friction stops it at 0.2 mm of 1 mm. Without an end of its own the stage has no last step.
Scene building_with_a_loose_floor(const std::string& large_motion) {
  std::string text = read_input_file(QUOIN_HOST_TESTS "/small_building.toml");
  text.insert(text.find("[[building.floor]]"),
              "[[building.floor]]\nname = \"loose\"\nwall = \"B\"\ncourse = 7\nhalf_units = [3]\nload = 1e3\n");
  return read_scene_text(
      text, "loose.toml",
      {"solver.large_motion=" + large_motion, "building.floor.2.load=1e5", "joints.mortar.tensile_strength=1e3",
       "joints.mortar.cohesion=2e3", "stage.push.displacement=1e-3", "stage.push.velocity=0.05",
       "stage.push.max_steps=6000", "stage.push.record_interval=50"});
}

// u = mean of the floors + F/K: the end comes where u has gone 5 (displacement + largest F/K), within one step of it.
// large_motion = "automatic" goes over on the way.
TEST(Building, APushEndsWhereFloorsGoOnWithoutTheRoof) {
  for (const std::string motion : {"automatic", "always"}) {
    const Scene scene = building_with_a_loose_floor(motion);
    Simulation whole(scene), first(scene), second(scene);
    struct : Last {
      double begin = 0.0;
      void on_stage_begin(const Simulation& s, int) override { begin = s.time(); }
    } last;
    whole.run(last);
    EXPECT_TRUE(whole.large_motion());
    EXPECT_LT(last.last.displacement, 0.3e-3);
    const auto& warnings = whole.outcome().warnings;
    EXPECT_EQ(std::ranges::count(warnings, "push_lost", &Warning::about), 1);
    // Head at time t after a ramp of 5 ms: 0.05 m/s (t - 2.5 ms). Peak of F/K below 0.1 mm.
    const double head = 0.05 * (whole.time() - last.begin - 2.5e-3);
    EXPECT_GT(head, 5e-3);
    EXPECT_LT(head, 5.5e-3);

    Observer nobody;
    first.run_stage(nobody);
    first.run_stage(nobody, 1300);  // after the peak
    second.restore(first.save());
    second.run(nobody);
    EXPECT_EQ(second.step(), whole.step());
    EXPECT_EQ(second.hash(), whole.hash());

    long steps = 0;
    std::uint64_t hash = 0;
    on_ranks(2, [&](Ranks& ranks) {
      Simulation part(scene, 1, &ranks);
      Observer of_rank;
      part.run(of_rank);
      const std::uint64_t all = part.hash();
      if (ranks.rank() == 0) steps = part.step(), hash = all;
    });
    EXPECT_EQ(steps, whole.step());
    EXPECT_EQ(hash, whole.hash());
  }
}

// With a step of 0.87 of 2/omega_max uneven springs (benchmarks/ACCURACY.md) transfer the drift of a building to
// vibration, which brakes it by 19 kN here. The qualities therefore exclude motions with a period of four steps.
TEST(Building, DampingDoesNotBrakeTheDoorWall) {
  EXPECT_LT(std::abs(brake_on_the_door_wall({})), 1e3);
  EXPECT_GT(std::abs(brake_on_the_door_wall({"solver.time_step_fraction=0.92", "solver.deformation_damping=0.05"})),
            5e3);
}

}  // namespace
}  // namespace quoin
