// Implicit contacts, with the mean traction of a step, against a solution of the equations of the whole model.
#include "step/implicit_contacts.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

#include "base/index.h"
#include "support.h"

namespace quoin {
namespace {

struct Columns {
  LaneVector<double> traction[3], old_traction[3], viscous[3], way[3];
};

// Returns elastic joints with viscosity that have just closed.
Columns shown(const Model& model, std::mt19937& random, double kn, double ks, double beta, double dt) {
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  Columns c;
  for (int k = 0; k < 3; ++k) {
    for (auto* column : {&c.traction[k], &c.old_traction[k], &c.viscous[k], &c.way[k]})
      column->resize(at(model.point_count));
    for (std::size_t i = 0; i < at(model.point_count); ++i) {
      const double stiffness = k == 0 ? kn : ks;
      c.way[k][i] = 1e-7 * number(random);
      c.old_traction[k][i] = -1e5;
      c.traction[k][i] = c.old_traction[k][i] + stiffness * c.way[k][i];
      c.viscous[k][i] = beta * stiffness * c.way[k][i] / dt;
    }
  }
  return c;
}

// Eight blocks that meet at one point: clusters of two, four and eight gridpoints. They solve (M + G) (v - v0) =
// M (v* - v0) to rounding.
TEST(ImplicitContacts, SolveTheEquationOfAllGridpoints) {
  const double kn = 5e9, ks = 2e9, beta = 2e-5, dt = 2e-5;
  Assembly assembly = brick_grid({2, 2, 2}, {0.1, 0.12, 0.08}, {2, 2, 1}, elastic_family(kn, ks));
  auto materials = make_materials(assembly);
  const Model model(std::move(assembly), std::move(materials));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  Columns c = shown(model, random, kn, ks, beta, dt);
  ImplicitContacts contacts(model, model.node_mass);
  ASSERT_TRUE(contacts.in_use());
  for (const ContactChunk& chunk : model.chunks) {
    const auto first = chunk.first_point;
    ImplicitContacts::Chunk columns{};
    for (int k = 0; k < 3; ++k) {
      columns.traction[k] = c.traction[k].data() + first, columns.old_traction[k] = c.old_traction[k].data() + first;
      columns.viscous[k] = c.viscous[k].data() + first, columns.way[k] = c.way[k].data() + first;
    }
    columns.area = model.area.data() + first;
    columns.normal_stiffness = kn, columns.shear_stiffness = ks, columns.viscosity = {beta, beta};
    contacts.weigh(chunk, columns, dt);
  }
  const std::size_t size = model.node_mass.size();
  LaneVector<double> velocity(size), displacement(size);
  for (std::size_t i = 0; i < size; ++i)
    velocity[i] = model.node_mass[i] > 0.0 ? number(random) : 0.0, displacement[i] = 1e-3 * velocity[i];
  const LaneVector<double> before = velocity, place = displacement;
  StepData step;
  step.time_step = dt, step.velocity = velocity.data(), step.displacement = displacement.data();
  for (int piece = 0; piece < contacts.pieces(); ++piece) contacts.settle(piece, step);

  const auto n = static_cast<Eigen::Index>(size);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double mass = std::max(model.node_mass[at(int(i))], 1e-300);
    matrix(i, i) = mass, right(i) = mass * before[at(int(i))];
  }
  for (std::int32_t p = 0; p < model.point_count; ++p) {
    for (int k = 0; k < 3; ++k) {
      const int component = (model.point_axis[at(p)] + k) % 3;
      const double g = model.area[at(p)] * (k == 0 ? kn : ks) * (0.25 * dt * dt + 0.5 * dt * beta);
      const Eigen::Index a = model.node_a[at(p)] + component * kLanes, b = model.node_b[at(p)] + component * kLanes;
      matrix(a, a) += g, matrix(b, b) += g, matrix(a, b) -= g, matrix(b, a) -= g;
      right(a) -= g * c.way[k][at(p)] / dt, right(b) += g * c.way[k][at(p)] / dt;
    }
  }
  const Eigen::VectorXd expected = matrix.ldlt().solve(right);
  double momentum = 0.0, moved = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    if (model.node_mass[i] == 0.0) continue;
    EXPECT_NEAR(velocity[i], expected(static_cast<Eigen::Index>(i)), 1e-12);
    EXPECT_NEAR(displacement[i], place[i] + dt * (velocity[i] - before[i]), 1e-15);
    momentum += model.node_mass[i] * (velocity[i] - before[i]);
    moved = std::max(moved, std::abs(velocity[i] - before[i]));
  }
  EXPECT_GT(moved, 0.1);
  EXPECT_NEAR(momentum, 0.0, 1e-13 * model.total_mass());
}

// Joints without a known rate from a previous step are not included.
TEST(ImplicitContacts, BeginWithARateThatIsKnown) {
  Assembly assembly = brick_grid({2, 1, 1}, {0.1, 0.1, 0.1}, {1, 1, 1}, elastic_family(5e9, 2e9));
  auto materials = make_materials(assembly);
  const Model model(std::move(assembly), std::move(materials));
  std::mt19937 random(3);
  Columns c = shown(model, random, 5e9, 2e9, 1e-5, 1e-5);
  std::fill(c.way[0].begin(), c.way[0].end(), std::nan(""));
  ImplicitContacts contacts(model, model.node_mass);
  for (const ContactChunk& chunk : model.chunks) {
    ImplicitContacts::Chunk columns{};
    for (int k = 0; k < 3; ++k) {
      columns.traction[k] = c.traction[k].data() + chunk.first_point;
      columns.old_traction[k] = c.old_traction[k].data() + chunk.first_point;
      columns.way[k] = c.way[k].data() + chunk.first_point;
    }
    columns.area = model.area.data() + chunk.first_point;
    columns.normal_stiffness = 5e9, columns.shear_stiffness = 2e9;
    contacts.weigh(chunk, columns, 1e-5);
  }
  LaneVector<double> velocity(model.node_mass.size(), 0.0), displacement(velocity);
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] = model.node_mass[i] > 0.0 ? double(i % 7) : 0.0;
  const LaneVector<double> before = velocity;
  StepData step;
  step.time_step = 1e-5, step.velocity = velocity.data(), step.displacement = displacement.data();
  for (int piece = 0; piece < contacts.pieces(); ++piece) contacts.settle(piece, step);
  EXPECT_EQ(velocity, before);
}

}  // namespace
}  // namespace quoin
