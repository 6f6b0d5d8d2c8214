#include "analysis/limit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <numbers>
#include <thread>

#include "analysis/cone_limit.h"
#include "analysis/linear_program.h"
#include "base/error.h"

namespace quoin {
namespace {

using geometry::Vector;

// Largest residual that counts as rounding, of equilibrium (in mean loads of a block) and of virtual velocities.
constexpr double kResidual = 1e-6;
constexpr double kInteriorResidual = 1e-4;  // the same for the centre of all solutions

// Contact points from which on a sufficiently exact centre replaces the vertex, whose computation takes most of the
// time.
constexpr std::size_t kManyPoints = 1000;
constexpr double kGap =
    2e-7;  // Gap of the bounds of the multiplier, over max(1, multiplier); within kAll of stands.cpp.

// Live loads of more than this multiple of the dead loads, or of the strengths, move nothing. Without a bound Clp's
// interior point method ends the process where a programme has no largest multiplier. A larger number costs digits of
// forces there.
constexpr double kWithoutLimit = 1e5;

[[noreturn]] void refuse(const std::string& why) { throw Error(Exit::bad_input, "limit analysis: " + why); }

bool finite(const Vector& v) { return std::isfinite(v.x + v.y + v.z); }

void require(const LimitProblem& problem, const LimitSettings& settings) {
  constexpr int kFewest = 4, kMost = 1000;  // with 1000 up to 5e-6 of the friction is missing
  if ((settings.facets < kFewest || settings.facets > kMost) && settings.facets != 0)
    refuse(fmt::format("{} facets of a friction cone; allowed: {} to {}, or 0 for the whole cone", settings.facets,
                       kFewest, kMost));
  const auto count = static_cast<int>(problem.blocks.size());
  bool live = false;
  for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
    const LimitBlock& b = problem.blocks[i];
    if (!finite(b.centre) || !finite(b.dead.force) || !finite(b.dead.moment) || !finite(b.live.force) ||
        !finite(b.live.moment))
      refuse(fmt::format("block {} has a value that is not finite", i));
    live = live || (!b.fixed && (norm(b.live.force) > 0.0 || norm(b.live.moment) > 0.0));
  }
  for (const LimitPoint& p : problem.points) live = live || p.live_cohesion != 0.0;
  if (!live) refuse("no load of a free block is multiplied; nothing can be found");
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    const LimitPoint& p = problem.points[i];
    if (p.a < 0 || p.a >= count || p.b < 0 || p.b >= count || p.a == p.b)
      refuse(fmt::format("contact point {} joins blocks {} and {} of {}", i, p.a, p.b, count));
    if (!finite(p.position) || !finite(p.n) || !finite(p.s) || !finite(p.t) ||
        !(p.friction >= 0.0 || settings.interior) || !(p.tension >= 0.0) || !(p.cohesion >= 0.0) ||
        !(p.crushing > 0.0) || !std::isfinite(p.friction + p.tension + p.cohesion + p.live_cohesion))
      refuse(fmt::format("contact point {} has a strength below 0 or a value that is not finite", i));
  }
  for (std::size_t i = 0; i < problem.forces.size(); ++i) {
    const LimitForce& force = problem.forces[i];
    if (!(force.low <= 0.0 && force.high >= 0.0))
      refuse(fmt::format("force {} of members has the bounds {:g} and {:g}; allowed: bounds with 0 between them", i,
                         force.low, force.high));
    for (const LimitForce::Place& place : force.places) {
      if (place.block < 0 || place.block >= count)
        refuse(fmt::format("force {} of members acts on block {} of {}", i, place.block, count));
      if (!finite(place.at) || !finite(place.way) || !finite(place.turn))
        refuse(fmt::format("force {} of members has no length, or a value that is not finite", i));
    }
  }
}

