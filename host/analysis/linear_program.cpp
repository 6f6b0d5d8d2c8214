#include "analysis/linear_program.h"

#include <ClpSimplex.hpp>
#include <ClpSolve.hpp>
#include <algorithm>
#include <cmath>

namespace quoin {

namespace {

// Adds a price's share of the dual objective. Prices > 0 belong to upper bounds of a maximum, < 0 to lower ones. A
// price on the side of an infinite bound is an infeasibility of the dual programme.
void add_share(double price, double low, double high, LinearSolution* solution) {
  const double bound = price > 0.0 ? high : low;
  if (std::isfinite(bound))
    solution->dual_objective += price * bound;
  else
    solution->dual_residual = std::max(solution->dual_residual, std::abs(price));
}

double beyond(double value, double low, double high) { return std::max({0.0, low - value, value - high}); }

// Computes residuals and dual objective from the given programme, independent of the library's report.
void hold_against_programme(const LinearProgram& p, LinearSolution* solution) {
  std::vector<double> activity(static_cast<std::size_t>(p.rows()), 0.0);
  solution->objective = 0.0;
  for (int j = 0; j < p.columns(); ++j) {
    const auto c = static_cast<std::size_t>(j);
    const double x = solution->x[c];
    double reduced = p.cost[c];
    for (auto k = static_cast<std::size_t>(p.begin[c]); k < static_cast<std::size_t>(p.begin[c + 1]); ++k) {
      activity[static_cast<std::size_t>(p.row[k])] += p.value[k] * x;
      reduced -= p.value[k] * solution->price[static_cast<std::size_t>(p.row[k])];
    }
    solution->objective += p.cost[c] * x;
    solution->primal_residual = std::max(solution->primal_residual, beyond(x, p.low[c], p.high[c]));
    add_share(reduced, p.low[c], p.high[c], solution);
  }
  for (std::size_t r = 0; r < activity.size(); ++r) {
    solution->primal_residual = std::max(solution->primal_residual, beyond(activity[r], p.row_low[r], p.row_high[r]));
    add_share(solution->price[r], p.row_low[r], p.row_high[r], solution);
  }
}

}  // namespace

LinearSolution solve(const LinearProgram& p, bool interior, std::chrono::steady_clock::time_point deadline) {
  ClpSimplex clp;
  clp.setLogLevel(0);
  using Clock = std::chrono::steady_clock;
  if (deadline != Clock::time_point::max())
    clp.setMaximumWallSeconds(std::max(0.0, std::chrono::duration<double>(deadline - Clock::now()).count()));
  clp.scaling(0);  // Clp's scaling may report solutions that are infeasible in the unscaled programme
  clp.loadProblem(p.columns(), p.rows(), p.begin.data(), p.row.data(), p.value.data(), p.low.data(), p.high.data(),
                  p.cost.data(), p.row_low.data(), p.row_high.data());
  clp.setOptimizationDirection(-1.0);  // maximise
  ClpSolve how;
  how.setSolveType(interior ? ClpSolve::useBarrierNoCross : ClpSolve::useBarrier);
  how.setSpecialOption(2, 1);  // no handler of interrupts: Ctrl-C is the program's
  clp.initialSolve(how);
  if (!interior && !clp.isProvenOptimal()) clp.dual();
  LinearSolution solution;
  solution.status = clp.isProvenOptimal()            ? LinearStatus::solved
                    : clp.isProvenPrimalInfeasible() ? LinearStatus::infeasible
                    : clp.isProvenDualInfeasible()   ? LinearStatus::unbounded
                                                     : LinearStatus::stopped;
  solution.x.assign(clp.primalColumnSolution(), clp.primalColumnSolution() + clp.numberColumns());
  solution.price.assign(clp.dualRowSolution(), clp.dualRowSolution() + clp.numberRows());
  hold_against_programme(p, &solution);
  return solution;
}

}  // namespace quoin
