#include "analysis/without_dilation.h"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <numeric>
#include <utility>

#include "analysis/stands.h"
#include "base/index.h"

namespace quoin {
namespace {

using geometry::Vector;

// After Gilbert: slope of strength over the normal force, as a share of friction. And the share of its change by which
// the assumed normal force follows each problem. With members the slope is 0: with one, what slides sinks, and strains
// the members across it. These would then carry the weight in place of the joint.
constexpr double kSlope = 0.1, kFollow = 0.5, kFollowPyramids = 0.3;
// Number of problems after which that share falls, as for a mean of all problems. Otherwise large assemblies run into
// cycles.
constexpr double kMeanFrom = 10.0;
// Convergence. The multiplier changes by a smaller share, and the excess of shear over Coulomb's friction is small. The
// latter holds at each point, over the mean normal force, or for the sum, over the friction of sliding points. In large
// assemblies some nearly unloaded point changes state in any problem. Where little slides, the sum has no meaning. The
// remaining change shrinks by 1 - kFollow a problem, so 0.1 % of the multiplier is still to come.
constexpr double kSteady = 1e-3, kBeyond = 0.05, kShareBeyond = 0.02;
constexpr double kSliding = 0.99;  // share of its strength from which on a point counts as sliding
constexpr double kJump = 0.2;      // relative rise of the multiplier that is a jump, from a state within friction
constexpr int kSteadyFor = 3, kMostProblems = 60;
// Large assemblies converge no further. If the multiplier stays in this range over so many problems, with shear beyond
// friction below this bound, then the mean is the result. Half of the range is reported.
constexpr int kWanderFor = 10;
constexpr double kWander = 0.005, kWanderBeyond = 0.1;
// Factor on friction below which changes are relative to this value, so that a factor of 0 converges.
constexpr double kNoFriction = 0.01;
// Normal force over the mean one, below which a point has no friction. The strength of such a point has no slope, as
// with one it could take no normal force.
constexpr double kUnloaded = 1e-4, kUnloadedPyramids = 1e-6;
// Contact points up to which pyramids are tried where cones have not converged: a second a problem.
constexpr std::size_t kFewPoints = 2000;
// Shear stiffness of joints over their normal stiffness: masonry with a Poisson's ratio of 0.25.
constexpr double kShearStiffness = 0.4;

struct Row {
  std::array<int, 12> unknown;
  std::array<double, 12> value;
};
// Opening of a point along an axis as a function of the motions of both blocks.
Row row_of(const LimitProblem& problem, const LimitPoint& p, const Vector& axis) {
  Row row{};
  std::size_t k = 0;
  for (const auto& [block, sign] : {std::pair(p.a, -1.0), std::pair(p.b, 1.0)}) {
    const Vector moment = cross(p.position - problem.blocks[at(block)].centre, axis);
    for (int c = 0; c < 3; ++c, ++k) row.unknown[k] = 6 * block + c, row.value[k] = sign * axis[c];
    for (int c = 0; c < 3; ++c, ++k) row.unknown[k] = 6 * block + 3 + c, row.value[k] = sign * moment[c];
  }
  return row;
}

// Stiffness of members over that of a mean contact point: they carry what joints cannot.
constexpr double kMemberStiffness = 1e-3;

// Generalised forces of a unit of a member's force: unknowns of blocks, and components.
std::vector<std::pair<int, double>> row_of(const LimitProblem& problem, const LimitForce& force) {
  std::vector<std::pair<int, double>> row;
  for (const LimitForce::Place& place : force.places) {
    const Vector moment = place.turn + cross(place.at - problem.blocks[at(place.block)].centre, place.way);
    for (int c = 0; c < 3; ++c) row.emplace_back(6 * place.block + c, place.way[c]);
    for (int c = 0; c < 3; ++c) row.emplace_back(6 * place.block + 3 + c, moment[c]);
  }
  return row;
}

// Members are always taut, as this solution only starts the sequence.
void add_force(const LimitProblem& problem, const LimitForce& force, std::vector<Eigen::Triplet<double>>& entries) {
  const std::vector<std::pair<int, double>> row = row_of(problem, force);
  for (const auto& [i, a] : row)
    for (const auto& [j, b] : row) entries.emplace_back(i, j, (force.start ? kMemberStiffness : 1.0) * a * b);
}

Eigen::SparseMatrix<double> stiffness_of(const LimitProblem& problem, const std::vector<bool>& closed,
                                         double mean_area) {
  // Stiffness that holds blocks without contact, too weak to carry loads.
  constexpr double kHeld = 1e-7, kFixed = 1e9;
  std::vector<Eigen::Triplet<double>> entries;
  const auto blocks = static_cast<int>(problem.blocks.size());
  for (int i = 0; i < 6 * blocks; ++i) entries.emplace_back(i, i, problem.blocks[at(i / 6)].fixed ? kFixed : kHeld);
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    const LimitPoint& p = problem.points[i];
    if (!closed[i]) continue;
    for (const auto& [axis, factor] :
         {std::pair(p.n, 1.0), std::pair(p.s, kShearStiffness), std::pair(p.t, kShearStiffness)}) {
      const Row row = row_of(problem, p, axis);
      const double k = factor * (p.bar ? kMemberStiffness : p.area / mean_area);
      for (std::size_t a = 0; a < 12; ++a)
        for (std::size_t b = 0; b < 12; ++b)
          entries.emplace_back(row.unknown[a], row.unknown[b], k * row.value[a] * row.value[b]);
    }
  }
  for (const LimitForce& force : problem.forces) add_force(problem, force, entries);
  Eigen::SparseMatrix<double> stiffness(6 * blocks, 6 * blocks);
  stiffness.setFromTriplets(entries.begin(), entries.end());
  return stiffness;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v / static_cast<double>(values.size());
  return sum;
}

// The problem with the shear strengths of given normal forces. Where friction is sought, the multiplier is minus a
// factor on it: shear strengths are proportional to it, loads are constant. factor: the last one found, else 1.
LimitProblem frozen(const LimitProblem& problem, const std::vector<double>& normal, bool of_friction, double factor,
                    bool cones) {
  LimitProblem next = problem;
  const double of_loaded = has_members(problem) ? 0.0 : kSlope;
  const double unloaded = (cones ? kUnloaded : kUnloadedPyramids) * mean_of(normal);
  for (LimitBlock& b : next.blocks)
    if (of_friction) b.live = {};
  for (std::size_t i = 0; i < normal.size(); ++i) {
    LimitPoint& p = next.points[i];
    const double slope = normal[i] > unloaded ? of_loaded : 0.0, friction = p.friction;
    if (friction > 0.0) p.tension = std::min(p.tension, p.cohesion / friction);
    const double strength = normal[i] > unloaded || !cones ? (1.0 + slope) * friction * std::max(0.0, normal[i]) : 0.0;
    of_friction ? p.live_cohesion -= strength : p.cohesion += strength;
    p.friction = -slope * friction * factor;
  }
  return next;
}

void measure_beyond_friction(const LimitProblem& problem, const LimitResult& result, double mean, double factor,
                             SettledLimit* now) {
  double most = 0.0, sum = 0.0, friction = 0.0;
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    const LimitPoint& p = problem.points[i];
    const auto& [n, s, t] = result.force[i];
    const double strength = p.cohesion - factor * p.friction * n, shear = std::hypot(s, t);
    if (shear < kSliding * strength) continue;
    most = std::max(most, shear - strength);
    sum += std::max(0.0, shear - strength), friction += std::max(0.0, strength);
  }
  now->beyond = mean > 0.0 ? most / mean : most;
  now->share_beyond = friction > 0.0 ? sum / friction : sum > 0.0 ? std::numeric_limits<double>::max() : 0.0;
}