// Linear programme of a problem. Forces are in multiples of the mean load of a block, lengths in multiples of the mean
// arm of a contact point.
class Programme {
 public:
  Programme(const LimitProblem& problem, const LimitSettings& settings) : problem_(problem), settings_(settings) {
    const LimitUnits units = units_of(problem);
    force_ = units.force, length_ = units.length;
    add_equilibrium();
    for (std::size_t i = 0; i < problem.points.size(); ++i) add_rows(problem.points[i]);
    add_multiplier();
    for (std::size_t i = 0; i < problem.points.size(); ++i) add_columns(i);
    for (const LimitForce& force : problem.forces) add_force(force);
  }

  const LinearProgram& linear() const { return linear_; }
  bool reaches(double multiplier) const { return multiplier > 0.99 * without_limit_; }  // no mechanism

  LimitResult result(const LinearSolution& solution) const {
    LimitResult r;
    r.multiplier = solution.objective;
    r.gap = std::abs(solution.dual_objective - solution.objective) / std::max(1.0, std::abs(solution.objective));
    for (std::size_t i = 0; i < problem_.points.size(); ++i) r.force.push_back(force_at(i, solution.x));
    for (const int column : member_columns_)
      r.member_force.push_back(force_ * solution.x[static_cast<std::size_t>(column)]);
    r.velocity.resize(problem_.blocks.size());
    for (std::size_t k = 0; k < problem_.blocks.size(); ++k) {
      if (rows_[k] < 0) continue;
      for (int c = 0; c < 3; ++c) {
        const auto row = static_cast<std::size_t>(rows_[k] + c);
        r.velocity[k].force[c] = solution.price[row];
        r.velocity[k].moment[c] = solution.price[row + 3] / length_;
      }
    }
    return r;
  }

 private:
  struct Columns {
    int first = 0, normal = 0;  // columns of the shear along edges, and of the pure normal force
    double lift = 0.0;          // compression for a unit of an edge
    double tension = 0.0;       // at the apex, in units of force_
    int shear_row = -1, crushing_row = -1;
    bool slides = false;  // whether it carries shear
  };

  // Equilibrium: contact forces on a block = -(dead + multiplier * live), six rows a free block.
  void add_equilibrium() {
    rows_.assign(problem_.blocks.size(), -1);
    for (std::size_t k = 0; k < problem_.blocks.size(); ++k) {
      const LimitBlock& b = problem_.blocks[k];
      if (b.fixed) continue;
      rows_[k] = linear_.rows();
      for (int c = 0; c < 6; ++c) {
        const double dead = c < 3 ? b.dead.force[c] / force_ : b.dead.moment[c - 3] / (force_ * length_);
        linear_.add_row(-dead, -dead);
      }
    }
  }

  // Bound of the multiplier past which no mechanism counts; infinite if strengths grow with it.
  double bound_of_multiplier() const {
    double live = 0.0, strength = 0.0;
    const auto add = [&](double force) { strength += std::isfinite(force) ? force : 0.0; };
    for (const LimitBlock& b : problem_.blocks) live += norm(b.live.force) + norm(b.live.moment) / length_;
    for (const LimitPoint& p : problem_.points) {
      if (p.live_cohesion != 0.0) return kNoBound;
      add(p.tension), add(p.cohesion), add(p.crushing);
    }
    for (const LimitForce& f : problem_.forces) add(std::max(std::abs(f.low), std::abs(f.high)));
    return kWithoutLimit * (force_ * static_cast<double>(problem_.blocks.size()) + strength) / live;
  }

  void add_multiplier() {
    without_limit_ = bound_of_multiplier();
    linear_.add_column(1.0, -kNoBound, std::min(settings_.most, without_limit_));
    for (std::size_t k = 0; k < problem_.blocks.size(); ++k) {
      if (rows_[k] < 0) continue;
      const Wrench& live = problem_.blocks[k].live;
      for (int c = 0; c < 3; ++c) linear_.add(rows_[k] + c, live.force[c] / force_);
      for (int c = 0; c < 3; ++c) linear_.add(rows_[k] + 3 + c, live.moment[c] / (force_ * length_));
    }
    for (std::size_t i = 0; i < problem_.points.size(); ++i)
      if (columns_[i].shear_row >= 0) linear_.add(columns_[i].shear_row, -problem_.points[i].live_cohesion / force_);
  }

