// Limit analysis with friction cones in place of pyramids, by an interior point method.
//
// After Lobo et al. (1998): a second-order cone programme, with Nesterov and Todd's scaling and Mehrotra's predictor
// and corrector as in Vandenberghe (2010). Each step solves only for the virtual velocities of the blocks. Its sparse
// matrix is that of springs at the contact points. Time grows little faster than the number of blocks.
#pragma once

#include "analysis/limit.h"

namespace quoin {

// Forces and mechanism are the analytic centre of all solutions. Friction may be negative. Problems without equilibrium
// or without a bound are not_converged. Of the settings near, most, progress and deadline count.
LimitResult limit_with_cones(const LimitProblem& problem, const LimitSettings& settings);

}  // namespace quoin
