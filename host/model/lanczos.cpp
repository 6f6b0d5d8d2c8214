#include "model/lanczos.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"

namespace quoin {
namespace {

// Largest eigenvalue of the tridiagonal matrix so far, and its convergence.
class RitzValue {
 public:
  RitzValue(const LanczosSettings& settings, std::size_t dimension) : settings_(settings), dimension_(dimension) {}

  // Adds a row; returns whether the iteration can end. a: diagonal element, b: element below it.
  bool add(double a, double b) {
    diagonal_.push_back(a);
    beside_.push_back(b);
    const int steps = this->steps();
    // The subspace is complete.
    const bool exhausted = b <= 1e-14 * std::abs(a) || diagonal_.size() >= dimension_;
    const bool last = exhausted || steps == settings_.max_steps;
    if (!last && steps % settings_.check_interval != 0) return false;
    const double before = value_;
    const Solver solver = solved(Eigen::EigenvaluesOnly);
    value_ = unit_ * solver.eigenvalues()[steps - 1];
    return last || (steps > settings_.first_check && value_ - before < settings_.settled * value_);
  }
  Eigen::VectorXd vector() {
    return solved(Eigen::ComputeEigenvectors).eigenvectors().col(steps() - 1);  // costs far more than the values
  }
  int steps() const { return static_cast<int>(diagonal_.size()); }
  double value() const { return value_; }
  double last_beside() const { return beside_.empty() ? 0.0 : beside_.back(); }
  double beside(int step) const { return beside_[static_cast<std::size_t>(step)]; }
  double diagonal(int step) const { return diagonal_[static_cast<std::size_t>(step)]; }

 private:
  using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;
  // Eigen drops an element beside the diagonal below rounding of the square root of its neighbours, as if these were
  // near 1. Rounding errors of larger ones stay: it may give up, with its values in no order. So a matrix on which it
  // gives up is solved in another unit. A new solver each time. A member that grows would free its memory first, and
  // again if allocation fails.
  Solver solved(int what) {
    for (const double unit : {unit_, std::exp2(std::ilogb(diagonal().cwiseAbs().maxCoeff()))}) {
      unit_ = unit;
      Solver solver;
      solver.computeFromTridiagonal(diagonal() / unit, beside() / unit, what);
      // No Rayleigh quotient is above the largest value.
      const double quotient = diagonal().maxCoeff() / unit, largest = solver.eigenvalues()[steps() - 1];
      if (solver.info() == Eigen::Success && quotient - largest <= 1e-9 * std::abs(quotient)) return solver;
    }
    throw Error(Exit::numerical, "the highest frequency of the model was not found");
  }
  Eigen::VectorXd diagonal() const { return Eigen::Map<const Eigen::VectorXd>(diagonal_.data(), steps()); }
  Eigen::VectorXd beside() const { return Eigen::Map<const Eigen::VectorXd>(beside_.data(), steps() - 1); }

  const LanczosSettings& settings_;
  std::size_t dimension_;
  std::vector<double> diagonal_, beside_;
  double value_ = 0.0;
  double unit_ = 1.0;  // of the matrix that is solved: a power of two, which rounds nothing
};

}  // namespace

LargestEigenvalue largest_eigenvalue(const SymmetricProduct& product, LaneVector<double> start,
                                     const LanczosSettings& settings, SharedVectors* shared) {
  const std::size_t n = start.size();
  const VectorRow all{0, n};
  const std::span<const VectorRow> rows = shared ? shared->rows() : std::span(&all, 1);
  const auto sum = [&](const auto& add) { return shared ? shared->sum(add) : add(all, 0.0); };
  const double squared = sum([&](const VectorRow& row, double so_far) {
    for (std::size_t i = row.first; i < row.end; ++i) so_far += start[i] * start[i];
    return so_far;
  });
  LargestEigenvalue result;
  if (squared == 0.0) return result;
  const double length = std::sqrt(squared);
  for (const VectorRow& row : rows) {
    for (std::size_t i = row.first; i < row.end; ++i) start[i] /= length;
  }

  const auto moving = static_cast<std::size_t>(sum([&](const VectorRow& row, double so_far) {
    return so_far + static_cast<double>(std::count_if(start.begin() + row.first, start.begin() + row.end,
                                                      [](double x) { return x != 0.0; }));
  }));
  RitzValue ritz(settings, moving);
  LaneVector<double> first;  // first basis vector, for the second sweep
  if (settings.with_vector) first = start;
  LaneVector<double> q = std::move(start), previous(n, 0.0), y(n);
  // y = y - a q - old_b previous, and returns its length; then the next q is y over that length.
  const auto orthogonalise = [&](double a, double old_b) {
    double b = 0.0;
    if (!shared) {
      for (std::size_t i = 0; i < n; ++i) {
        y[i] -= a * q[i] + old_b * previous[i];
        b += y[i] * y[i];
      }
      return std::sqrt(b);
    }
    for (const VectorRow& row : rows) {
      for (std::size_t i = row.first; i < row.end; ++i) y[i] -= a * q[i] + old_b * previous[i];
    }
    return std::sqrt(shared->sum([&](const VectorRow& row, double so_far) {
      for (std::size_t i = row.first; i < row.end; ++i) so_far += y[i] * y[i];
      return so_far;
    }));
  };
  const auto go_on = [&](double b) {
    previous.swap(q);
    for (const VectorRow& row : rows) {
      for (std::size_t i = row.first; i < row.end; ++i) q[i] = y[i] / b;
    }
  };
  for (bool done = false; !done;) {
    const double a = product(q, &y);
    ++result.products;
    const double b = orthogonalise(a, ritz.last_beside());
    if (!std::isfinite(a + b)) {
      result.value = std::numeric_limits<double>::quiet_NaN();
      return result;
    }
    done = ritz.add(a, b);
    if (!done) go_on(b);
  }
  result.value = ritz.value();
  result.steps = ritz.steps();
  if (!settings.with_vector) return result;

  // The recurrence runs a second time: a stored basis would fill the memory.
  const Eigen::VectorXd weight = ritz.vector();
  result.vector.assign(n, 0.0);
  q = std::move(first);
  std::fill(previous.begin(), previous.end(), 0.0);
  for (int j = 0;; ++j) {
    for (std::size_t i = 0; i < n; ++i) result.vector[i] += weight[j] * q[i];
    if (j + 1 == result.steps) break;
    product(q, &y);
    ++result.products;
    orthogonalise(ritz.diagonal(j), j > 0 ? ritz.beside(j - 1) : 0.0);
    go_on(ritz.beside(j));
  }
  return result;
}

}  // namespace quoin
