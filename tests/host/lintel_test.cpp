// Lintels: long blocks in a wall of half units, through generator, model, step and time step.
#include <gtest/gtest.h>

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <map>

#include "scene/quality.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

constexpr Vec3 kHalfUnit{0.11, 0.0625, 0.1};

// Seven courses of nine half units; a door of five half units and four courses, its lintel on half a unit at each end.
Scene wall_with_a_door(double bearing = 0.11) {
  Scene scene = wall_scene(7, 4.5);
  scene.wall->openings = {{2, 5, 0, 4, static_cast<int>(std::lround(bearing / 0.11)), ""}};
  return scene;
}

double overlap(const Brick& a, const Brick& b, std::size_t c) {
  return std::min(a.origin[c] + a.size[c], b.origin[c] + b.size[c]) - std::max(a.origin[c], b.origin[c]);
}

TEST(Lintel, ContactAreasAreTheOverlapsOfBlocks) {
  for (const std::array<int, 3>& zones : {std::array{4, 2, 2}, std::array{3, 1, 2}, std::array{1, 1, 1}}) {
    Scene scene = wall_with_a_door();
    scene.wall->zones = zones;
    const Assembly assembly = assemble(scene);
    const Model model(assembly, make_materials(assembly));
    EXPECT_EQ(model.zone_count(), static_cast<std::size_t>(5 * zones[0] * zones[1] * zones[2] * (7 * 9 - 4 * 5)));
    std::vector<double> area(assembly.joints.size(), 0.0);
    for (std::int32_t p = 0; p < model.point_count; ++p)
      area[static_cast<std::size_t>(model.point_joint[static_cast<std::size_t>(p)])] +=
          model.area[static_cast<std::size_t>(p)];
    for (std::size_t j = 0; j < area.size(); ++j) {
      const Joint& joint = assembly.joints[j];
      const Brick &a = assembly.bricks[static_cast<std::size_t>(joint.block_a)],
                  &b = assembly.bricks[static_cast<std::size_t>(joint.block_b)];
      const auto n = static_cast<std::size_t>(joint.face_a / 2);
      EXPECT_NEAR(area[j], overlap(a, b, (n + 1) % 3) * overlap(a, b, (n + 2) % 3), 1e-15) << j;
    }
  }
}

// The door's wall has 9 x 3 + 4 x 4 - 7 half units and a lintel of 29 x 3 x 3 gridpoints. Beds: under the bottom course
// 4 half units, ... , 9 at the top; each half unit 15 points. Heads: 9 points each.
TEST(Lintel, CountsOfPoints) {
  const Assembly assembly = assemble(wall_with_a_door());
  const Model model(assembly, make_materials(assembly));
  EXPECT_EQ(assembly.bricks.size(), 4u * 4 + 3 * 9 - 6 + 2);
  const int beds = 4 * 4 /* to course 3 */ + 4 /* under the lintel's course */ + 9 * 3;
  const int heads = 4 * 2 /* beside the door */ + 2 /* of the lintel */ + 2 * 8;
  EXPECT_EQ(model.point_count, 15 * beds + 9 * heads);
}

