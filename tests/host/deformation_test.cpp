// Inertia against deformation scaled apart from rigid motion, damping by block, and forces zone by zone.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "support.h"

namespace quoin {
namespace {

constexpr Vec3 kBrick{0.11, 0.0625, 0.1};

Scene scaled_scene(double deformation_inertia, DampingKind damping = DampingKind::none, double fraction = 0.6) {
  Scene scene = bare_scene(fraction, damping);
  scene.solver.deformation_inertia = deformation_inertia;
  return scene;
}

// M' = s M - (s - 1) M R (R^T M R)^-1 R^T M with R the null space of K: rigid motions, found without knowing them.
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

TEST(Deformation, StableJustBelowTheLimitUnstableJustAbove) {
  const Assembly assembly = brick_grid({2, 2, 1}, kBrick, {4, 2, 2});
  EXPECT_LT(largest_after(scaled_scene(16.0, DampingKind::none, 0.98), assembly, 3000), 1e-3);
  EXPECT_GT(largest_after(scaled_scene(16.0, DampingKind::none, 1.02), assembly, 3000), 1e3);
}

// Rigid motion has the true inertia whatever the factor: a force on a corner accelerates the block as a rigid body.
TEST(Deformation, RigidMotionKeepsItsInertia) {
  for (const DampingKind damping : {DampingKind::none, DampingKind::block}) {
    Scene scene = scaled_scene(100.0, damping);
    Stage stage;
    stage.gravity = {1.0, -9.81, 0.5};
    stage.duration = 1.0;
    scene.stages = {stage};
    scene.solver.local_damping = 0.0;
    Simulation simulation(scene, brick_grid({1, 1, 1}, kBrick, {4, 2, 2}), 1);
    // Turning slowly about z: u = omega x r.
    const Model& model = simulation.model();
    for (int n = 0; n < model.templates[0].node_count; ++n) {
      const Vec3& x = model.templates[0].node[static_cast<std::size_t>(n)];
      simulation.velocity()[dof(model, 0, n, 0)] = -1e-3 * x[1];
      simulation.velocity()[dof(model, 0, n, 1)] = 1e-3 * x[0];
    }
    simulation.advance(1000);
    const double t = simulation.time();
    const auto mesh = simulation.block_mesh(0);
    const auto velocity = simulation.block_velocity(0);
    for (std::size_t n = 0; n < velocity.size(); ++n) {
      EXPECT_NEAR(velocity[n][0], 1.0 * t - 1e-3 * mesh.gridpoint[n][1], 1e-12);
      EXPECT_NEAR(velocity[n][1], -9.81 * t + 1e-3 * mesh.gridpoint[n][0], 1e-12);
      EXPECT_NEAR(velocity[n][2], 0.5 * t, 1e-12);
    }
  }
}

// Energies count M' and what every damping takes.
TEST(Deformation, EnergyBalanceCloses) {
  for (const DampingKind damping : {DampingKind::none, DampingKind::viscous, DampingKind::block}) {
    Scene scene = scaled_scene(16.0, damping, 0.5);
    scene.output.energy = true;
    scene.solver.mass_damping = 500.0;
    scene.solver.stiffness_damping = 2e-7;
    Simulation simulation(scene, brick_grid({2, 2, 1}, kBrick, {2, 1, 1}), 1);
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

// The reason for damping by block: local damping lets the vibration of a block brake its flight.
TEST(Deformation, VibrationBrakesNoMotionUnderDampingByBlock) {
  const auto momentum_left = [](DampingKind damping, double inertia) {
    Simulation simulation(scaled_scene(inertia, damping), brick_grid({1, 1, 1}, kBrick, {4, 2, 2}), 1);
    const Model& model = simulation.model();
    random_velocities(&simulation, 11, 1e-2);
    const auto momentum = [&] {
      double sum = 0.0;
      for (int n = 0; n < model.templates[0].node_count; ++n)
        sum += model.node_mass[dof(model, 0, n, 0)] * simulation.velocity()[dof(model, 0, n, 0)];
      return sum;
    };
    for (int n = 0; n < model.templates[0].node_count; ++n) simulation.velocity()[dof(model, 0, n, 0)] += 0.02;
    const double start = momentum();
    simulation.advance(3000);
    return momentum() / start;
  };
  EXPECT_NEAR(momentum_left(DampingKind::block, 1.0), 1.0, 1e-9);
  EXPECT_NEAR(momentum_left(DampingKind::block, 16.0), 1.0, 1e-9);
  EXPECT_LT(momentum_left(DampingKind::local, 1.0), 0.98);
}

TEST(Deformation, ForcesByZoneAreThoseOfTheAssembledStiffness) {
  for (const DampingKind damping : {DampingKind::local, DampingKind::block}) {
    std::vector<double> displacement[2];
    for (const InternalForces way : {InternalForces::assembled, InternalForces::zones}) {
      Scene scene = scaled_scene(damping == DampingKind::block ? 16.0 : 1.0, damping, 0.5);
      scene.solver.internal_forces = way;
      scene.output.energy = true;
      Simulation simulation(scene, brick_grid({3, 3, 1}, kBrick, {4, 2, 2}), 1);
      random_velocities(&simulation, 11, 1e-3);
      simulation.advance(100);
      auto& u = displacement[way == InternalForces::zones];
      u.assign(simulation.displacement().begin(), simulation.displacement().end());
      u.push_back(simulation.measure().energies->strain * 1e-3);
    }
    double largest = 0.0, difference = 0.0;
    for (std::size_t i = 0; i < displacement[0].size(); ++i) {
      largest = std::max(largest, std::abs(displacement[0][i]));
      difference = std::max(difference, std::abs(displacement[0][i] - displacement[1][i]));
    }
    EXPECT_GT(largest, 0.0);
    // Rounding of 100 steps, which damping by the sign of a velocity near zero magnifies.
    EXPECT_LT(difference, 1e-8 * largest);
    EXPECT_GT(difference, 0.0);
  }
}

}  // namespace
}  // namespace quoin
