// Whether an assembly stands under given loads, and with how much friction at least.
//
// Any contact forces that are in equilibrium and within strength are enough for the associated answer. Without dilation
// it is not: which normal forces there are decides, so two ways that lead to them are followed (without_dilation.h).
#pragma once

#include <optional>
#include <vector>

#include "analysis/limit.h"
#include "analysis/without_dilation.h"

namespace quoin {

struct Stands {
  bool stands = false;
  double carried = 0.0;  // largest share of the dead loads that can be carried, up to 1
  // Smallest factor on the friction of all points with which dead loads are carried, to 0.1 %; none: no friction does,
  // or it was not sought.
  std::optional<double> friction;
  std::vector<int> out_of_balance;  // blocks, where it does not stand
};

// Of dead loads; live ones have no part. friction: its smallest factor is sought, by some ten programmes. Throws as
// limit_multiplier().
Stands stands(const LimitProblem& problem, const LimitSettings& settings = {}, bool friction = true);

// Multiplier of dead loads up to 1, with the forces that carry them; its mechanism is that of their fall.
LimitResult carried_share(const LimitProblem& problem, const LimitSettings& settings = {});

}  // namespace quoin