  // Adds coefficients of the last column: a force f on this block.
  void act(int block, const Vector& position, const Vector& f) {
    const int row = rows_[static_cast<std::size_t>(block)];
    if (row < 0) return;
    const Vector moment = cross(position - problem_.blocks[static_cast<std::size_t>(block)].centre, f);
    for (int c = 0; c < 3; ++c) linear_.add(row + c, f[c]);
    for (int c = 0; c < 3; ++c) linear_.add(row + 3 + c, moment[c] / length_);
  }
  // A force f on block a, and the opposite on b.
  void act(const LimitPoint& p, const Vector& f) { act(p.a, p.position, f), act(p.b, p.position, -f); }

  // A unit of the column is force_, whether it is a force, a moment or a shear flow.
  void add_force(const LimitForce& force) {
    member_columns_.push_back(linear_.add_column(0.0, force.low / force_, force.high / force_));
    std::map<int, double> sum;  // several places may be on one block
    for (const LimitForce::Place& place : force.places) {
      const int row = rows_[static_cast<std::size_t>(place.block)];
      if (row < 0) continue;
      const Vector& centre = problem_.blocks[static_cast<std::size_t>(place.block)].centre;
      const Vector moment = place.turn + cross(place.at - centre, place.way);
      for (int c = 0; c < 3; ++c) sum[row + c] += place.way[c], sum[row + 3 + c] += moment[c] / length_;
    }
    for (const auto& [row, coefficient] : sum) linear_.add(row, coefficient);
  }

  // Tractions inside a pyramid with its apex at sigma = tension. Normal force is tension - N, shear the sum of e_i d_i
  // over the edges d_i with sum of e_i <= c + mu N. Without cohesion at the apex, the column of an edge includes its
  // compression.
  void add_rows(const LimitPoint& p) {
    Columns columns;
    const double tension = p.friction > 0.0 ? std::min(p.tension, p.cohesion / p.friction) : p.tension;
    columns.tension = tension / force_;
    const double at_apex = std::max(0.0, p.cohesion - p.friction * tension) / force_;
    const bool own_row = at_apex > 0.0 || p.live_cohesion != 0.0;
    columns.slides = p.friction > 0.0 || own_row;
    columns.lift = !own_row && p.friction > 0.0 ? 1.0 / p.friction : 0.0;
    if (own_row) columns.shear_row = linear_.add_row(-kNoBound, at_apex);
    if (std::isfinite(p.crushing)) columns.crushing_row = linear_.add_row(-kNoBound, (p.crushing + tension) / force_);
    add_apex(p, columns.tension);
    columns_.push_back(columns);
  }

  void add_columns(std::size_t i) {
    const LimitPoint& p = problem_.points[i];
    Columns& columns = columns_[i];
    columns.normal = linear_.add_column(0.0, 0.0, kNoBound);
    act(p, -p.n);
    if (columns.shear_row >= 0) linear_.add(columns.shear_row, -p.friction);
    if (columns.crushing_row >= 0) linear_.add(columns.crushing_row, 1.0);
    columns.first = linear_.columns();
    for (int e = 0; columns.slides && e < settings_.facets; ++e) {
      const double angle = edge_angle(e);
      linear_.add_column(0.0, 0.0, kNoBound);
      act(p, std::cos(angle) * p.s + std::sin(angle) * p.t - columns.lift * p.n);
      if (columns.shear_row >= 0) linear_.add(columns.shear_row, 1.0);
      if (columns.crushing_row >= 0) linear_.add(columns.crushing_row, columns.lift);
    }
  }

  // Angle from s towards t, rad.
  double edge_angle(int edge) const {
    const double first = settings_.facet_on_axis ? 0.5 : 0.0;
    return 2.0 * std::numbers::pi * (edge + first) / settings_.facets;
  }

