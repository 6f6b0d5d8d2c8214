// Added inertia against deformation of a block, and against relative motion of the halves of a unit, without change of
// rigid motions. Damping by block, and forces by zone.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

constexpr Vec3 kBrick{0.11, 0.0625, 0.1};

Scene scaled_scene(double deformation_inertia, DampingKind damping = DampingKind::none, double fraction = 0.6) {
  Scene scene = bare_scene(fraction, damping);
  scene.solver.deformation_inertia = deformation_inertia;
  return scene;
}

Scene scaled_units(double deformation_inertia, double unit_inertia, DampingKind damping, double fraction) {
  Scene scene = scaled_scene(deformation_inertia, damping, fraction);
  scene.solver.unit_inertia = unit_inertia;
  return scene;
}

// Added inertia by linear algebra only, with R the null space of K, the rigid motions:
//   M' = s M - (s - 1) M R (R^T M R)^-1 R^T M.
TEST(Deformation, CriticalStepAgreesWithAnIndependentMassMatrix) {
  for (const std::array<int, 3> zones : {std::array{4, 2, 2}, std::array{2, 1, 1}}) {
    const Assembly assembly = brick_grid({1, 1, 1}, kBrick, zones);
    const Model model(assembly, make_materials(assembly));
    const Eigen::MatrixXd k = dense_stiffness(assembly.bricks[0], brick_material());
    const Eigen::MatrixXd m = dense_mass(assembly.bricks[0], brick_material()).asDiagonal();
    const Eigen::MatrixXd r = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvectors().leftCols(6);
    for (const double s : {1.0, 3.0, 50.0}) {
      SolverSettings settings;
      settings.deformation_inertia = s;
      Inertia inertia;
      const TimeStepReport report = choose_time_step(model, settings, &inertia);
      const Eigen::MatrixXd mr = m * r;
      const Eigen::MatrixXd scaled = s * m - (s - 1.0) * mr * (r.transpose() * mr).inverse() * mr.transpose();
      const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(k, scaled, Eigen::EigenvaluesOnly);
      EXPECT_NEAR(report.critical.value, 2.0 / std::sqrt(modes.eigenvalues().maxCoeff()), 1e-7 * report.critical.value);
    }
  }
}

// For units M' = M (P_u + s_u (P_b - P_u) + s_b (1 - P_b)). Rigid motions of blocks are the null space of their
// stiffness; rigid motions of units are that of the stiffness of blocks and joint. With and without a plane of
// symmetry.
TEST(Deformation, CriticalStepOfUnitsAgreesWithAnIndependentMassMatrix) {
  for (const bool symmetric : {false, true}) {
    Assembly assembly = in_units(brick_grid({2, 1, 1}, kBrick, {2, 2, 1}));
    assembly.symmetry_plane_z0 = symmetric;
    const Model model(assembly, make_materials(assembly));
    const int nodes = model.templates[0].node_count;
    std::vector<std::size_t> free;
    for (int i = 0; i < 2 * 3 * nodes; ++i) {
      const std::size_t at = dof(model, i / (3 * nodes), i % (3 * nodes) / 3, i % 3);
      if (model.node_free[at] != 0.0) free.push_back(at);
    }
    const auto n = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd k(n, n), m = Eigen::MatrixXd::Zero(n, n), k_blocks = Eigen::MatrixXd::Zero(n, n);
    const Eigen::MatrixXd block = dense_stiffness(assembly.bricks[0], brick_material());
    const Eigen::VectorXd mass = dense_mass(assembly.bricks[0], brick_material());
    const auto place = [&](std::size_t offset) {  // returns block, and degree of freedom in the block
      for (int i = 0; i < 2 * 3 * nodes; ++i) {
        if (dof(model, i / (3 * nodes), i % (3 * nodes) / 3, i % 3) == offset)
          return std::pair(i / (3 * nodes), i % (3 * nodes));
      }
      return std::pair(-1, -1);
    };
    std::vector<double> u(static_cast<std::size_t>(model.line_count) * kLine, 0.0), f;
    for (Eigen::Index j = 0; j < n; ++j) {
      u[free[static_cast<std::size_t>(j)]] = 1.0;
      apply_undamaged_stiffness(model, u, &f);
      u[free[static_cast<std::size_t>(j)]] = 0.0;
      const auto [block_j, dof_j] = place(free[static_cast<std::size_t>(j)]);
      m(j, j) = mass[dof_j];
      for (Eigen::Index i = 0; i < n; ++i) {
        k(i, j) = f[free[static_cast<std::size_t>(i)]];
        const auto [block_i, dof_i] = place(free[static_cast<std::size_t>(i)]);
        if (block_i == block_j) k_blocks(i, j) = block(dof_i, dof_j);
      }
    }
    const auto projection = [&](const Eigen::MatrixXd& stiffness, Eigen::Index rigid) -> Eigen::MatrixXd {
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness);
      EXPECT_LT(solver.eigenvalues()[rigid - 1], 1e-9 * solver.eigenvalues()[n - 1]);
      EXPECT_GT(solver.eigenvalues()[rigid], 1e-6 * solver.eigenvalues()[n - 1]);
      const Eigen::MatrixXd r = solver.eigenvectors().leftCols(rigid);
      return r * (r.transpose() * m * r).inverse() * r.transpose() * m;
    };
    const Eigen::MatrixXd of_blocks = projection(k_blocks, symmetric ? 6 : 12);
    const Eigen::MatrixXd of_unit = projection(k, symmetric ? 3 : 6);
    for (const auto& [s_b, s_u] : {std::pair{1.0, 9.0}, std::pair{64.0, 16.0}, std::pair{50.0, 1.0}}) {
      SolverSettings settings;
      settings.deformation_inertia = s_b;
      settings.unit_inertia = s_u;
      Inertia inertia;
      const TimeStepReport report = choose_time_step(model, settings, &inertia);
      const Eigen::MatrixXd scaled =
          m * (of_unit + s_u * (of_blocks - of_unit) + s_b * (Eigen::MatrixXd::Identity(n, n) - of_blocks));
      const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(k, 0.5 * (scaled + scaled.transpose()),
                                                                            Eigen::EigenvaluesOnly);
      EXPECT_NEAR(report.critical.value, 2.0 / std::sqrt(modes.eigenvalues().maxCoeff()), 1e-7 * report.critical.value);
    }
  }
}

