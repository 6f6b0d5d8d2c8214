// Loops of a cyclic test, with their characteristic values.
#pragma once

#include <string>
#include <vector>

#include "reproduce/curve.h"
#include "scene/cyclic_motion.h"

namespace quoin::reproduce {

// One cycle between two zero crossings in the same direction. mm, kN, J, kN/mm.
struct Loop {
  double amplitude = 0.0;                          // amplitude of the driven displacement
  int repetition = 0;                              // number of the cycle at this amplitude, from 0
  double largest = 0.0, lowest = 0.0;              // force
  double farthest = 0.0, back = 0.0;               // displacements at both ends
  double dissipated = 0.0;                         // area of the loop
  double stiffness = 0.0;                          // secant between both ends
  double residual_out = 0.0, residual_back = 0.0;  // displacements at which the force passes 0 after either end
  // E/(2 pi F d). F, d: means over both sides of the largest forces and displacements.
  double damping() const;
  double residual() const { return (residual_out - residual_back) / 2; }
};

// Loops of the complete cycles.
std::vector<Loop> loops_of(const Curve& curve, const Cycles& cycles);

// Largest force of the first cycle at each amplitude, over its displacement: first the negative side, then the positive
// one.
Curve envelope_of(const Curve& curve, const Cycles& cycles);

}  // namespace quoin::reproduce
