#include <gtest/gtest.h>

#include <cmath>

#include "step/kernels.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

// A uniform stress over a grid of blocks. Every block has the same strain, and each joint opens and slides by its
// traction over its stiffness. The middle block has no unbalanced force.
TEST(PatchTest, UniformStressIsReproduced) {
  const double cases[][6] = {{0, -1e6, 0, 0, 0, 0}, {0, 0, 0, 1e6, 0, 0}, {3e5, -1e6, 2e5, 4e5, -3e5, 7e5}};
  for (const auto& zones : {std::array{4, 2, 2}, std::array{3, 2, 1}}) {
    for (const auto& [xx, yy, zz, xy, yz, zx] : cases) {
      const Eigen::Matrix3d stress{{xx, xy, zx}, {xy, yy, yz}, {zx, yz, zz}};
      const Eigen::Matrix3d strain =
          (1 + kPoisson) / kYoung * stress - kPoisson / kYoung * stress.trace() * Eigen::Matrix3d::Identity();
      Eigen::Matrix3d jump;  // column a: jump over a joint with normal a
      for (int a = 0; a < 3; ++a) {
        for (int c = 0; c < 3; ++c) jump(c, a) = stress(c, a) / (c == a ? kNormal : kShear);
      }
      Simulation simulation(bare_scene(), brick_grid({3, 3, 3}, {0.11, 0.0625, 0.1}, zones), 1);
      const Model& model = simulation.model();
      const double dt = simulation.time_step_report().time_step;
      for (int block = 0; block < 27; ++block) {
        const Eigen::Vector3d offset = jump * Eigen::Vector3d(block % 3, block / 3 % 3, block / 9);
        const auto mesh = block_mesh(simulation, block);
        for (int n = 0; n < static_cast<int>(mesh.gridpoint.size()); ++n) {
          const Vec3& x = mesh.gridpoint[static_cast<std::size_t>(n)];
          const Eigen::Vector3d u = strain * Eigen::Vector3d(x[0], x[1], x[2]) + offset;
          for (int c = 0; c < 3; ++c) {
            lattice_displacement(simulation)[dof(model, block, n, c)] = u[c];
            lattice_velocity(simulation)[dof(model, block, n, c)] = u[c] / dt;  // gives displacement u in one step
          }
        }
      }
      const LaneVector<double> before = lattice_velocity(simulation);
      simulation.advance(1);

      const double scale = stress.norm() * 0.11 * 0.1 / (zones[0] * zones[2]);  // force of a hexahedron's face
      for (int n = 0; n < model.templates[0].node_count; ++n) {
        for (int c = 0; c < 3; ++c) {
          const std::size_t i = dof(model, 13, n, c);  // the middle block
          EXPECT_LT(std::abs(lattice_velocity(simulation)[i] - before[i]) * model.node_mass[i] / dt, 1e-9 * scale);
        }
      }
      for (const ContactPoint& point : contact_points(simulation)) {
        const Eigen::Vector3d n(point.normal.data()), s(point.s.data()), t(point.t.data());
        EXPECT_NEAR(point.traction[0], n.dot(stress * n), 1e-9 * stress.norm());
        EXPECT_NEAR(point.traction[1], s.dot(stress * n), 1e-9 * stress.norm());
        EXPECT_NEAR(point.traction[2], t.dot(stress * n), 1e-9 * stress.norm());
      }
    }
  }
}

