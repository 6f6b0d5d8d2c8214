// Durations as text, in a suitable unit with few digits.
#pragma once

#include <fmt/format.h>

#include <string>

namespace quoin {

// "0.25 s", "7.5 s", "95 s", "12 min", "3.4 h", "5.1 days", "1.16e+295 days".
inline std::string duration_text(double seconds) {
  constexpr double kMinute = 60.0, kHour = 3600.0, kDay = 86400.0;
  if (seconds < 2 * kMinute) return fmt::format("{:.{}f} s", seconds, seconds < 1.0 ? 2 : seconds < 10.0 ? 1 : 0);
  if (seconds < 2 * kHour) return fmt::format("{:.0f} min", seconds / kMinute);
  if (seconds < 2 * kDay) return fmt::format("{:.1f} h", seconds / kHour);
  const double days = seconds / kDay;
  return days < 1e5 ? fmt::format("{:.1f} days", days) : fmt::format("{:.3g} days", days);
}

}  // namespace quoin