  // Adds the tension of the apex to the constants of equilibrium.
  void add_apex(const LimitPoint& p, double tension) {
    if (tension == 0.0) return;
    for (const auto& [block, sign] : {std::pair(p.a, 1.0), std::pair(p.b, -1.0)}) {
      const int row = rows_[static_cast<std::size_t>(block)];
      if (row < 0) continue;
      const Vector moment = cross(p.position - problem_.blocks[static_cast<std::size_t>(block)].centre, p.n);
      for (int c = 0; c < 3; ++c) move_row(row + c, -sign * tension * p.n[c]);
      for (int c = 0; c < 3; ++c) move_row(row + 3 + c, -sign * tension * moment[c] / length_);
    }
  }
  void move_row(int row, double by) {
    linear_.row_low[static_cast<std::size_t>(row)] += by;
    linear_.row_high[static_cast<std::size_t>(row)] += by;
  }

  std::array<double, 3> force_at(std::size_t i, const std::vector<double>& x) const {
    const Columns& columns = columns_[i];
    double compression = x[static_cast<std::size_t>(columns.normal)], s = 0.0, t = 0.0;
    for (int e = 0; columns.slides && e < settings_.facets; ++e) {
      const double edge = x[static_cast<std::size_t>(columns.first + e)];
      const double angle = edge_angle(e);
      compression += columns.lift * edge, s += edge * std::cos(angle), t += edge * std::sin(angle);
    }
    return {force_ * (columns.tension - compression), force_ * s, force_ * t};
  }

  const LimitProblem& problem_;
  const LimitSettings& settings_;
  double force_ = 1.0, length_ = 1.0;  // N, m
  double without_limit_ = kNoBound;
  LinearProgram linear_;
  std::vector<int> rows_;  // first of each block; -1: fixed
  std::vector<Columns> columns_;
  std::vector<int> member_columns_;
};

// Scales the mechanism to a largest velocity of 1 at centres and contact points.
void scale_mechanism(const LimitProblem& problem, LimitResult* r) {
  if (r->velocity.empty()) return;
  double largest = 0.0;
  for (const Wrench& v : r->velocity) largest = std::max(largest, norm(v.force));
  for (const LimitPoint& p : problem.points) {
    for (const int block : {p.a, p.b}) {
      const Wrench& v = r->velocity[static_cast<std::size_t>(block)];
      largest = std::max(
          largest,
          norm(v.force + cross(v.moment, p.position - problem.blocks[static_cast<std::size_t>(block)].centre)));
    }
  }
  if (!(largest > 0.0)) return;
  for (Wrench& v : r->velocity) v.force *= 1.0 / largest, v.moment *= 1.0 / largest;
}

// Blocks out of balance when the sum of all residuals under dead loads is minimal.
std::vector<int> unheld_blocks(const LimitProblem& problem, const LimitSettings& settings) {
  const Programme programme(problem, settings);
  LinearProgram linear = programme.linear();
  linear.low[0] = linear.high[0] = 0.0, linear.cost[0] = 0.0;
  const int rows = linear.rows(), first = linear.columns();
  std::vector<int> block_of_row;
  for (std::size_t k = 0; k < problem.blocks.size(); ++k)
    for (int c = 0; !problem.blocks[k].fixed && c < 6; ++c) block_of_row.push_back(static_cast<int>(k));
  for (int r = 0; r < std::min(rows, static_cast<int>(block_of_row.size())); ++r) {
    for (const double sign : {1.0, -1.0}) {
      linear.add_column(-1.0, 0.0, kNoBound);
      linear.add(r, sign);
    }
  }
  const LinearSolution solution = solve(linear, false, settings.deadline);
  std::vector<int> unheld;
  for (std::size_t r = 0; r < block_of_row.size(); ++r) {
    const auto column = static_cast<std::size_t>(first) + 2 * r;
    if (solution.x[column] + solution.x[column + 1] > kResidual && (unheld.empty() || unheld.back() != block_of_row[r]))
      unheld.push_back(block_of_row[r]);
  }
  return unheld;
}