enum class Sought { multiplier, friction };

// Ends the sequence where the last multipliers lie within a small range.
bool wanders(const std::vector<double>& multipliers, SettledLimit* now) {
  if (multipliers.size() < kWanderFor || now->share_beyond > kWanderBeyond) return false;
  const auto first = multipliers.end() - kWanderFor;
  const auto [low, high] = std::minmax_element(first, multipliers.end());
  const double mean = std::accumulate(first, multipliers.end(), 0.0) / kWanderFor;
  if (!(*high - *low <= kWander * std::abs(mean))) return false;
  now->settled = true, now->multiplier = mean, now->spread = 0.5 * (*high - *low) / std::abs(mean);
  return true;
}

// cones: with whole cones and forces nearest to the previous ones, which is far faster; else with pyramids, at the
// centre.
SettledLimit settle(const LimitProblem& problem, const LimitSettings& given, Sought sought, std::vector<double> normal,
                    const std::string& from, bool cones) {
  const bool of_friction = sought == Sought::friction;
  LimitSettings settings = given;
  settings.interior = true;
  if (settings.facets == 0) settings.facets = kFacets;
  if (of_friction) settings.most = 0.0;
  const double mean = mean_of(normal);
  std::vector<double> solved;  // last normal forces whose problem has a solution
  SettledLimit now{from};
  std::vector<double> multipliers;
  int steady = 0;
  double factor = 1.0;
  while (now.problems < kMostProblems && !settings.is_late()) {
    if (cones) settings.near = normal;
    ++now.problems;
    const LimitResult result =
        limit_multiplier(frozen(problem, normal, of_friction, factor, cones),
                         in_phase(settings, fmt::format("from {}, problem {}", from, now.problems)));
    // The change was too large: go halfway back. A nearly settled state may jump to another when points lose their
    // load.
    const bool jumps = !of_friction && now.problems > 1 && now.beyond <= kBeyond &&
                       result.multiplier - now.multiplier > kJump * std::abs(now.multiplier);
    if (result.status != LimitStatus::solved || jumps) {
      if (solved.empty()) return now;
      for (std::size_t i = 0; i < normal.size(); ++i) normal[i] = 0.5 * (normal[i] + solved[i]);
      steady = 0;
      continue;
    }
    const double found = of_friction ? std::max(0.0, -result.multiplier) : result.multiplier;
    const double change = std::abs(found - now.multiplier);
    now.multiplier = found, multipliers.push_back(found), factor = of_friction ? found : 1.0;
    measure_beyond_friction(problem, result, mean, factor, &now);
    steady = change <= kSteady * std::max(std::abs(found), of_friction ? kNoFriction : 0.0) ? steady + 1 : 0;
    now.settled = steady >= kSteadyFor && (now.beyond <= kBeyond || now.share_beyond <= kShareBeyond);
    if (now.settled || wanders(multipliers, &now)) return now;
    solved = normal;
    const double follow = cones ? kFollow * std::min(1.0, kMeanFrom / now.problems) : kFollowPyramids;
    for (std::size_t i = 0; i < normal.size(); ++i)
      normal[i] += follow * ((problem.points[i].bar ? 0.0 : -result.force[i][0]) - normal[i]);
  }
  return now;
}

