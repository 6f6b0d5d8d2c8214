// Assumptions of a run, checked when a row of the history is written.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "scene/scene.h"

namespace quoin {

// A violated assumption, reported once.
struct Warning {
  std::string about;  // key in summary.json (host/scenes/README.md)
  std::string text;   // what exceeds which bound, where, by how much, and what to do
  int stage = 0;
  long step = 0;
  double time = 0.0;  // s
};

// Findings of the checks so far.
struct Watch {
  static constexpr double kAllowedOverlap = 0.05;          // share of the least extent of a block
  static constexpr double kAllowedMissing = 0.05;          // share of the energy that is converted
  static constexpr double kAllowedTurn = 0.3;              // rad, of an end of a beam's piece from its chord
  static constexpr double kSlowRamp = 0.05;                // s; ramp of a pressure under which walls hardly vibrate
  static constexpr double kAllowedStiffness = 1.0 + 1e-6;  // ratio to the stiffness that the time step was chosen with
  // Least interval between two checks of energies (two consecutive steps), or of the flags of points; later a twentieth
  // of the steps so far. In these steps a law returns all of its outputs, at the cost of ten to twenty steps.
  static constexpr long kOutputSteps = 200;
  static long after(long step) { return step + std::max(kOutputSteps, step / 20); }
  static constexpr long kStiffnessSteps = 2000;  // least interval between two checks of tangents and of laws' answers
  // Least interval between two passes over all blocks and contact points. In a large model one costs as much as steps.
  static constexpr long kPassSteps = 100;

  double overlap = 0.0;      // largest closure of a contact point, elastic and crushed, m
  Vec3 overlap_at{};         // position of that point, m
  long crushed_out = 0;      // most contact points that are crushed out
  long falling = -1;         // block that falls fastest under damping, in the last pass; -1: none
  long crushing_before = 0;  // contact points that crush when a stage of pressure begins, as by [[damage]]

  // With output.energy of the balance of the whole run, else of the steps that are compared.
  double energy_missing = 0.0;  // energy that the balance lacks, J
  double energy_moved = 0.0;    // energy that was converted, J; 0: not checked yet
  // Largest tangent stiffness over the bound that its law states, from which the time step follows; 0: unknown.
  double stiffness_ratio = 0.0;

  long next_energies = 0, next_flags = 0, next_stiffness = 0, next_pass = 0;  // steps of the next checks
  std::uint64_t pending = 0;              // 1: the first of two steps has been measured
  double stored = 0.0, work_after = 0.0;  // of that step, J: all stored energy; work less damping in its second half
  double kinds[3] = {0.0, 0.0, 0.0};      // of that step, J: kinetic, strain, joints
};

}  // namespace quoin
