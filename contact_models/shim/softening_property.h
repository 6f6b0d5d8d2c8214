// The properties of the softening function: its shape, and a table for shape "table". Not used during steps.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "shim/plugin.h"
#include "shim/softening_shape.h"

namespace quoin::shim {

inline constexpr const char* kShapes[] = {"linear", "exponential", "table"};
inline constexpr quoin_property_info kSoftening = {sizeof(quoin_property_info),
                                                   "softening",
                                                   "f",
                                                   "-",
                                                   "shape of the softening function, one for all modes",
                                                   QUOIN_PROPERTY_CHOICE,
                                                   0,
                                                   0.0,
                                                   0.0,
                                                   0.0,
                                                   nullptr,
                                                   "linear",
                                                   3,
                                                   kShapes};
inline constexpr quoin_property_info kTable = {
    sizeof(quoin_property_info),
    "softening_table",
    "f",
    "-",
    "pairs xi, f from 0, 1 to f = 0, xi rising and f falling strictly; for softening = table",
    QUOIN_PROPERTY_TABLE,
    0,
    0.0,
    -kInfinity,
    kInfinity,
    nullptr,
    nullptr,
    0,
    nullptr};
// Reads and checks the softening function and writes it to m. Returns false, with faults in report, for a table that
// cannot be used.
inline bool read_softening(const PropertyValues& values, SofteningShape& m, Report& report) {
  const std::string& shape = values.text("softening");
  const std::vector<double>& pairs = values.table("softening_table");
  if (shape != "table") {
    if (!pairs.empty())
      report.faults.push_back("softening_table: given, but softening = " + shape + "; set softening = table");
    if (shape == "exponential") {
      m.shape = Shape::exponential;
      m.A = 1.0, m.slope = 1.0, m.moment = std::exp(-1.0), m.end = kExponentialEnd;
    }
    return true;
  }
  m.shape = Shape::table;
  const auto refuse = [&](const std::string& why) {
    report.faults.push_back("softening_table: " + why +
                            "; needs xi, f pairs from 0, 1 to f = 0, xi rising and f falling strictly");
    return false;
  };
  const std::size_t n = pairs.size() / 2;
  if (pairs.size() % 2 != 0 || n < 2)
    return refuse(std::to_string(pairs.size()) + " numbers are not two or more pairs");
  if (n > static_cast<std::size_t>(SofteningTable::kMaxPoints)) {
    return refuse(std::to_string(n) + " points are more than " + std::to_string(SofteningTable::kMaxPoints));
  }
  if (pairs[0] != 0.0 || pairs[1] != 1.0) return refuse("starts at " + to_text(pairs[0]) + ", " + to_text(pairs[1]));
  SofteningTable& t = m.table;
  t.points = static_cast<int>(n);
  m.slope = m.moment = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    t.x[k] = pairs[2 * k];
    t.f[k] = pairs[2 * k + 1];
    if (k == 0) continue;
    if (!(t.x[k] > t.x[k - 1]) || !(t.f[k] < t.f[k - 1]) || !std::isfinite(t.x[k])) {
      return refuse("point " + std::to_string(k + 1) + " (" + to_text(t.x[k]) + ", " + to_text(t.f[k]) + ")");
    }
    t.area[k] = t.area[k - 1] + 0.5 * (t.f[k] + t.f[k - 1]) * (t.x[k] - t.x[k - 1]);
    const double fall = (t.f[k - 1] - t.f[k]) / (t.x[k] - t.x[k - 1]);
    m.slope = std::max(m.slope, fall);
    m.moment = std::max(m.moment, t.x[k] * fall);
  }
  if (t.f[n - 1] != 0.0) return refuse("ends at f = " + to_text(t.f[n - 1]));
  m.A = t.area[n - 1];
  m.end = t.x[n - 1];
  return true;
}

}  // namespace quoin::shim