TEST(Deformation, StableJustBelowTheLimitUnstableJustAbove) {
  const Assembly assembly = brick_grid({2, 2, 1}, kBrick, {4, 2, 2});
  EXPECT_LT(largest_after(scaled_scene(16.0, DampingKind::none, 0.98), assembly, 3000), 1e-3);
  EXPECT_GT(largest_after(scaled_scene(16.0, DampingKind::none, 1.02), assembly, 3000), 1e3);
  const Assembly units = in_units(assembly);
  EXPECT_LT(largest_after(scaled_units(16.0, 5.0, DampingKind::none, 0.98), units, 3000), 1e-3);
  EXPECT_GT(largest_after(scaled_units(16.0, 5.0, DampingKind::none, 1.02), units, 3000), 1e3);
}

// Rigid motion of blocks and units has the true inertia for all factors: they fall and rotate as rigid bodies.
TEST(Deformation, RigidMotionKeepsItsInertia) {
  for (const int halves : {1, 2}) {
    const DampingKind damping = halves == 1 ? DampingKind::none : DampingKind::block;
    Scene scene = scaled_units(100.0, 30.0, damping, 0.6);
    Stage stage;
    stage.gravity = {1.0, -9.81, 0.5};
    stage.duration = 1.0;
    scene.stages = {stage};
    scene.solver.local_damping = 0.0;
    Simulation simulation(scene, in_units(brick_grid({halves, 1, 1}, kBrick, {4, 2, 2})), 1);
    // Slow rotation about z: u = omega x r.
    const Model& model = simulation.model();
    for (int b = 0; b < halves; ++b) {
      const auto mesh = block_mesh(simulation, b);
      for (int n = 0; n < model.templates[0].node_count; ++n) {
        const Vec3& x = mesh.gridpoint[static_cast<std::size_t>(n)];
        lattice_velocity(simulation)[dof(model, b, n, 0)] = -1e-3 * x[1];
        lattice_velocity(simulation)[dof(model, b, n, 1)] = 1e-3 * x[0];
      }
    }
    simulation.advance(1000);
    const double t = simulation.time();
    for (int b = 0; b < halves; ++b) {
      const auto mesh = block_mesh(simulation, b);
      const auto velocity = block_velocity(simulation, b);
      for (std::size_t n = 0; n < velocity.size(); ++n) {
        EXPECT_NEAR(velocity[n][0], 1.0 * t - 1e-3 * mesh.gridpoint[n][1], 1e-11);
        EXPECT_NEAR(velocity[n][1], -9.81 * t + 1e-3 * mesh.gridpoint[n][0], 1e-11);
        EXPECT_NEAR(velocity[n][2], 0.5 * t, 1e-11);
      }
    }
  }
}

