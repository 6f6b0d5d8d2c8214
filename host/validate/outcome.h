// Outcome of a run of a wall test: peak, drifts, stiffness, failure mode.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "reproduce/loops.h"
#include "reproduce/study.h"
#include "validate/wall_scene.h"

namespace quoin::validate {

// Components of the displacement of the top at the end of a run, from cracks and slips.
struct Motion {
  double spread = 0.0;   // m; horizontal opening of head joints and units, median of the courses: a diagonal crack
  double sliding = 0.0;  // m; least slip along the bed joint with the largest such slip
  double crushed = 0.0;  // share of the length of the worst bed joint that is crushed
  double top = 0.0;      // m
  double kept = 1.0;     // force at the end over the peak
};

struct Outcome {
  reproduce::RunResult run;
  double peak = 0.0;                                          // kN; of cycles the mean of both sides
  double drift_at_peak = 0.0;                                 // %
  std::optional<double> ultimate_drift;                       // % at 20 % loss; nothing: no such loss
  double initial_stiffness = 0.0, effective_stiffness = 0.0;  // kN/mm to 10 %, and secant to 70 % of the peak
  // Predicted over measured force at 1, 2, ... 10 mm, least and largest; nothing without an envelope.
  std::optional<std::array<double, 2>> along_envelope;
  std::string mode;  // code of brick_walls.csv
  Motion motion;
  // First cycles of each amplitude, of the driven point: energies in J.
  std::vector<reproduce::Loop> loops;
};

double peak_of(const reproduce::RunResult& run);  // kN; of cycles the mean of both sides

// Code of the failure mode from the components of motion: S diagonal, F rocking, SL sliding, H- hybrids with the larger
// one first.
std::string mode_of(const Motion& motion);
// Leading mode of a code: S, F, SL or G; of a hybrid the first letter after H-.
std::string leading_mode(const std::string& code);

Motion read_motion(const std::filesystem::path& run_folder, double top_displacement);
Outcome outcome_of(const WallRow& row, const TestScene& scene, reproduce::RunResult run);

}  // namespace quoin::validate
