#include "analysis/stands.h"

#include <fmt/format.h>

#include <algorithm>

namespace quoin {
namespace {

// Share of the dead loads that counts as all of them, within rounding of the linear programme.
constexpr double kAll = 1.0 - 1e-6;
// Bound of the multiple of the dead loads that is sought. At a bound of 1, a multiplier may end short of it
// by the tolerance of whole cones, 1e-5.
constexpr double kMostCarried = 2.0;
// Accuracy of a factor on friction, and its largest value.
constexpr double kExact = 1e-3, kMostFriction = 64.0;

bool carried_with(LimitProblem problem, const LimitSettings& settings, double factor) {
  for (LimitPoint& p : problem.points) {
    // Cohesion over friction limits tension. Less friction must not raise that limit.
    if (p.friction > 0.0) p.tension = std::min(p.tension, p.cohesion / p.friction);
    p.friction *= factor;
  }
  const LimitResult result = carried_share(problem, in_phase(settings, fmt::format("friction times {:.4g}", factor)));
  if (result.status == LimitStatus::late) require_answer(result);
  return result.status == LimitStatus::solved && result.multiplier >= kAll;
}

// Bisection, as an assembly that stands with some friction stands with more. A wider cone contains the narrower one,
// except under tension, where cohesion is left.
std::optional<double> smallest_friction(const LimitProblem& problem, const LimitSettings& settings, bool stands) {
  double holds = stands ? 1.0 : kMostFriction, falls = stands ? 0.0 : 1.0;
  if (!stands && !carried_with(problem, settings, holds)) return std::nullopt;
  if (stands && carried_with(problem, settings, 0.0)) return 0.0;
  while (holds - falls > kExact * holds) {
    const double middle = 0.5 * (holds + falls);
    (carried_with(problem, settings, middle) ? holds : falls) = middle;
  }
  return holds;
}

}  // namespace

LimitResult carried_share(const LimitProblem& problem, const LimitSettings& settings) {
  LimitProblem loaded = problem;
  for (LimitBlock& b : loaded.blocks) b.live = b.dead, b.dead = {};
  LimitSettings up_to_all = settings;
  up_to_all.most = kMostCarried;
  LimitResult result = limit_multiplier(loaded, up_to_all);
  const double share = 1.0 / std::max(1.0, result.multiplier);
  for (auto& force : result.force)
    for (double& component : force) component *= share;
  for (double& force : result.member_force) force *= share;
  result.multiplier *= share;
  return result;
}

Stands stands(const LimitProblem& problem, const LimitSettings& settings, bool friction) {
  const bool loaded = std::any_of(problem.blocks.begin(), problem.blocks.end(), [](const LimitBlock& b) {
    return !b.fixed && norm(b.dead.force) + norm(b.dead.moment) > 0.0;
  });
  if (!loaded) return {true, 1.0, 0.0, {}};
  // A single programme suffices for joints that only press. Not with cohesion, of which tension takes friction's share.
  const bool cohesive =
      std::any_of(problem.points.begin(), problem.points.end(), [](const LimitPoint& p) { return p.cohesion > 0.0; });
  if (!cohesive && carried_with(problem, settings, 0.0)) return {true, 1.0, 0.0, {}};
  const LimitResult result = carried_share(problem, settings);
  require_answer(result);
  Stands answer;
  answer.carried = result.status == LimitStatus::solved ? std::max(result.multiplier, 0.0) : 0.0;
  answer.stands = answer.carried >= kAll;
  if (friction) answer.friction = smallest_friction(problem, settings, answer.stands);
  for (std::size_t k = 0; !answer.stands && k < result.velocity.size(); ++k) {
    constexpr double kMoves = 1e-4;  // share of the largest velocity
    if (norm(result.velocity[k].force) + norm(result.velocity[k].moment) > kMoves)
      answer.out_of_balance.push_back(static_cast<int>(k));
  }
  return answer;
}

}  // namespace quoin