// The product with the stiffness matrix that benchmarks measure, for single blocks and for units of two halves.
TEST(Step, InternalForceIsTheStiffnessTimesTheDisplacement) {
  for (const bool units : {false, true}) {
    Assembly assembly = brick_grid({4, 1, 1}, {0.11, 0.0625, 0.1}, {4, 2, 2});
    if (units) assembly = in_units(std::move(assembly));
    Simulation simulation(bare_scene(), assembly, 1);
    random_velocities(&simulation, 5);
    lattice_displacement(simulation) = lattice_velocity(simulation);
    const Model& model = simulation.model();
    const std::vector<const double*> none(model.groups.size(), nullptr);
    StepData data;
    data.displacement = data.velocity = lattice_displacement(simulation).data();
    data.dt_over_mass = data.displacement;
    data.shared_dt_over_mass = data.load = none.data();
    const Eigen::MatrixXd k = dense_stiffness(assembly.bricks[0], brick_material());
    const int nodes = model.templates[0].node_count;
    LaneVector<double> force(static_cast<std::size_t>(kUnitBlocks * nodes) * kLine);
    for (const UnitGroup& unit : model.unit_groups) {
      EXPECT_EQ(unit.group_count, units ? 2 : 1);
      internal_force(model, unit, data, force.data());
      for (int b = 0; b < unit.group_count; ++b) {
        const BlockGroup& group = model.groups[static_cast<std::size_t>(unit.first_group + b)];
        for (int lane = 0; lane < group.block_count; ++lane) {
          const int block = group.block[static_cast<std::size_t>(lane)];
          Eigen::VectorXd u(3 * nodes), f(3 * nodes);
          for (int i = 0; i < 3 * nodes; ++i) {
            u[i] = lattice_displacement(simulation)[dof(model, block, i / 3, i % 3)];
            f[i] = force[static_cast<std::size_t>((b * nodes + i / 3) * kLine + i % 3 * kLanes + lane)];
          }
          const Eigen::VectorXd expected = k * u;
          EXPECT_LT((f - expected).norm(), 1e-12 * expected.norm()) << block;
        }
      }
    }
  }
}

// A mode of a free block vibrates with the frequency of central differences: cos(omega_d dt) = 1 - (omega dt)^2/2.
TEST(Step, FreeBlockSwingsWithItsOwnFrequency) {
  Simulation simulation(bare_scene(), brick_grid({1, 1, 1}, {0.11, 0.0625, 0.1}, {4, 2, 2}), 1);
  const Model& model = simulation.model();
  const Eigen::MatrixXd k = dense_stiffness(model.assembly.bricks[0], brick_material());
  const Eigen::VectorXd mass = dense_mass(model.assembly.bricks[0], brick_material());
  const Eigen::MatrixXd m = mass.asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(k, m);
  for (int mode : {6, 10, 50}) {  // the first 6 are rigid
    const Eigen::VectorXd shape = 1e-4 * solver.eigenvectors().col(mode);
    for (int i = 0; i < shape.size(); ++i) {
      lattice_displacement(simulation)[dof(model, 0, i / 3, i % 3)] = shape[i];
      lattice_velocity(simulation)[dof(model, 0, i / 3, i % 3)] = 0.0;
    }
    const double dt = simulation.time_step_report().time_step;
    const double angle = std::acos(1.0 - 0.5 * solver.eigenvalues()[mode] * dt * dt);
    constexpr int kSteps = 1000;
    simulation.advance(kSteps);
    double amplitude = 0.0;
    for (int i = 0; i < shape.size(); ++i)
      amplitude += shape[i] * mass[i] * lattice_displacement(simulation)[dof(model, 0, i / 3, i % 3)];
    amplitude /= shape.dot(m * shape);
    // Velocity 0 half a step before the start.
    EXPECT_NEAR(amplitude, std::cos(angle * (kSteps + 0.5)) / std::cos(0.5 * angle), 1e-8) << mode;
  }
}

// The energy balance includes the work of every kind of damping.
TEST(Step, EnergyBalanceClosesWithDamping) {
  for (DampingKind damping : {DampingKind::local, DampingKind::viscous}) {
    Scene scene = bare_scene(0.5, damping);
    scene.output.energy = true;
    scene.solver.mass_damping = 500.0;
    scene.solver.stiffness_damping = 2e-7;
    Simulation simulation(scene, brick_grid({2, 2, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1}), 1);
    random_velocities(&simulation, 3);
    simulation.advance(1);
    const double start = simulation.measure().energies->balance_error();
    simulation.advance(3000);
    const Energies end = *simulation.measure().energies;
    EXPECT_GT(end.damping, 0.05 * start);
    EXPECT_NEAR(end.balance_error(), start, 1e-9 * start);
  }
}

