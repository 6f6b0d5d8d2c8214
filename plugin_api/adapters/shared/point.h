// One contact point and step, for programs that call a law point by point.
#pragma once

#include <cstdint>

#include "shared/material.h"

namespace quoin::adapters {

constexpr std::uint64_t max_states = 32;

// In the convention of the contract: tension and opening positive, traction in Pa, slip over the step. Old and new may
// be the same memory.
struct PointStep {
  double normal_jump = 0.0;
  double slip[2] = {0.0, 0.0};
  const double* traction_old = nullptr;  // 3
  const double* state_old = nullptr;     // state_count
  double* traction_new = nullptr;
  double* state_new = nullptr;
  double* energy_stored = nullptr;  // null: not wanted
  double* dissipated = nullptr;     // QUOIN_DISSIPATED_COUNT, null: not wanted
  double* tangent = nullptr;        // 9, row by row, null: not wanted
  std::uint32_t flags = 0;          // out
};

// Returns the status of the point (QUOIN_POINT_...). Throws std::runtime_error when the law refuses the call.
std::uint32_t evaluate(const Material& material, PointStep& step);

}  // namespace quoin::adapters
