// Linear programmes, solved by the library Clp; other code includes only this header.
#pragma once

#include <chrono>
#include <limits>
#include <vector>

namespace quoin {

inline constexpr double kNoBound = std::numeric_limits<double>::infinity();

// Maximise cost.x over low <= x <= high with row_low <= A x <= row_high. A is given column by column.
struct LinearProgram {
  std::vector<double> row_low, row_high;
  std::vector<double> cost, low, high;
  std::vector<int> begin{0};  // begin of each column in `row` and `value`; end of the last one
  std::vector<int> row;
  std::vector<double> value;

  int rows() const { return static_cast<int>(row_low.size()); }
  int columns() const { return static_cast<int>(cost.size()); }
  int add_row(double from, double to) {
    row_low.push_back(from), row_high.push_back(to);
    return rows() - 1;
  }
  // Coefficients of the column follow by add(), each row once, in any order.
  int add_column(double c, double from, double to) {
    cost.push_back(c), low.push_back(from), high.push_back(to), begin.push_back(begin.back());
    return columns() - 1;
  }
  void add(int in_row, double coefficient) {  // to the last column
    if (coefficient == 0.0) return;
    row.push_back(in_row), value.push_back(coefficient), ++begin.back();
  }
};

enum class LinearStatus { solved, infeasible, unbounded, stopped };

struct LinearSolution {
  LinearStatus status = LinearStatus::stopped;
  double objective = 0.0;
  double dual_objective = 0.0;  // from prices and bounds; an upper bound where dual_residual is 0
  std::vector<double> x;
  std::vector<double> price;     // prices of rows: change of the objective with the active bound
  double primal_residual = 0.0;  // largest distance of a row or column from its bounds
  double dual_residual = 0.0;    // largest price of a row or column whose bound on that side is infinite
};

// Solution at a vertex; interior: centre of all solutions, by an interior point method alone. Uses one thread. At the
// deadline it stops after the step that it is in.
LinearSolution solve(const LinearProgram& program, bool interior = false,
                     std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max());

}  // namespace quoin