// Under a uniform vertical pressure a lintel of the units' material has the strain of the half units. The joints close
// by pressure over stiffness. No gridpoint of the lintel has an unbalanced force.
TEST(Lintel, PatchTestAcrossALintel) {
  for (const std::array<int, 3>& zones : {std::array{4, 2, 2}, std::array{3, 1, 1}}) {
    Assembly assembly;
    assembly.materials = {brick_material()};
    assembly.families = {elastic_family()};
    const auto add = [&](int first, int count, int course) {
      Brick b;
      b.origin = {first * kHalfUnit[0], course * kHalfUnit[1], 0.0};
      b.size = {count * kHalfUnit[0], kHalfUnit[1], kHalfUnit[2]};
      b.zones = {count * zones[0], zones[1], zones[2]};
      b.parity = (first * zones[0] + course * zones[1]) % 2;
      b.course = course;
      assembly.bricks.push_back(b);
    };
    for (int i = 0; i < 9; ++i) add(i, 1, 0);
    add(0, 1, 1);
    add(1, 7, 1);
    add(8, 1, 1);
    for (int i = 0; i < 9; ++i) add(i, 1, 2);
    const int lintel = 10, count = static_cast<int>(assembly.bricks.size());
    for (int a = 0; a < count; ++a) {
      for (int b = 0; b < count; ++b) {
        const Brick &p = assembly.bricks[static_cast<std::size_t>(a)],
                    &q = assembly.bricks[static_cast<std::size_t>(b)];
        if (p.course == q.course && std::abs(p.origin[0] + p.size[0] - q.origin[0]) < 1e-9)
          assembly.joints.push_back({a, b, 1, 0});
        if (p.course + 1 == q.course && overlap(p, q, 0) > 1e-9) assembly.joints.push_back({a, b, 3, 0});
      }
    }
    Simulation simulation(bare_scene(), assembly, 1);
    const Model& model = simulation.model();
    const double dt = simulation.time_step_report().time_step, pressure = 1e6;
    const double along = -pressure / kYoung, across = kPoisson * pressure / kYoung, closing = -pressure / kNormal;
    for (int block = 0; block < count; ++block) {
      const auto mesh = block_mesh(simulation, block);
      for (int n = 0; n < static_cast<int>(mesh.gridpoint.size()); ++n) {
        const Vec3& x = mesh.gridpoint[static_cast<std::size_t>(n)];
        const Vec3 u{across * x[0], along * x[1] + closing * assembly.bricks[static_cast<std::size_t>(block)].course,
                     across * x[2]};
        for (int c = 0; c < 3; ++c) {
          lattice_displacement(simulation)[dof(model, block, n, c)] = u[static_cast<std::size_t>(c)];
          lattice_velocity(simulation)[dof(model, block, n, c)] =
              u[static_cast<std::size_t>(c)] / dt;  // gives displacement u in one step
        }
      }
    }
    const LaneVector<double> before = lattice_velocity(simulation);
    simulation.advance(1);
    const double scale =
        pressure * kHalfUnit[0] * kHalfUnit[2] / (zones[0] * zones[2]);  // force of a hexahedron's face
    double mass = 0.0;
    model.for_each_gridpoint(lintel, [&](std::size_t i, double m) {
      mass += m;
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_LT(std::abs(lattice_velocity(simulation)[i + c * kLanes] - before[i + c * kLanes]) * m / dt,
                  1e-9 * scale);
    });
    EXPECT_NEAR(mass, kDensity * 7 * kHalfUnit[0] * kHalfUnit[1] * kHalfUnit[2], 1e-9 * mass);
    for (const ContactPoint& point : contact_points(simulation)) {
      EXPECT_NEAR(point.traction[0], point.normal[1] == 1.0 ? -pressure : 0.0, 1e-8 * pressure);
      EXPECT_NEAR(std::hypot(point.traction[1], point.traction[2]), 0.0, 1e-8 * pressure);
    }
  }
}

