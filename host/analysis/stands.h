// Stability of an assembly under dead loads, and the least friction that it needs.
//
// By associated flow, an assembly stands if any contact forces are in equilibrium and within strength. Without
// dilation, friction depends on which normal forces act. So that analysis follows two load paths (without_dilation.h).
#pragma once

#include <optional>
#include <vector>

#include "analysis/limit.h"
#include "analysis/without_dilation.h"

namespace quoin {

struct Stands {
  bool stands = false;
  double carried = 0.0;  // largest share of the dead loads that forces carry, at most 1
  // Smallest factor on the friction of all points with which forces carry the dead loads, to 0.1 %. None: no factor
  // suffices, or it was not requested.
  std::optional<double> friction;
  std::vector<int> out_of_balance;  // blocks of the mechanism where it does not stand
};

// Stability under dead loads; live loads are ignored. friction: whether to compute its smallest factor, which takes
// some ten programmes. Throws as limit_multiplier().
Stands stands(const LimitProblem& problem, const LimitSettings& settings = {}, bool friction = true);

// Multiplier of the dead loads, at most 1, with its forces; the mechanism is that of collapse.
LimitResult carried_share(const LimitProblem& problem, const LimitSettings& settings = {});

}  // namespace quoin
