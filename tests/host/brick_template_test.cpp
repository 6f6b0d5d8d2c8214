#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support.h"

namespace quoin {
namespace {

Brick half_brick(std::array<int, 3> zones = {4, 2, 2}, int parity = 0) {
  Brick brick;
  brick.size = {0.11, 0.0625, 0.1};
  brick.zones = zones;
  brick.parity = parity;
  return brick;
}

Eigen::MatrixXd unpack(const BrickTemplate& brick) {
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(3 * brick.node_count, 3 * brick.node_count);
  for (int row = 0; row < k.rows(); ++row) {
    for (const auto& [column, value] : brick.stiffness.row(row)) k(row, column) = value;
  }
  return k;
}

TEST(BrickTemplate, HalfBrickHas80ZonesAnd45Gridpoints) {
  const BrickTemplate brick = make_brick_template(half_brick(), brick_material());
  EXPECT_EQ(brick.zone.size(), 80u);
  EXPECT_EQ(brick.node_count, 45);
  double volume = 0.0, mass = 0.0;
  for (const Zone& zone : brick.zone) {
    EXPECT_GT(zone.volume, 0.0);
    volume += zone.volume;
  }
  for (double m : brick.node_mass) mass += m;
  EXPECT_NEAR(volume, 0.11 * 0.0625 * 0.1, 1e-16);
  EXPECT_NEAR(mass, kDensity * 0.11 * 0.0625 * 0.1, 1e-12);
}

TEST(BrickTemplate, StiffnessIsTheSumOfItsZones) {
  for (const auto& zones : {std::array{1, 1, 1}, std::array{4, 2, 2}, std::array{3, 2, 1}, std::array{2, 3, 5}}) {
    for (int parity : {0, 1}) {
      const Brick source = half_brick(zones, parity);
      const BrickTemplate brick = make_brick_template(source, brick_material());
      const Eigen::MatrixXd expected = dense_stiffness(source, brick_material()), k = unpack(brick);
      EXPECT_LT((k - expected).cwiseAbs().maxCoeff(), 1e-13 * expected.cwiseAbs().maxCoeff());
      const Eigen::VectorXd mass = dense_mass(source, brick_material());
      for (int n = 0; n < brick.node_count; ++n)
        EXPECT_NEAR(brick.node_mass[static_cast<std::size_t>(n)], mass[3 * n], 1e-15);
      EXPECT_EQ(brick.stiffness.column.size() % 2, 0u);
    }
  }
}

TEST(BrickTemplate, RigidMotionsGiveNoForce) {
  const BrickTemplate brick = make_brick_template(half_brick(), brick_material());
  const Eigen::MatrixXd k = unpack(brick);
  for (int mode = 0; mode < 6; ++mode) {
    Eigen::VectorXd u(k.rows());
    for (int n = 0; n < brick.node_count; ++n) {
      const Vec3& x = brick.node[static_cast<std::size_t>(n)];
      Eigen::Vector3d v = Eigen::Vector3d::Zero();
      if (mode < 3) v[mode] = 1.0;
      if (mode >= 3) v = Eigen::Vector3d::Unit(mode - 3).cross(Eigen::Vector3d(x[0], x[1], x[2]));
      u.segment(3 * n, 3) = v;
    }
    EXPECT_LT((k * u).cwiseAbs().maxCoeff(), 1e-13 * k.cwiseAbs().maxCoeff() * u.cwiseAbs().maxCoeff()) << mode;
  }
}

TEST(BrickTemplate, UniformStrainGivesUniformStress) {
  const BrickTemplate brick = make_brick_template(half_brick({3, 2, 1}, 1), brick_material());
  const double gradient[3][3] = {{1e-4, 3e-4, -2e-4}, {5e-5, -2e-4, 1e-4}, {4e-4, 2e-4, 3e-4}};
  const double g = kYoung / (2 * (1 + kPoisson)), l = kYoung * kPoisson / ((1 + kPoisson) * (1 - 2 * kPoisson));
  for (const Zone& zone : brick.zone) {
    std::array<Vec3, 4> u{};
    for (std::size_t n = 0; n < 4; ++n) {
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t d = 0; d < 3; ++d)
          u[n][c] += gradient[c][d] * brick.node[static_cast<std::size_t>(zone.node[n])][d];
      }
    }
    const auto s = zone_stress(zone, u, brick.lambda, brick.shear_modulus);
    const double trace = gradient[0][0] + gradient[1][1] + gradient[2][2];
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(s[c], l * trace + 2 * g * gradient[c][c], 1e-4);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(s[3 + c], g * (gradient[c][(c + 1) % 3] + gradient[(c + 1) % 3][c]), 1e-4);
  }
}

TEST(BrickTemplate, FaceTrianglesTileTheFaces) {
  const BrickTemplate brick = make_brick_template(half_brick({3, 2, 5}), brick_material());
  double area[6] = {};
  for (const FaceTriangle& triangle : brick.face_triangle) {
    const std::size_t s = static_cast<std::size_t>((triangle.face / 2 + 1) % 3),
                      t = static_cast<std::size_t>((triangle.face / 2 + 2) % 3);
    const auto at = [&](int i, std::size_t c) {
      return brick.node[static_cast<std::size_t>(triangle.node[static_cast<std::size_t>(i)])][c];
    };
    area[triangle.face] +=
        0.5 * std::abs((at(1, s) - at(0, s)) * (at(2, t) - at(0, t)) - (at(1, t) - at(0, t)) * (at(2, s) - at(0, s)));
  }
  for (std::size_t face = 0; face < 6; ++face) {
    EXPECT_NEAR(area[face], brick.size[(face / 2 + 1) % 3] * brick.size[(face / 2 + 2) % 3], 1e-15) << face;
  }
}

// Longitudinal vibration of a free bar at nu = 0: f = sqrt(E/rho)/(2L); the error of lumped masses falls like h^2.
TEST(BrickTemplate, BarFrequencyConvergesToTheBar) {
  double error[2];
  int i = 0;
  for (int n : {8, 16}) {
    Brick bar;
    bar.size = {1.0, 0.1, 0.1};
    bar.zones = {n, 2, 2};
    const BlockMaterial material = brick_material(0.0);
    const BrickTemplate shape = make_brick_template(bar, material);
    Eigen::VectorXd mass(3 * shape.node_count), wanted(3 * shape.node_count);
    wanted.setZero();
    for (int node = 0; node < shape.node_count; ++node) {
      mass.segment(3 * node, 3).setConstant(shape.node_mass[static_cast<std::size_t>(node)]);
      wanted[3 * node] = std::cos(std::numbers::pi * shape.node[static_cast<std::size_t>(node)][0]);
    }
    const Eigen::VectorXd root = mass.cwiseSqrt();
    const Eigen::MatrixXd scaled = root.cwiseInverse().asDiagonal() * unpack(shape) * root.cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
    wanted = wanted.cwiseProduct(root).normalized();
    int best = 0;
    (solver.eigenvectors().transpose() * wanted).cwiseAbs().maxCoeff(&best);
    const double f = std::sqrt(solver.eigenvalues()[best]) / (2 * std::numbers::pi);
    error[i++] = std::abs(f / (0.5 * std::sqrt(kYoung / kDensity)) - 1.0);
  }
  EXPECT_LT(error[0], 0.02);
  EXPECT_LT(error[1], 0.005);
  EXPECT_GT(error[0] / error[1], 3.0);
}

}  // namespace
}  // namespace quoin