// Whole cones give the centre by themselves.
LimitSettings middle_of(LimitSettings settings) {
  settings.interior = settings.facets != 0;
  return settings;
}

LimitWithoutDilation from_two_starts(const LimitProblem& problem, const LimitSettings& settings, Sought sought,
                                     const LimitResult& associated) {
  LimitWithoutDilation result;
  const auto with_cones = [&](const std::vector<double>& normal, const char* from) {
    return settle(problem, settings, sought, normal, from, true);
  };
  const std::vector<double> of_weight = elastic_normal_forces(problem);
  std::vector<double> of_associated;
  for (const auto& force : associated.force) of_associated.push_back(std::max(0.0, -force[0]));
  // In parallel, as the starts are independent.
  auto other = std::async(associated.status == LimitStatus::solved ? std::launch::async : std::launch::deferred,
                          with_cones, of_associated, "associated");
  result.start.push_back(with_cones(of_weight, "weight"));
  if (associated.status == LimitStatus::solved) result.start.push_back(other.get());
  for (SettledLimit& start : result.start) {
    // The middle of the set says nothing of the forces of members.
    if (start.settled || has_members(problem) || problem.points.size() >= kFewPoints || settings.is_late()) continue;
    start = settle(problem, settings, sought, start.from == "weight" ? of_weight : of_associated, start.from, false);
  }
  for (const SettledLimit& start : result.start) {
    if (!start.settled) continue;
    const bool worse =
        sought == Sought::friction ? start.multiplier > result.multiplier : start.multiplier < result.multiplier;
    if (result.settled && !worse) continue;
    result.settled = true, result.multiplier = start.multiplier;
  }
  for (const SettledLimit& start : result.start) {
    const double above = start.multiplier - result.multiplier, doubt = kDoubt * std::abs(result.multiplier);
    const bool worse = sought == Sought::friction ? above > doubt : above < -doubt;
    if (!start.settled && worse) result.settled = false;
  }
  if (result.settled && std::ranges::all_of(result.start, &SettledLimit::settled)) {
    const auto [low, high] = std::ranges::minmax(result.start, {}, &SettledLimit::multiplier);
    result.apart = (high.multiplier - low.multiplier) /
                   std::max({std::abs(low.multiplier), std::abs(high.multiplier), kNoFriction});
  }
  result.late = !result.settled && settings.is_late();
  return result;
}

}  // namespace

