// Limit analysis without dilation: sliding does not lift.
//
// Gilbert, Casapulla and Ahmed (2006): associated problems one after the other. In each the shear strength of a point
// is that of the normal force of the last one, and sinks a little with its own. Where they settle, forces are within
// Coulomb's friction and the mechanism slides without lifting. There may be several such states, for normal forces
// depend on the way that led to them: two starts, of which the lower multiplier counts.
#pragma once

#include <string>
#include <vector>

#include "analysis/limit.h"

namespace quoin {

struct SettledLimit {
  std::string from;      // "weight": elastic forces under dead loads; "associated": those of the associated multiplier
  bool settled = false;  // else the multiplier is that of the last problem
  double multiplier = 0.0;
  // Shear forces beyond Coulomb's friction: the largest, of the mean normal force; all, of the friction of points that
  // slide.
  double beyond = 0.0, share_beyond = 0.0;
  double spread = 0.0;  // half of the range of the last multipliers over their mean, where that is what has settled
  int problems = 0;
};

struct LimitWithoutDilation {
  std::vector<SettledLimit> start;
  bool settled = false;     // from some start, and the other is no worse by more than 5 %
  double multiplier = 0.0;  // the lowest of those that settled
};

// The problem must be one for which limit_multiplier() finds a multiplier.
LimitWithoutDilation limit_without_dilation(const LimitProblem& problem, const LimitSettings& settings = {});

// Smallest factor on friction with which dead loads are carried, from the same two starts. Shear strengths of each
// problem are that factor times friction times the normal forces of the last one. `multiplier` is the factor; the
// larger one of those that settle counts.
LimitWithoutDilation friction_without_dilation(const LimitProblem& problem, const LimitSettings& settings = {});

// Normal forces under dead loads of joints that are elastic and take no tension, compression positive, N.
std::vector<double> elastic_normal_forces(const LimitProblem& problem);

}  // namespace quoin