std::vector<int> loaded_blocks(const LimitProblem& problem) {
  std::vector<int> loaded;
  for (std::size_t k = 0; k < problem.blocks.size(); ++k) {
    const LimitBlock& b = problem.blocks[k];
    if (!b.fixed && norm(b.live.force) + norm(b.live.moment) > 0.0) loaded.push_back(static_cast<int>(k));
  }
  return loaded;
}

// A solution counts if the residuals of the programme confirm it.
LimitStatus status_of(const LinearSolution& solution, bool interior) {
  const bool confirmed =
      std::max(solution.primal_residual, solution.dual_residual) < (interior ? kInteriorResidual : kResidual);
  switch (solution.status) {
    case LinearStatus::solved:
      return confirmed ? LimitStatus::solved : LimitStatus::not_converged;
    case LinearStatus::infeasible:
      return LimitStatus::no_equilibrium;
    case LinearStatus::unbounded:
      return LimitStatus::unbounded;
    case LinearStatus::stopped:
      break;
  }
  return LimitStatus::not_converged;
}

// Reports every second that a solver is at work which reports nothing itself.
class ReportsMeanwhile {
 public:
  explicit ReportsMeanwhile(const LimitSettings& settings)
      : thread_([&settings, this](const std::stop_token& end) {
          std::unique_lock lock(mutex_);
          for (int seconds = 1;; ++seconds) {
            ends_.wait_for(lock, end, std::chrono::seconds(1), [] { return false; });
            if (end.stop_requested()) return;
            report(settings, seconds);
          }
        }) {}

 private:
  // What it throws, the next report from the thread of the analysis throws too.
  static void report(const LimitSettings& settings, int seconds) noexcept {
    try {
      settings.report(fmt::format("{} s", seconds));
    } catch (...) {
    }
  }

  std::mutex mutex_;
  std::condition_variable_any ends_;
  std::jthread thread_;
};

std::string of_facets(const LimitSettings& settings) { return fmt::format("pyramids of {} facets", settings.facets); }

LinearSolution solution_of(const LinearProgram& linear, const LimitProblem& problem, const LimitSettings& settings) {
  const ReportsMeanwhile reports(settings);
  if (settings.interior || problem.points.size() >= kManyPoints) {
    LinearSolution middle = solve(linear, true, settings.deadline);
    const bool exact = std::max(middle.primal_residual, middle.dual_residual) < kResidual &&
                       std::abs(middle.dual_objective - middle.objective) < kGap * std::max(1.0, middle.objective);
    if (settings.interior || (middle.status == LinearStatus::solved && exact)) return middle;
  }
  return solve(linear, false, settings.deadline);
}

}  // namespace

LimitSettings in_phase(LimitSettings settings, const std::string& phase) {
  if (settings.progress)
    settings.progress = [before = settings.progress, phase](const std::string& step) { before(phase + ": " + step); };
  return settings;
}

bool has_members(const LimitProblem& problem) {
  return std::ranges::any_of(problem.points, &LimitPoint::bar) ||
         std::ranges::any_of(problem.forces, [](const LimitForce& f) { return f.start.has_value(); });
}

LimitUnits units_of(const LimitProblem& problem) {
  constexpr double kFarBelow = 1e-4;
  double load = 0.0, live = 0.0, arm = 0.0, strength = problem.points.empty() ? 0.0 : kNoBound;
  // Fixed blocks may be far heavier than all others, whose residuals would then count for nothing.
  std::size_t free = 0;
  for (const LimitBlock& b : problem.blocks) {
    if (!b.fixed) load += norm(b.dead.force) + norm(b.live.force), live += norm(b.live.force), ++free;
  }
  for (const LimitPoint& p : problem.points) {
    strength = std::min(strength, p.tension + p.cohesion);
    arm += norm(p.position - problem.blocks[static_cast<std::size_t>(p.a)].centre);
  }
  load /= std::max(1.0, static_cast<double>(free)), live /= std::max(1.0, static_cast<double>(free));
  LimitUnits units;
  if (load > 0.0) units.force = load;
  if (load < kFarBelow * strength) units.force = strength;
  if (arm > 0.0) units.length = arm / static_cast<double>(problem.points.size());
  if (live > 0.0 && live < kFarBelow * units.force) units.multiplier = units.force / live;
  return units;
}

