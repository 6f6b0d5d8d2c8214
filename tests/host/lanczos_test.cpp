#include "model/lanczos.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>

namespace quoin {
namespace {

struct Counted {
  Eigen::MatrixXd matrix;
  int products = 0;
  double operator()(const LaneVector<double>& x, LaneVector<double>* y) {
    ++products;
    const auto size = static_cast<Eigen::Index>(x.size());
    const Eigen::Map<const Eigen::VectorXd> from(x.data(), size);
    Eigen::Map<Eigen::VectorXd> to(y->data(), size);
    to = matrix * from;
    return to.dot(from);
  }
};

LanczosSettings settings(bool with_vector) {
  LanczosSettings settings;
  settings.max_steps = 200;
  settings.check_interval = 10;
  settings.settled = 1e-12;
  settings.with_vector = with_vector;
  return settings;
}

Counted random_matrix(int size) {
  std::srand(5);
  const Eigen::MatrixXd half = Eigen::MatrixXd::Random(size, size);
  return {half * half.transpose()};
}

TEST(Lanczos, FindsValueAndVectorOfTheDenseSolution) {
  Counted product = random_matrix(120);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> dense(product.matrix);
  const LargestEigenvalue found = largest_eigenvalue(std::ref(product), LaneVector<double>(120, 3.0), settings(true));
  EXPECT_NEAR(found.value, dense.eigenvalues()[119], 1e-11 * found.value);
  const Eigen::Map<const Eigen::VectorXd> vector(found.vector.data(), 120);
  // The error of a Rayleigh quotient is the square of that of its vector: 1e-12 and 1e-6.
  EXPECT_NEAR(std::abs(vector.dot(dense.eigenvectors().col(119))), 1.0, 1e-6);
  EXPECT_EQ(found.products, 2 * found.steps - 1);
  EXPECT_EQ(product.products, found.products);
}

TEST(Lanczos, OneProductAStepWithoutTheVector) {
  Counted product = random_matrix(120);
  const LargestEigenvalue found = largest_eigenvalue(std::ref(product), LaneVector<double>(120, 1.0), settings(false));
  EXPECT_EQ(product.products, found.steps);
  EXPECT_LT(found.steps, 120);
  EXPECT_TRUE(found.vector.empty());
}

TEST(Lanczos, StopsWhereNothingIsLeft) {
  Counted identity{2.5 * Eigen::MatrixXd::Identity(30, 30)};
  const LargestEigenvalue found = largest_eigenvalue(std::ref(identity), LaneVector<double>(30, 1.0), settings(true));
  EXPECT_EQ(found.steps, 1);
  EXPECT_NEAR(found.value, 2.5, 1e-14);  // sums of 30 terms
  Counted nothing{Eigen::MatrixXd::Zero(30, 30)};
  EXPECT_EQ(largest_eigenvalue(std::ref(nothing), LaneVector<double>(30, 1.0), settings(false)).value, 0.0);
  EXPECT_EQ(largest_eigenvalue(std::ref(nothing), LaneVector<double>(30, 0.0), settings(false)).steps, 0);
}

// Equal modes leave rounding errors in the recurrence, and squared frequencies are far from 1: Eigen's eigenvalues of
// the tridiagonal matrix are in no order then. A cube on a base gave a 20th of the true value.
TEST(Lanczos, EqualModesAtAnyScale) {
  for (int exponent = -20; exponent <= 40; ++exponent) {
    for (int size = 6; size <= 24; size += 6) {
      Eigen::VectorXd values(size);
      for (int i = 0; i < size; ++i) values[i] = std::ldexp(1.0 + i / 3, exponent);
      const Eigen::MatrixXd turn = Eigen::HouseholderQR<Eigen::MatrixXd>(random_matrix(size).matrix).householderQ();
      Counted product{turn * values.asDiagonal() * turn.transpose()};
      LaneVector<double> start(static_cast<std::size_t>(size));
      for (std::size_t i = 0; i < start.size(); ++i) start[i] = std::sin(1.0 + static_cast<double>(i));
      const LargestEigenvalue found = largest_eigenvalue(std::ref(product), start, settings(true));
      EXPECT_NEAR(found.value, values[size - 1], 1e-12 * values[size - 1]) << size << " at 2^" << exponent;
      const Eigen::Map<const Eigen::VectorXd> vector(found.vector.data(), size);
      EXPECT_LT((product.matrix * vector - found.value * vector).norm(), 1e-7 * found.value * vector.norm());
    }
  }
}

TEST(Lanczos, WhatIsNoNumberIsToldAndNotIteratedOn) {
  Counted broken{Eigen::MatrixXd::Constant(4, 4, std::numeric_limits<double>::quiet_NaN())};
  EXPECT_TRUE(std::isnan(largest_eigenvalue(std::ref(broken), LaneVector<double>(4, 1.0), settings(false)).value));
  EXPECT_EQ(broken.products, 1);
}

}  // namespace
}  // namespace quoin
