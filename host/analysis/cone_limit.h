// Limit analysis with whole friction cones in place of pyramids, by an interior point method of its own.
//
// Lobo et al. (1998): a second-order cone programme. Nesterov and Todd's scaling, Mehrotra's predictor and corrector,
// as Vandenberghe (2010) has them. A step solves for the virtual velocities of the blocks alone. Its sparse matrix is
// that of springs at the contact points. Time grows little faster than the number of blocks.
#pragma once

#include "analysis/limit.h"

namespace quoin {

// Forces and mechanism are the middle of all that the multiplier, up to `most`, allows. Friction may be below 0. Status
// is solved or not_converged: what has no equilibrium, or no bound, is the latter. problem: as limit_multiplier() takes
// it.
LimitResult limit_with_cones(const LimitProblem& problem, double most = std::numeric_limits<double>::infinity(),
                             const std::vector<double>& near = {});

}  // namespace quoin