// Moments of inertia of a lintel from the masses of its gridpoints exceed those of the box. Half of the mass of a layer
// is at each of its ends, which gives (1 + 2/n^2) of the box along an edge of n hexahedra.
TEST(Lintel, MassAndMomentsOfInertia) {
  Brick lintel;
  lintel.size = {1.4, 0.16, 0.25};
  lintel.zones = {28, 2, 2};
  const BlockMaterial material{"masonry", 2.4e9, 0.2, 1750.0};
  const BrickTemplate shape = make_brick_template(lintel, material);
  EXPECT_EQ(shape.node_count, 261);
  EXPECT_EQ(shape.zone.size(), 560u);
  double mass = 0.0;
  Vec3 square{};
  for (std::size_t n = 0; n < shape.node.size(); ++n) {
    mass += shape.node_mass[n];
    for (std::size_t c = 0; c < 3; ++c)
      square[c] += shape.node_mass[n] * std::pow(shape.node[n][c] - lintel.size[c] / 2, 2);
  }
  EXPECT_NEAR(mass, 1750.0 * 1.4 * 0.16 * 0.25, 1e-9 * mass);
  for (std::size_t c = 0; c < 3; ++c) {
    const double box = mass * lintel.size[c] * lintel.size[c] / 12.0, n = lintel.zones[c];
    EXPECT_GT(square[c], box * (1.0 - 1e-12));
    EXPECT_LT(square[c], box * (1.0 + 2.0 / (n * n) + 1e-12)) << c;
  }
}

// Returns the end stiffness of a cantilever, whose deflection is P L^3/(3 E I) + 6 P L/(5 G A). Tetrahedra of constant
// strain are too stiff. The error falls like h^2; refinement 1 is a lintel of two hexahedra over its height.
double cantilever_stiffness(int refinement, const BlockMaterial& material, const Vec3& size) {
  Brick beam;
  beam.size = size;
  beam.zones = {28 * refinement, 2 * refinement, 2 * refinement};
  const BrickTemplate shape = make_brick_template(beam, material);
  std::vector<int> free_dof(static_cast<std::size_t>(3 * shape.node_count), -1);
  int count = 0;
  for (int n = 0; n < shape.node_count; ++n) {
    const double x = shape.node[static_cast<std::size_t>(n)][0];
    for (int c = 0; c < 3; ++c) {
      if (x > 0.0) free_dof[static_cast<std::size_t>(3 * n + c)] = count++;
    }
  }
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd load = Eigen::VectorXd::Zero(count);
  double end_mass = 0.0;
  for (int n = 0; n < shape.node_count; ++n) {
    const bool at_end = shape.node[static_cast<std::size_t>(n)][0] > size[0] * (1.0 - 1e-9);
    if (at_end) end_mass += shape.node_mass[static_cast<std::size_t>(n)];
    for (int c = 0; c < 3; ++c) {
      const int i = free_dof[static_cast<std::size_t>(3 * n + c)];
      if (i < 0) continue;
      if (at_end && c == 1) load[i] = shape.node_mass[static_cast<std::size_t>(n)];
      for (const auto& [column, k] : shape.stiffness.row(3 * n + c)) {
        const int j = free_dof[static_cast<std::size_t>(column)];
        if (j >= 0) entries.emplace_back(i, j, k);
      }
    }
  }
  load /= end_mass;  // 1 N
  Eigen::SparseMatrix<double> k(count, count);
  k.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(k);
  return 1.0 / load.dot(solver.solve(load));
}

TEST(Lintel, BendsLikeABeamWhenItsMeshIsRefined) {
  const BlockMaterial material{"masonry", 2.4e9, 0.0,
                               1750.0};  // Poisson's ratio 0: the clamp does not restrain lateral strain
  const Vec3 size{1.4, 0.16, 0.25};
  const double inertia = size[2] * std::pow(size[1], 3) / 12.0, area = size[1] * size[2];
  const double e = material.young_modulus, g = e / 2.0;
  const double beam = 1.0 / (std::pow(size[0], 3) / (3 * e * inertia) + 6.0 * size[0] / (5.0 * g * area));
  const double coarse = cantilever_stiffness(1, material, size) / beam - 1.0;
  const double fine = cantilever_stiffness(2, material, size) / beam - 1.0;
  RecordProperty("coarse", std::to_string(coarse));
  RecordProperty("fine", std::to_string(fine));
  EXPECT_GT(coarse, 0.0);
  EXPECT_GT(fine, 0.0);
  EXPECT_NEAR(coarse / fine, 4.0, 0.8);  // h^2
  // Error without its part of order h^2.
  EXPECT_NEAR((4.0 * fine - coarse) / 3.0, 0.0, 0.05);
}