std::vector<double> elastic_normal_forces(const LimitProblem& problem) {
  constexpr int kMostTrials = 50;
  const auto count = static_cast<Eigen::Index>(6 * problem.blocks.size());
  Eigen::VectorXd loads = Eigen::VectorXd::Zero(count);
  for (std::size_t k = 0; k < problem.blocks.size(); ++k) {
    const LimitBlock& b = problem.blocks[k];
    for (int c = 0; c < 3 && !b.fixed; ++c) {
      loads(static_cast<Eigen::Index>(6 * k) + c) = b.dead.force[c];
      loads(static_cast<Eigen::Index>(6 * k) + 3 + c) = b.dead.moment[c];
    }
  }
  for (const LimitForce& force : problem.forces) {
    for (const auto& [i, share] : row_of(problem, force)) loads(i) += force.start.value_or(0.0) * share;
  }
  double mean_area = 0.0;
  for (const LimitPoint& p : problem.points) mean_area += p.area / static_cast<double>(problem.points.size());
  std::vector<bool> closed(problem.points.size(), true);
  std::vector<double> normal(problem.points.size(), 0.0);
  for (int trial = 0; trial < kMostTrials; ++trial) {
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(stiffness_of(problem, closed, mean_area));
    const Eigen::VectorXd moved = factor.solve(loads);
    bool changed = false;
    for (std::size_t i = 0; i < problem.points.size(); ++i) {
      const LimitPoint& p = problem.points[i];
      const Row row = row_of(problem, p, p.n);
      double opening = 0.0;
      for (std::size_t k = 0; k < 12; ++k) opening += row.value[k] * moved(row.unknown[k]);
      const bool now_closed = p.bar || opening <= 0.0;
      changed = changed || now_closed != closed[i];
      closed[i] = now_closed;
      normal[i] = p.bar ? 0.0 : std::max(0.0, -opening * p.area / mean_area);
    }
    if (!changed) break;
  }
  return normal;
}

LimitWithoutDilation limit_without_dilation(const LimitProblem& problem, const LimitSettings& settings) {
  return from_two_starts(problem, settings, Sought::multiplier, limit_multiplier(problem, middle_of(settings)));
}

LimitWithoutDilation friction_without_dilation(const LimitProblem& problem, const LimitSettings& settings) {
  return from_two_starts(problem, settings, Sought::friction, carried_share(problem, middle_of(settings)));
}

}  // namespace quoin
