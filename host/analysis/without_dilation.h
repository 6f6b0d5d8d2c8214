// Limit analysis without dilation: sliding does not open joints.
//
// Gilbert, Casapulla and Ahmed (2006): a sequence of associated problems. In each, the shear strength of a point
// follows from its normal force in the previous problem, and falls slightly with its current one. When they converge,
// forces obey Coulomb's friction and the mechanism slides without lifting. There may be several such states, since
// normal forces depend on the load path. So there are two starts, and the lower multiplier counts.
#pragma once

#include <string>
#include <vector>

#include "analysis/limit.h"

namespace quoin {

// Relative difference of two starts that is worth a notice. If one that has not settled is worse by more, the other
// does not count.
inline constexpr double kDoubt = 0.05;

// Result of the sequence from one start.
struct SettledLimit {
  std::string from;      // "weight": elastic forces under dead loads; "associated": those of the associated multiplier
  bool settled = false;  // whether it has converged; else the multiplier is that of the last problem
  double multiplier = 0.0;
  // Excess of shear forces over Coulomb's friction. beyond: the largest, over the mean normal force. share_beyond: the
  // sum, over the friction of sliding points.
  double beyond = 0.0, share_beyond = 0.0;
  double spread = 0.0;  // half of the range of the last multipliers over their mean, where the mean is the result
  int problems = 0;
};

struct LimitWithoutDilation {
  std::vector<SettledLimit> start;
  bool settled = false;     // from at least one start, where the other is not worse by more than 5 %
  double multiplier = 0.0;  // lowest of the settled ones
  double apart = 0.0;       // difference of two settled starts over the larger
  bool late = false;        // whether the deadline ended it before it settled
};

// The problem must have a multiplier by limit_multiplier().
LimitWithoutDilation limit_without_dilation(const LimitProblem& problem, const LimitSettings& settings = {});

// Smallest factor on friction with which forces carry the dead loads, from the same two starts. Shear strengths of each
// problem are that factor times friction times the previous normal forces. `multiplier` is the factor; the larger of
// the settled ones counts.
LimitWithoutDilation friction_without_dilation(const LimitProblem& problem, const LimitSettings& settings = {});

// Normal forces under dead loads of elastic joints without tensile strength, N, compression positive.
std::vector<double> elastic_normal_forces(const LimitProblem& problem);

}  // namespace quoin