// With true and with added inertia. One lintel between half units: some lanes of its SIMD group are empty.
TEST(Lintel, StableJustBelowTheLimitUnstableJustAbove) {
  for (const double deformation_inertia : {1.0, 64.0}) {
    const auto largest = [&](double fraction) {
      Scene scene = bare_scene(fraction);
      scene.solver.deformation_inertia = deformation_inertia;
      scene.solver.unit_inertia = deformation_inertia / 4.0 > 1.0 ? 16.0 : 1.0;
      Scene wall = wall_with_a_door();
      wall.joints["mortar"] = elastic_family();
      wall.joints["mortar"].name = "mortar";
      return largest_after(scene, assemble(wall), 3000);
    };
    EXPECT_LT(largest(0.98), 1e-3) << deformation_inertia;
    EXPECT_GT(largest(1.02), 1e3) << deformation_inertia;
  }
}

TEST(Lintel, ForcesByZoneAreThoseOfTheAssembledStiffness) {
  LaneVector<double> displacement[2];
  for (const InternalForces way : {InternalForces::assembled, InternalForces::zones}) {
    Scene wall = wall_with_a_door();
    wall.joints["mortar"] = elastic_family();
    wall.joints["mortar"].name = "mortar";
    Scene scene = bare_scene(0.5);
    scene.solver.internal_forces = way;
    Simulation simulation(scene, assemble(wall), 1);
    random_velocities(&simulation, 3);
    simulation.advance(100);
    displacement[way == InternalForces::zones] = lattice_displacement(simulation);
  }
  double largest = 0.0, difference = 0.0;
  for (std::size_t i = 0; i < displacement[0].size(); ++i) {
    largest = std::max(largest, std::abs(displacement[0][i]));
    difference = std::max(difference, std::abs(displacement[0][i] - displacement[1][i]));
  }
  EXPECT_GT(difference, 0.0);
  EXPECT_LT(difference, 1e-12 * largest);  // rounding of 100 steps
}

struct Last : Observer {
  void on_row(const HistoryRow& row) override { last = row; }
  HistoryRow last;
};

// Returns the settlement of the half unit above the middle of a door after some time under its weight, m. Joints are
// dry and without friction: without a lintel the units above the door fall.
double sinking(double bearing) {
  Scene scene = wall_with_a_door(bearing);
  JointFamily dry = elastic_family(20e9, 8e9);
  dry.name = "mortar";
  dry.law = "coulomb_slip";
  for (const auto& [id, value] :
       std::map<std::string, double>{{"tensile_strength", 0.0}, {"cohesion", 0.0}, {"friction_angle", 0.0}})
    dry.properties.push_back({id, {value}, "", {}});
  scene.joints["mortar"] = dry;
  scene.solver = quality_named("standard").solver;
  scene.wall->top_beam = false;
  Stage stand;
  stand.name = "stand";
  stand.gravity = {0.0, -9.81, 0.0};
  stand.ramp_time = 0.02;
  stand.duration = 0.1;
  BodyControl bottom;
  bottom.body = "bottom_beam";
  stand.controls = {bottom};
  scene.stages = {stand};
  const Assembly assembly = assemble(scene);
  Simulation simulation(scene, assembly, 1);
  Last last;
  simulation.run(last);
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) {
    const Brick& b = assembly.bricks[i];
    if (b.course == 5 && std::abs(b.origin[0] - 4 * 0.11) < 1e-9)
      return -block_displacement(simulation, static_cast<int>(i)).front()[1];
  }
  return NAN;
}

TEST(Lintel, BearsWhatLiesAboveTheOpening) {
  EXPECT_GT(sinking(0.0), 10e-3);  // g t^2/2 of 0.08 s is 31 mm
  EXPECT_LT(sinking(0.11), 0.05e-3);
}

}  // namespace
}  // namespace quoin
