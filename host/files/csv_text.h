// Cells of CSV.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace quoin {

// A text cell, in quotes, on one line.
inline std::string csv_text(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"') result += '"';
    result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result + "\"";
}

// Shortest decimals that read back as the same double; empty where it is not finite.
inline std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

}  // namespace quoin