LimitResult limit_multiplier(const LimitProblem& problem, const LimitSettings& given) {
  require(problem, given);
  if (!given.near.empty() || (given.facets == 0 && !given.interior)) {
    LimitResult whole = limit_with_cones(problem, given);
    scale_mechanism(problem, &whole);
    if (whole.status != LimitStatus::not_converged || !given.near.empty()) return whole;
  }
  // Pyramids show that a problem has no solution, and solve those without room inside the cones.
  LimitSettings settings = given;
  if (settings.facets == 0) settings.facets = kFacets;
  const Programme programme(problem, settings);
  const LinearSolution solution = solution_of(programme.linear(), problem, in_phase(settings, of_facets(settings)));
  LimitResult result;
  if (solution.status == LinearStatus::solved) result = programme.result(solution);
  result.status = status_of(solution, settings.interior);
  if (result.status == LimitStatus::not_converged && settings.is_late()) result.status = LimitStatus::late;
  if (result.status != LimitStatus::late && programme.reaches(solution.objective))
    result.status = LimitStatus::unbounded;
  result.facets = settings.facets;
  scale_mechanism(problem, &result);
  if (result.status == LimitStatus::no_equilibrium) result.blocks_concerned = unheld_blocks(problem, settings);
  if (result.status == LimitStatus::unbounded) result.blocks_concerned = loaded_blocks(problem);
  return result;
}

void require_answer(const LimitResult& result) {
  if (result.status == LimitStatus::late)
    throw Error(
        Exit::numerical,
        "limit analysis: no answer within its time; give more (--seconds), or blocks with fewer zones, which have "
        "fewer contact points");
  if (result.status == LimitStatus::not_converged)
    throw Error(Exit::numerical,
                fmt::format("limit analysis: the solvers ended without a solution, as residuals are left; try {}other "
                            "zones of blocks, or run the scene with a stage of collapse",
                            result.facets > 0 ? "" : "pyramids (--facets 8), "));
}

std::vector<int> unconnected_blocks(const LimitProblem& problem, const std::vector<int>& supports) {
  std::vector<std::vector<int>> neighbours(problem.blocks.size());
  for (const LimitPoint& p : problem.points) {
    neighbours[static_cast<std::size_t>(p.a)].push_back(p.b);
    neighbours[static_cast<std::size_t>(p.b)].push_back(p.a);
  }
  for (const LimitForce& force : problem.forces) {
    for (std::size_t k = 1; k < force.places.size(); ++k) {
      const int a = force.places[k - 1].block, b = force.places[k].block;
      neighbours[static_cast<std::size_t>(a)].push_back(b), neighbours[static_cast<std::size_t>(b)].push_back(a);
    }
  }
  std::vector<bool> joined(problem.blocks.size(), false);
  std::vector<int> next = supports;
  for (const int block : supports) joined[static_cast<std::size_t>(block)] = true;
  for (std::size_t k = 0; k < joined.size(); ++k) {
    if (problem.blocks[k].fixed) next.push_back(static_cast<int>(k)), joined[k] = true;
  }
  while (!next.empty()) {
    const int block = next.back();
    next.pop_back();
    for (const int other : neighbours[static_cast<std::size_t>(block)]) {
      if (joined[static_cast<std::size_t>(other)]) continue;
      joined[static_cast<std::size_t>(other)] = true, next.push_back(other);
    }
  }
  std::vector<int> loose;
  for (std::size_t k = 0; k < joined.size(); ++k)
    if (!joined[k]) loose.push_back(static_cast<int>(k));
  return loose;
}

}  // namespace quoin
