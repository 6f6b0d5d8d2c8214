// A missing number of a study: NaN in memory, null in JSON.
#pragma once

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace quoin::ensemble {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

inline nlohmann::ordered_json number_or_null(double v) {
  return std::isfinite(v) ? nlohmann::ordered_json(v) : nullptr;
}

}  // namespace quoin::ensemble
