// How exact a run of a wall shall be: settings that go together, and their measured error (benchmarks/README.md,
// program benchmarks/error_against_cost). Keys that a scene gives itself win.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

struct Quality {
  std::string name;
  SolverSettings solver;
  double velocity = 0.0;           // velocity of the top beam in a shear stage, m/s
  double equilibrium_ratio = 0.0;  // ratio at the end of a pressure stage
  // Expected errors against a converged run, as fractions, at least the largest seen on the measured walls. Of the peak
  // force. Of the curve, root of the mean square of the difference over that of the force, where later drops count
  // whole. Of the work up to the end. Only for scenes within what was measured: scene/measured.h.
  double peak_error = 0.0, curve_error = 0.0, work_error = 0.0;
};

const std::vector<Quality>& qualities();                // fast, standard, reference
const Quality& quality_named(const std::string& name);  // throws Error(bad_input): unknown name

}  // namespace quoin
