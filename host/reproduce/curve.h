// A force-displacement curve of history.csv, and its characteristic values.
#pragma once

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/cyclic_motion.h"

namespace quoin::reproduce {

struct Curve {
  std::vector<int> stage;                             // from 1
  std::vector<int> half_cycle;                        // index in a stage of cycles, from 0; -1 in other stages
  std::vector<double> displacement, force, vertical;  // mm, kN, kN (compression positive)
  std::vector<double> unbalanced;                     // largest unbalanced force / mean contact force

  bool empty() const { return force.empty(); }
  std::size_t size() const { return force.size(); }
  std::size_t peak_row() const;  // row of the largest |force|
  double peak() const { return empty() ? 0.0 : std::abs(force[peak_row()]); }
  double peak_displacement() const { return empty() ? 0.0 : std::abs(displacement[peak_row()]); }
  double last_force() const { return empty() ? 0.0 : std::abs(force.back()); }
  double force_at(double displacement) const;  // kN, linear between rows of a monotonic curve
  // Displacement after the peak at which the force has fallen to `part` of it; negative: never.
  double displacement_after_peak(double part) const;
  // Root mean square of the difference of force and its running mean over `window` mm, from `from` to `to` mm, over the
  // peak.
  double roughness(double window, double from, double to) const;
  // Largest drop of the force below an earlier value, up to `to` mm, over the peak; 0 for a rising curve.
  double largest_fall(double to) const;
  double mean_unbalanced(double from, double to) const;
};

// Rows of the stages from first_stage, counted from 1. cycles: those of stage cycles_stage, if it has any. Throws
// Error(bad_input).
Curve read_history(const std::filesystem::path& file, int first_stage, const std::optional<Cycles>& cycles = {},
                   int cycles_stage = 0);

// CSV of several curves in long form: run, displacement_mm, force_kN, vertical_kN, unbalanced_ratio.
std::string curves_csv(const std::vector<std::pair<std::string, const Curve*>>& curves);

}  // namespace quoin::reproduce
