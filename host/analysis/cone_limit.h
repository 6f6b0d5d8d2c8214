// Limit analysis with friction cones in place of pyramids, by an interior point method.
//
// After Lobo et al. (1998): a second-order cone programme, with Nesterov and Todd's scaling and Mehrotra's predictor
// and corrector as in Vandenberghe (2010). Each step solves only for the virtual velocities of the blocks. Its sparse
// matrix is that of springs at the contact points. Time grows little faster than the number of blocks.
#pragma once

#include "analysis/limit.h"

namespace quoin {

// Forces and mechanism are the analytic centre of all solutions, for a multiplier of at most `most`. Friction may be
// negative. Status is solved or not_converged; problems without equilibrium or without a bound are not_converged.
// problem: as in limit_multiplier(). near: as in LimitSettings.
LimitResult limit_with_cones(const LimitProblem& problem, double most = std::numeric_limits<double>::infinity(),
                             const std::vector<double>& near = {});

}  // namespace quoin
