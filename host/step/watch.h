// Whether a run still is what it assumes to be, checked when a row of the history is written.
#pragma once

#include <algorithm>
#include <string>

#include "scene/scene.h"

namespace quoin {

// An assumption that a run has left, reported once.
struct Warning {
  std::string about;  // key in summary.json: energy_balance, interpenetration, crushed_out, small_displacements,
                      // time_step, law_states, damping, ground_motion, free_fall, collapse_multiplier
  std::string text;   // what exceeds which bound, where, by how much, and what to do
  int stage = 0;
  long step = 0;
  double time = 0.0;  // s
};

// What the checks have found so far.
struct Watch {
  static constexpr double kAllowedOverlap = 0.05;          // share of the least extent of a block
  static constexpr double kAllowedMissing = 0.05;          // share of the energy that is converted
  static constexpr double kAllowedStiffness = 1.0 + 1e-6;  // ratio to the stiffness that the time step was chosen with
  // Least interval between two checks of the energies of a step and the next, or of the flags of points. It is at least
  // a twentieth of the steps until then. A law then returns all that it can, which costs ten to twenty steps.
  static constexpr long kOutputSteps = 200;
  static long after(long step) { return step + std::max(kOutputSteps, step / 20); }
  static constexpr long kStiffnessSteps = 2000;  // between two checks of tangents and bounds of states, at least

  double overlap = 0.0;  // largest closure of a contact point, elastic and crushed, m
  Vec3 overlap_at{};     // reference position, m
  long crushed_out = 0;  // contact points, the most

  // With output.energy the balance of the whole run, else of the steps checked.
  double energy_missing = 0.0;   // energy that the balance lacks, J
  double energy_moved = 0.0;     // energy that was converted, J; 0: not checked yet
  double stiffness_ratio = 0.0;  // largest tangent over the law's bound, that the time step was chosen with; 0: unknown

  long next_energies = 0, next_flags = 0, next_stiffness = 0;  // steps
  bool pending = false;                                        // the first of two steps has been checked
  double stored = 0.0, work_after = 0.0;  // then: kinetic, strain, joints; external less damping of its second half
  double kinds[3] = {0.0, 0.0, 0.0};      // kinetic, strain, joints
};

}  // namespace quoin
