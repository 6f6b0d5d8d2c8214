#include "records/response_spectrum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "base/error.h"

namespace quoin {
namespace {

constexpr double kStepsPerPeriod = 100.0;  // at least

// A quantity at a time, and its rate.
struct Moment {
  double value, rate;
};

// Largest absolute value in a step after its beginning, of the cubic through both ends with their rates. Peaks lie
// between the ends where the rate changes its sign. Those of velocities and accelerations follow kinks of the record,
// and may be far from steps. The error of the cubic is of the fourth order in the step.
double largest_of_step(double step, const Moment& from, const Moment& to) {
  const double largest = std::abs(to.value);
  if (!(from.rate * to.rate < 0.0)) return largest;
  // value = from.value + s (slope + s (square + s cube)), s from 0 to 1.
  const double slope = step * from.rate, end_slope = step * to.rate, rise = to.value - from.value;
  const double square = 3.0 * rise - 2.0 * slope - end_slope, cube = slope + end_slope - 2.0 * rise;
  const double root = std::sqrt(square * square - 3.0 * cube * slope);
  const double s = std::abs(slope) / (root - std::copysign(square, slope * square));
  return std::max(largest, std::abs(from.value + s * (slope + s * (square + s * cube))));
}

// One oscillator. Its state after each step is exact for an acceleration that is linear in the step.
class Oscillator {
 public:
  Oscillator(double period, double damping)
      : w_(2.0 * std::numbers::pi / period), zeta_(damping), damped_(w_ * std::sqrt(1.0 - damping * damping)) {
    result_.period = period;
  }

  void advance(double step, double from, double to) {
    // Times of equal steps differ by rounding.
    constexpr double kSame = 1e-9;
    if (!(std::abs(step - step_) <= kSame * step)) find_gains(step);
    const auto after = [&](const Gains& g) { return g.of_u * u_ + g.of_v * v_ + (g.of_from * from + g.of_to * to); };
    const double u = after(displacement_), v = after(velocity_);
    const double before = -from - absolute(u_, v_), now = -to - absolute(u, v);  // relative accelerations
    const auto note = [step](double& largest, const Moment& begin, const Moment& end) {
      largest = std::max(largest, largest_of_step(step, begin, end));
    };
    // With a curvature of w^2 Sd + PGA the ends of steps miss at most (pi/100)^2/2 (1 + PGA/Sa) of a displacement.
    result_.displacement = std::max(result_.displacement, std::abs(u));
    note(result_.velocity, {v_, before}, {v, now});
    note(result_.absolute_acceleration, {absolute(u_, v_), absolute(v_, before)}, {absolute(u, v), absolute(v, now)});
    u_ = u, v_ = v;
  }

  // Advances in equal parts, short enough for the cubics.
  void advance_in_parts(double step, double from, double to) {
    const double parts = std::max(1.0, std::ceil(step * kStepsPerPeriod / result_.period));
    const double length = step / parts, rise = (to - from) / parts;
    for (double k = 0.0; k < parts; ++k) advance(length, from + rise * k, from + rise * (k + 1.0));
  }

  double period() const { return result_.period; }
  SpectralOrdinates ordinates() const {
    SpectralOrdinates result = result_;
    result.pseudo_velocity = w_ * result.displacement;
    result.pseudo_acceleration = w_ * w_ * result.displacement;
    return result;
  }

 private:
  // Factors of the state after a step: it is linear in the state before and in both accelerations.
  struct Gains {
    double of_u = 0.0, of_v = 0.0, of_from = 0.0, of_to = 0.0;
  };

  std::pair<double, double> after(double step, double u, double v, double from, double to) const {
    const double slope = (to - from) / step;
    const double b = -slope / (w_ * w_), a = (-from - 2.0 * zeta_ * w_ * b) / (w_ * w_);  // particular: a + b t
    const double c = u - a, d = (v - b + zeta_ * w_ * c) / damped_;
    const double decay = std::exp(-zeta_ * w_ * step), cosine = std::cos(damped_ * step),
                 sine = std::sin(damped_ * step);
    const double free = decay * (c * cosine + d * sine);
    return {free + a + b * step, -zeta_ * w_ * free + decay * damped_ * (d * cosine - c * sine) + b};
  }

  // Absolute acceleration, m/s2, with its sign reversed; of their rates, its rate.
  double absolute(double u, double v) const { return w_ * w_ * u + 2.0 * zeta_ * w_ * v; }

  void find_gains(double step) {
    step_ = step;
    std::tie(displacement_.of_u, velocity_.of_u) = after(step, 1.0, 0.0, 0.0, 0.0);
    std::tie(displacement_.of_v, velocity_.of_v) = after(step, 0.0, 1.0, 0.0, 0.0);
    std::tie(displacement_.of_from, velocity_.of_from) = after(step, 0.0, 0.0, 1.0, 0.0);
    std::tie(displacement_.of_to, velocity_.of_to) = after(step, 0.0, 0.0, 0.0, 1.0);
  }

  double w_, zeta_, damped_;
  double u_ = 0.0, v_ = 0.0;       // m, m/s
  double step_ = 0.0;              // s, last one
  Gains displacement_, velocity_;  // gains of a step
  SpectralOrdinates result_;
};

}  // namespace

std::vector<SpectralOrdinates> response_spectrum(const TimeSeries& acceleration, double damping,
                                                 std::span<const double> periods) {
  if (!(damping >= 0.0 && damping < 1.0))
    throw Error(Exit::bad_input, fmt::format("damping {} of a response spectrum; allowed: from 0 to below 1", damping));
  if (acceleration.time.size() < 2) throw Error(Exit::bad_input, "a response spectrum needs at least 2 samples");
  const auto& [time, a] = acceleration;
  std::vector<SpectralOrdinates> spectrum;
  std::vector<Oscillator> oscillators;
  for (const double period : periods) {
    constexpr double kMostPeriods = 1e7;  // of a record; its oscillator takes some seconds
    constexpr double kLongest = 1e5;      // records; the displacement is that of the ground long before
    const double duration = time.back() - time.front();
    const double shortest = duration / kMostPeriods, longest = duration * kLongest;
    if (!(period > 0.0 && period >= shortest && period <= longest))
      throw Error(Exit::bad_input, fmt::format("period {} s of a response spectrum; allowed for a record of {:g} s: "
                                               "from {:g} to {:g}",
                                               period, duration, shortest, longest));
    oscillators.emplace_back(period, damping);
  }
  // Sample by sample for all oscillators, so that their independent operations overlap in the processor.
  for (std::size_t i = 1; i < time.size(); ++i) {
    for (Oscillator& oscillator : oscillators) oscillator.advance_in_parts(time[i] - time[i - 1], a[i - 1], a[i]);
  }
  for (Oscillator& oscillator : oscillators) {
    oscillator.advance_in_parts(oscillator.period(), 0.0, 0.0);
    spectrum.push_back(oscillator.ordinates());
  }
  return spectrum;
}

std::vector<double> default_periods(std::size_t count) {
  constexpr double shortest = 0.02, longest = 5.0;  // s
  std::vector<double> periods(count);
  for (std::size_t i = 0; i < count; ++i)
    periods[i] = shortest * std::pow(longest / shortest, static_cast<double>(i) / static_cast<double>(count - 1));
  return periods;
}

}  // namespace quoin
