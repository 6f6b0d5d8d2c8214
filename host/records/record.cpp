#include "records/record.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace quoin {
namespace {

// Derivative of samples at unequal times: slope at a sample of the parabola through it and its two neighbours.
std::vector<double> derivative(const std::vector<double>& t, const std::vector<double>& y) {
  const std::size_t n = y.size();
  std::vector<double> slope(n - 1), result(n);
  for (std::size_t i = 0; i + 1 < n; ++i) slope[i] = (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
  if (n == 2) return {slope[0], slope[0]};
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = t[i] - t[i - 1], after = t[i + 1] - t[i];
    result[i] = (after * slope[i - 1] + before * slope[i]) / (before + after);
  }
  result[0] = 2.0 * slope[0] - result[1];
  result[n - 1] = 2.0 * slope[n - 2] - result[n - 2];
  return result;
}

double largest_magnitude(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

// Time at which the increasing values `sum` reach `wanted`, linear within a step.
double time_of(const std::vector<double>& time, const std::vector<double>& sum, double wanted) {
  for (std::size_t i = 1; i < sum.size(); ++i) {
    if (sum[i] < wanted) continue;
    const double step = sum[i] - sum[i - 1];
    return time[i - 1] + (step > 0.0 ? (wanted - sum[i - 1]) / step : 0.0) * (time[i] - time[i - 1]);
  }
  return time.back();
}

}  // namespace

std::string recorded_units(const GroundRecord& record) {
  std::vector<std::string> units;
  for (const RecordComponent& component : record.components) {
    if (std::find(units.begin(), units.end(), component.unit) == units.end()) units.push_back(component.unit);
  }
  return fmt::format("{}", fmt::join(units, ", "));
}

MotionHistory integrate_acceleration(const TimeSeries& acceleration) {
  const auto& [time, a] = acceleration;
  MotionHistory motion{std::vector<double>(a.size(), 0.0), std::vector<double>(a.size(), 0.0)};
  for (std::size_t i = 1; i < a.size(); ++i) {
    const double h = time[i] - time[i - 1], v = motion.velocity[i - 1];
    motion.velocity[i] = v + 0.5 * h * (a[i - 1] + a[i]);
    motion.displacement[i] = motion.displacement[i - 1] + h * v + h * h * (2.0 * a[i - 1] + a[i]) / 6.0;
  }
  return motion;
}

TimeSeries accelerations_of_spline(const TimeSeries& displacement) {
  const std::vector<double>&t = displacement.time, &u = displacement.value;
  const std::size_t n = t.size();
  // Continuity of the velocity at each sample: h a_before/6 + (h + h') a/3 + h' a_after/6 = change of slope.
  std::vector<double> diagonal(n), above(n), right(n);
  const auto step = [&](std::size_t i) { return t[i + 1] - t[i]; };
  const auto slope = [&](std::size_t i) { return (u[i + 1] - u[i]) / step(i); };
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) diagonal[i] += step(i - 1) / 3.0, right[i] -= slope(i - 1);
    if (i + 1 < n) diagonal[i] += step(i) / 3.0, right[i] += slope(i), above[i] = step(i) / 6.0;
    if (i == 0) continue;
    const double factor = above[i - 1] / diagonal[i - 1];  // the matrix is symmetric
    diagonal[i] -= factor * above[i - 1], right[i] -= factor * right[i - 1];
  }
  TimeSeries acceleration{t, std::vector<double>(n)};
  for (std::size_t i = n; i-- > 0;)
    acceleration.value[i] = (right[i] - (i + 1 < n ? above[i] * acceleration.value[i + 1] : 0.0)) / diagonal[i];
  return acceleration;
}

TimeSeries acceleration_of(const GroundRecord& record, std::size_t component) {
  const std::vector<double>& value = record.components[component].value;
  switch (record.kind) {
    case MotionKind::acceleration:
      return {record.time, value};
    case MotionKind::velocity:
      return {record.time, derivative(record.time, value)};
    case MotionKind::displacement:
      return accelerations_of_spline({record.time, value});
  }
  return {};
}

RecordMeasures measure_record(const TimeSeries& acceleration) {
  const auto& [time, a] = acceleration;
  const MotionHistory motion = integrate_acceleration(acceleration);
  RecordMeasures m;
  m.pga = largest_magnitude(a);
  m.pgv = largest_magnitude(motion.velocity);
  m.pgd = largest_magnitude(motion.displacement);
  m.end_velocity = motion.velocity.back(), m.end_displacement = motion.displacement.back();

  std::vector<double> squares(a.size(), 0.0);  // integral of a^2, m2/s3
  for (std::size_t i = 1; i < a.size(); ++i) {
    const double h = time[i] - time[i - 1];
    squares[i] = squares[i - 1] + h * (a[i - 1] * a[i - 1] + a[i - 1] * a[i] + a[i] * a[i]) / 3.0;
    if (a[i - 1] * a[i] < 0.0) {  // the velocity has an extreme within the step
      const double turn = h * a[i - 1] / (a[i - 1] - a[i]);
      m.pgv = std::max(m.pgv, std::abs(motion.velocity[i - 1] + 0.5 * turn * a[i - 1]));
    }
  }
  m.arias = std::numbers::pi / (2.0 * kStandardGravity) * squares.back();
  if (squares.back() > 0.0)
    m.significant_duration =
        time_of(time, squares, 0.95 * squares.back()) - time_of(time, squares, 0.05 * squares.back());
  return m;
}

}  // namespace quoin