// Inertia that is raised for the time step differs between gridpoints and between blocks.
TEST(Step, EnergyBalanceClosesWithInertiaRaisedForTheStep) {
  Scene scene = bare_scene(0.5);
  scene.output.energy = true;
  const Assembly assembly = brick_grid({3, 2, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1});
  scene.solver.selective_time_step = 1.2 * Simulation(scene, assembly, 1).time_step_report().time_step;
  Simulation simulation(scene, assembly, 1);
  ASSERT_GT(simulation.time_step_report().added_mass, 0.0);
  random_velocities(&simulation, 3);
  simulation.advance(1);
  const double start = simulation.measure().energies->balance_error();
  simulation.advance(1000);
  EXPECT_GT(start, 0.0);
  EXPECT_NEAR(simulation.measure().energies->balance_error(), start, 1e-9 * start);
}

// Under mass-proportional damping only, a rigid motion decays like (1 - alpha dt)^n.
TEST(Step, ViscousDampingSlowsAFreeBlock) {
  Scene scene = bare_scene(0.6, DampingKind::viscous);
  scene.solver.mass_damping = 1000.0;
  Simulation simulation(scene, brick_grid({1, 1, 1}, {0.1, 0.1, 0.1}, {1, 1, 1}), 1);
  for (int n = 0; n < 8; ++n) lattice_velocity(simulation)[dof(simulation.model(), 0, n, 1)] = 0.3;
  simulation.advance(500);
  const double factor = 1.0 - 1000.0 * simulation.time_step_report().time_step;
  EXPECT_NEAR(lattice_velocity(simulation)[dof(simulation.model(), 0, 3, 1)], 0.3 * std::pow(factor, 500), 1e-12);
}

TEST(Step, FreeFall) {
  for (bool rigid : {false, true}) {
    Scene scene = bare_scene();
    scene.solver.mass_scaling = 1.0;
    scene.solver.selective_time_step = 1e-6;
    Stage stage;
    stage.gravity = {0.0, -9.81, 0.0};
    stage.duration = 1.0;
    scene.stages = {stage};
    Assembly assembly = brick_grid({1, 1, 1}, {0.1, 0.1, 0.1}, {1, 1, 1});
    assembly.bricks[0].rigid = rigid;
    Simulation simulation(scene, assembly, 1);
    simulation.advance(1000);
    const double t = simulation.time();
    for (const Vec3& v : block_velocity(simulation, 0)) EXPECT_NEAR(v[1], -9.81 * t, 1e-12 * 9.81);
  }
}

// A rotating rigid block without forces keeps its rotation; on elastic joints it vibrates without loss of energy.
TEST(Step, RigidBlocksKeepTheirEnergy) {
  Scene scene = bare_scene(0.8);
  scene.output.energy = true;
  Stage stage;
  stage.duration = 1e9;
  BodyControl base;
  base.body = "base";
  stage.controls = {base};
  stage.gravity = {0.0, -9.81, 0.0};
  scene.stages = {stage};
  Assembly assembly = brick_grid({1, 3, 1}, {0.2, 0.1, 0.3}, {1, 1, 1});
  for (Brick& brick : assembly.bricks) brick.rigid = true;
  assembly.bricks[0].body = "base";
  Simulation simulation(scene, assembly, 1);
  simulation.advance(20000);
  const Energies e = *simulation.measure().energies;
  EXPECT_GT(e.kinetic + e.contact_stored, 0.0);
  EXPECT_NEAR(e.balance_error(), 0.0, 1e-9 * e.contact_stored);
}

}  // namespace
}  // namespace quoin
