#include "random/correlation.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace quoin::random {

std::vector<double> mix_of(const std::vector<double>& correlations, std::size_t n) {
  const auto size = static_cast<Eigen::Index>(n);
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Matrix given = Eigen::Map<const Matrix>(correlations.data(), size, size);
  const Eigen::LLT<Matrix> factored(given);
  if (factored.info() != Eigen::Success) return {};
  const Matrix lower = factored.matrixL();
  return {lower.data(), lower.data() + lower.size()};
}

Follow follow(double distance, double length) {
  if (distance == 0.0) return {1.0, 0.0};
  if (length == 0.0) return {0.0, 1.0};
  return {std::exp(-distance / length), std::sqrt(-std::expm1(-2.0 * distance / length))};
}

double variance_of_mean(double interval, double length) {
  if (interval == 0.0) return 1.0;
  const double t = interval / length;
  return t < 1e-3 ? 1.0 - t / 3.0 : 2.0 / (t * t) * (t + std::expm1(-t));
}

Distribution of_points(const Distribution& of_mean, double length, std::span<const double> x,
                       std::span<const double> weight) {
  // Variance of the weighted mean over that of a point: the sum of w_i w_j f(r_ij), where r_ij is the correlation of
  // the points. Without a length each point has a draw of its own, also beside one with the same x.
  const auto correlation = [&](std::size_t i, std::size_t j) {
    return length > 0.0 ? follow(std::abs(x[i] - x[j]), length).share : i == j ? 1.0 : 0.0;
  };
  const auto over_pairs = [&](const auto& of_correlation) {
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (std::size_t j = 0; j < x.size(); ++j) sum += weight[i] * weight[j] * of_correlation(correlation(i, j));
    }
    return sum;
  };
  Distribution points = of_mean;
  if (of_mean.shape == Shape::normal) {
    points.scatter = of_mean.scatter / std::sqrt(over_pairs([](double r) { return r; }));
    return points;
  }
  // Lognormal: Cov = mean^2 (exp(s^2 r) - 1) increases with s, which bisection finds.
  const double wanted = std::pow(of_mean.scatter / of_mean.mean, 2.0);
  double low = std::log1p(wanted), high = low;
  const auto excess = [&](double s2) { return over_pairs([&](double r) { return std::expm1(s2 * r); }) - wanted; };
  while (excess(high) < 0.0) high *= 2.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) < 0.0 ? low : high) = middle;
  }
  points.scatter = of_mean.mean * std::sqrt(std::expm1(high));
  return points;
}

}  // namespace quoin::random
