#include "reproduce/curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "base/error.h"
#include "base/number_text.h"

namespace quoin::reproduce {

namespace {

// Cells of a CSV line, without the quotes around texts.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

}  // namespace

std::size_t Curve::peak_row() const {
  return static_cast<std::size_t>(
      std::max_element(force.begin(), force.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }) -
      force.begin());
}

double Curve::force_at(double at) const {
  for (std::size_t i = 1; i < size(); ++i) {
    if (displacement[i] < at || displacement[i] <= displacement[i - 1]) continue;
    const double t = std::clamp((at - displacement[i - 1]) / (displacement[i] - displacement[i - 1]), 0.0, 1.0);
    return force[i - 1] + t * (force[i] - force[i - 1]);
  }
  return empty() ? 0.0 : force.back();
}

double Curve::displacement_after_peak(double part) const {
  const double wanted = part * peak();
  for (std::size_t i = empty() ? 0 : peak_row(); i < size(); ++i) {
    if (std::abs(force[i]) <= wanted) return std::abs(displacement[i]);
  }
  return -1.0;
}

double Curve::roughness(double window, double from, double to) const {
  double sum = 0.0;
  long count = 0;
  std::size_t low = 0, high = 0;
  double inside = 0.0;
  for (std::size_t i = 0; i < size(); ++i) {
    while (high < size() && displacement[high] <= displacement[i] + window / 2) inside += force[high++];
    while (displacement[low] < displacement[i] - window / 2) inside -= force[low++];
    if (displacement[i] < from || displacement[i] > to) continue;
    const double off = force[i] - inside / static_cast<double>(high - low);
    sum += off * off;
    ++count;
  }
  return count > 0 && peak() > 0 ? std::sqrt(sum / static_cast<double>(count)) / peak() : 0.0;
}

double Curve::largest_fall(double to) const {
  double highest = 0.0, fall = 0.0;
  for (std::size_t i = 0; i < size() && displacement[i] <= to; ++i) {
    highest = std::max(highest, force[i]);
    fall = std::max(fall, highest - force[i]);
  }
  return peak() > 0 ? fall / peak() : 0.0;
}

double Curve::mean_unbalanced(double from, double to) const {
  double sum = 0.0;
  long count = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    if (displacement[i] < from || displacement[i] > to || !std::isfinite(unbalanced[i])) continue;
    sum += unbalanced[i];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

Curve read_history(const std::filesystem::path& file, int first_stage, const std::optional<Cycles>& cycles,
                   int cycles_stage) {
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line))
    throw Error(Exit::bad_input, file.string() + ": cannot be read; run the study again with --again");
  const std::vector<std::string> header = fields_of(line);
  auto column = [&](const char* name) {
    const auto found = std::find(header.begin(), header.end(), name);
    if (found == header.end()) throw Error(Exit::bad_input, fmt::format("{}: no column {}", file.string(), name));
    return static_cast<std::size_t>(found - header.begin());
  };
  const std::size_t stage = column("stage"), time = column("time_s"), displacement = column("displacement_m"),
                    horizontal = column("horizontal_force_N"), vertical = column("vertical_force_N"),
                    unbalanced = column("unbalanced_ratio");
  Curve curve;
  std::optional<CyclicMotion> motion;
  if (cycles) motion.emplace(*cycles);
  double start = -1.0;  // begin of the cycles, in whose first row one step has passed
  while (std::getline(stream, line)) {
    const std::vector<std::string> fields = fields_of(line);
    if (fields.size() < header.size()) continue;
    const auto number = [&]<typename Number>(std::size_t which, Number value) {
      if (!parse_number(fields[which], value))
        throw Error(Exit::bad_input, fmt::format("{}: {} '{}' is not a number; run the study again with --again",
                                                 file.string(), header[which], fields[which]));
      return value;
    };
    const int of_stage = number(stage, 0);
    if (of_stage < first_stage) continue;
    curve.stage.push_back(of_stage);
    const bool in_cycles = motion && of_stage == cycles_stage;
    if (in_cycles && start < 0.0) start = number(time, 0.0);
    curve.half_cycle.push_back(in_cycles ? motion->half_cycle(number(time, 0.0) - start) : -1);
    curve.displacement.push_back(1e3 * number(displacement, 0.0));
    curve.force.push_back(1e-3 * number(horizontal, 0.0));
    curve.vertical.push_back(1e-3 * number(vertical, 0.0));
    const bool loaded = !fields[unbalanced].empty();  // false before the first load
    curve.unbalanced.push_back(loaded ? number(unbalanced, 0.0) : HUGE_VAL);
  }
  return curve;
}

std::string curves_csv(const std::vector<std::pair<std::string, const Curve*>>& curves) {
  std::string csv = "run,displacement_mm,horizontal_force_kN,vertical_force_kN,unbalanced_ratio\n";
  for (const auto& [name, curve] : curves) {
    for (std::size_t i = 0; i < curve->size(); ++i)
      csv += fmt::format("\"{}\",{:.7g},{:.7g},{:.7g},{:.4g}\n", name, curve->displacement[i], curve->force[i],
                         curve->vertical[i], curve->unbalanced[i]);
  }
  return csv;
}

}  // namespace quoin::reproduce