// The energy balance includes added inertia M' and the work of every kind of damping.
TEST(Deformation, EnergyBalanceCloses) {
  for (const DampingKind damping : {DampingKind::none, DampingKind::viscous, DampingKind::block}) {
    for (const bool units : {false, true}) {
      Scene scene = scaled_units(16.0, units ? 5.0 : 1.0, damping, 0.5);
      scene.output.energy = true;
      scene.solver.mass_damping = 500.0;
      scene.solver.stiffness_damping = 2e-7;
      const Assembly blocks = brick_grid({2, 2, 1}, kBrick, {2, 1, 1});
      Simulation simulation(scene, units ? in_units(blocks) : blocks, 1);
      random_velocities(&simulation, 11, 1e-3);
      simulation.advance(1);
      const double start = simulation.measure().energies->balance_error();
      simulation.advance(3000);
      const Energies end = *simulation.measure().energies;
      EXPECT_NEAR(end.balance_error(), start, damping == DampingKind::none ? 1e-7 * start : 1e-9 * start);
      if (damping != DampingKind::none) {
        EXPECT_GT(end.damping, 0.05 * start);
      }
    }
  }
}

// Under local damping the vibration of a block brakes its rigid motion; under damping by block it does not.
TEST(Deformation, VibrationBrakesNoMotionUnderDampingByBlock) {
  const auto momentum_left = [](DampingKind damping, double inertia, int halves = 1) {
    Simulation simulation(scaled_units(inertia, inertia, damping, 0.6),
                          in_units(brick_grid({halves, 1, 1}, kBrick, {4, 2, 2})), 1);
    const Model& model = simulation.model();
    random_velocities(&simulation, 11, 1e-2);
    const auto momentum = [&] {
      double sum = 0.0;
      for (int b = 0; b < halves; ++b) {
        for (int n = 0; n < model.templates[0].node_count; ++n)
          sum += model.node_mass[dof(model, b, n, 0)] * lattice_velocity(simulation)[dof(model, b, n, 0)];
      }
      return sum;
    };
    for (int b = 0; b < halves; ++b) {
      for (int n = 0; n < model.templates[0].node_count; ++n) lattice_velocity(simulation)[dof(model, b, n, 0)] += 0.02;
    }
    const double start = momentum();
    simulation.advance(3000);
    return momentum() / start;
  };
  EXPECT_NEAR(momentum_left(DampingKind::block, 1.0), 1.0, 1e-9);
  EXPECT_NEAR(momentum_left(DampingKind::block, 16.0), 1.0, 1e-9);
  EXPECT_NEAR(momentum_left(DampingKind::block, 16.0, 2), 1.0, 1e-9);
  EXPECT_LT(momentum_left(DampingKind::local, 1.0), 0.98);
}

TEST(Deformation, ForcesByZoneAreThoseOfTheAssembledStiffness) {
  for (const DampingKind damping : {DampingKind::local, DampingKind::block}) {
    std::vector<double> displacement[2];
    for (const InternalForces way : {InternalForces::assembled, InternalForces::zones}) {
      Scene scene = scaled_scene(damping == DampingKind::block ? 16.0 : 1.0, damping, 0.5);
      scene.solver.internal_forces = way;
      scene.output.energy = true;
      Simulation simulation(scene, in_units(brick_grid({4, 3, 1}, kBrick, {4, 2, 2})), 1);
      random_velocities(&simulation, 11, 1e-3);
      simulation.advance(100);
      auto& u = displacement[way == InternalForces::zones];
      u.assign(lattice_displacement(simulation).begin(), lattice_displacement(simulation).end());
      u.push_back(simulation.measure().energies->strain * 1e-3);
    }
    double largest = 0.0, difference = 0.0;
    for (std::size_t i = 0; i < displacement[0].size(); ++i) {
      largest = std::max(largest, std::abs(displacement[0][i]));
      difference = std::max(difference, std::abs(displacement[0][i] - displacement[1][i]));
    }
    EXPECT_GT(largest, 0.0);
    // Rounding of 100 steps, amplified by damping that depends on the sign of velocities near zero.
    EXPECT_LT(difference, 1e-8 * largest);
    EXPECT_GT(difference, 0.0);
  }
}

}  // namespace
}  // namespace quoin
