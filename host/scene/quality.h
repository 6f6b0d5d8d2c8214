// Accuracy of a run of a wall: named sets of settings with their measured error (benchmarks/README.md, program
// benchmarks/error_against_cost). A scene's own keys override them.
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
  // Expected errors against a converged run, as fractions: at least the largest error of the measured walls. They are
  // of the peak force, of the curve and of the work up to the end. That of the curve is the root mean square difference
  // over that of the force. A drop at another displacement counts with its full size. They apply to scenes within the
  // measured ranges (scene/measured.h).
  double peak_error = 0.0, curve_error = 0.0, work_error = 0.0;
};

const std::vector<Quality>& qualities();                // fast, standard, reference
const Quality& quality_named(const std::string& name);  // throws Error(bad_input): unknown name

}  // namespace quoin
