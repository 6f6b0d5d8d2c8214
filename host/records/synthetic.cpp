#include "records/synthetic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <mutex>
#include <numbers>
#include <optional>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "base/error.h"
#include "random/counter.h"
#include "records/response_spectrum.h"

namespace quoin {
namespace {

constexpr double kShortestPeriod = 0.05, kLongestPeriod = 4.0;  // s; range in which the spectrum is fitted
constexpr std::size_t kFittedPeriods = 60;
constexpr int kCorrections = 30;  // number of corrections of the amplitudes; the misfit stops falling after about 20
constexpr double kMostSamples = 1e6;
constexpr double kRising = 0.1, kStrong = 0.5;  // shares of the duration

struct Ground {
  double soil, corner_b, corner_c, corner_d;  // S, T_B, T_C, T_D (s)
};
constexpr Ground kGround[2][5] = {
    {{1.0, 0.15, 0.4, 2.0}, {1.2, 0.15, 0.5, 2.0}, {1.15, 0.2, 0.6, 2.0}, {1.35, 0.2, 0.8, 2.0}, {1.4, 0.15, 0.5, 2.0}},
    {{1.0, 0.05, 0.25, 1.2},
     {1.35, 0.05, 0.25, 1.2},
     {1.5, 0.1, 0.25, 1.2},
     {1.8, 0.1, 0.3, 1.2},
     {1.6, 0.05, 0.25, 1.2}}};

double envelope(double share) {
  if (share < kRising) return share * share / (kRising * kRising);
  if (share < kRising + kStrong) return 1.0;
  return std::exp(-4.0 * (share - kRising - kStrong) / (1.0 - kRising - kStrong));
}

// Subtracts multiples of the envelope, constant and linear in time, so that velocity and displacement end at 0.
void end_at_rest(TimeSeries& series, const std::vector<double>& shape) {
  TimeSeries plain{series.time, shape}, sloped{series.time, shape};
  for (std::size_t i = 0; i < shape.size(); ++i) sloped.value[i] *= series.time[i] / series.time.back();
  const auto end_of = [](const TimeSeries& s) {
    const MotionHistory motion = integrate_acceleration(s);
    return std::pair(motion.velocity.back(), motion.displacement.back());
  };
  const auto [v1, u1] = end_of(plain);
  const auto [v2, u2] = end_of(sloped);
  const auto [v, u] = end_of(series);
  const double determinant = v1 * u2 - v2 * u1;
  const double p = (v * u2 - v2 * u) / determinant, q = (v1 * u - v * u1) / determinant;
  for (std::size_t i = 0; i < shape.size(); ++i) series.value[i] -= p * plain.value[i] + q * sloped.value[i];
}

// Factor of the amplitude at a period, interpolated between fitted periods, linear in the logarithm of the period.
double interpolated(const std::vector<double>& periods, const std::vector<double>& ratio, double period) {
  if (period <= periods.front()) return ratio.front();
  if (period >= periods.back()) return ratio.back();
  const auto i = static_cast<std::size_t>(std::upper_bound(periods.begin(), periods.end(), period) - periods.begin());
  const double f = std::log(period / periods[i - 1]) / std::log(periods[i] / periods[i - 1]);
  return ratio[i - 1] + f * (ratio[i] - ratio[i - 1]);
}

void require_settings(const SyntheticSettings& s) {
  if (!(s.duration >= 5.0) || !std::isfinite(s.duration))
    throw Error(Exit::bad_input, fmt::format("duration {} s of a synthetic record; allowed: 5 s or more", s.duration));
  if (!(s.time_step > 0.0 && s.time_step <= 0.02))
    throw Error(Exit::bad_input,
                fmt::format("time step {} s of a synthetic record; allowed: above 0, up to 0.02 s", s.time_step));
  if (s.duration / s.time_step > kMostSamples)
    throw Error(Exit::bad_input,
                fmt::format("{} samples of a synthetic record; allowed: up to 1e6", s.duration / s.time_step));
}

}  // namespace

double DesignSpectrum::acceleration(double period) const {
  if (!(ground_acceleration > 0.0) || !std::isfinite(ground_acceleration) || ground_type < 'A' || ground_type > 'E' ||
      type < 1 || type > 2 || !(damping >= 0.0 && damping < 1.0) || !(period >= 0.0))
    throw Error(
        Exit::bad_input,
        fmt::format(
            "design spectrum with a_g {} m/s2, ground '{}', type {}, damping {}, period {} s; allowed: a_g > 0, "
            "A to E, 1 or 2, 0 to 1, 0 or more",
            ground_acceleration, ground_type, type, damping, period));
  const Ground& g = kGround[type - 1][ground_type - 'A'];
  const double eta = std::max(0.55, std::sqrt(10.0 / (5.0 + 100.0 * damping)));
  const double plateau = ground_acceleration * g.soil * eta * 2.5;
  if (period < g.corner_b) return ground_acceleration * g.soil * (1.0 + period / g.corner_b * (2.5 * eta - 1.0));
  if (period <= g.corner_c) return plateau;
  if (period <= g.corner_d) return plateau * g.corner_c / period;
  return plateau * g.corner_c * g.corner_d / (period * period);
}

namespace {

SyntheticRecord make_record(const DesignSpectrum& target, const SyntheticSettings& settings) {
  const auto count = static_cast<std::size_t>(std::llround(settings.duration / settings.time_step)) + 1;
  std::size_t size = 1;
  while (size < count) size *= 2;
  const double frequency_step = 1.0 / (static_cast<double>(size) * settings.time_step);  // Hz

  TimeSeries series;
  std::vector<double> shape(count);
  for (std::size_t i = 0; i < count; ++i) {
    series.time.push_back(static_cast<double>(i) * settings.time_step);
    shape[i] = envelope(static_cast<double>(i) / static_cast<double>(count - 1));
  }
  std::vector<double> periods(kFittedPeriods), ratio(kFittedPeriods, 1.0);
  for (std::size_t i = 0; i < kFittedPeriods; ++i)
    periods[i] = kShortestPeriod * std::pow(kLongestPeriod / kShortestPeriod,
                                            static_cast<double>(i) / static_cast<double>(kFittedPeriods - 1));

  // Half a spectrum with random phases. Amplitudes begin at those of the pseudo-velocity, to which they are roughly
  // proportional.
  const random::Quantity phase_of{settings.seed, settings.number, random::name_of("ground motion phase")};
  std::vector<std::complex<double>> half(size / 2 + 1);
  for (std::size_t k = 1; k < size / 2; ++k) {
    const double period = 1.0 / (static_cast<double>(k) * frequency_step);
    if (period < 0.8 * kShortestPeriod || period > 1.5 * kLongestPeriod) continue;
    half[k] = std::polar(target.acceleration(period) * period, 2.0 * std::numbers::pi * random::uniform(phase_of, k));
  }
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> whole(size);
  std::vector<std::complex<double>> signal;
  SyntheticRecord best;
  double least_misfit = 1e300;
  for (int round = 0; round < kCorrections; ++round) {
    for (std::size_t k = 1; k < size / 2; ++k) {
      half[k] *= interpolated(periods, ratio, 1.0 / (static_cast<double>(k) * frequency_step));
      whole[k] = half[k], whole[size - k] = std::conj(half[k]);
    }
    fft.inv(signal, whole);
    series.value.resize(count);
    for (std::size_t i = 0; i < count; ++i) series.value[i] = shape[i] * signal[i].real();
    end_at_rest(series, shape);
    const std::vector<SpectralOrdinates> spectrum = response_spectrum(series, target.damping, periods);
    double mean = 0.0, misfit = 0.0, worst = 1e300;
    for (std::size_t i = 0; i < kFittedPeriods; ++i) {
      const double reached = spectrum[i].pseudo_acceleration / target.acceleration(periods[i]);
      ratio[i] = 1.0 / reached;
      mean += reached / static_cast<double>(kFittedPeriods);
      misfit += std::abs(reached - 1.0), worst = std::min(worst, reached);
    }
    if (misfit < least_misfit) {
      least_misfit = misfit;
      best.record.time = series.time;
      best.record.components = {{"acceleration", series.value}};
      best.mean_ratio = mean, best.worst_ratio = worst;
    }
  }
  best.record.source =
      fmt::format("synthetic, EN 1998-1 type {} ground {} a_g {} m/s2, {} s, seed {}, number {}", target.type,
                  target.ground_type, target.ground_acceleration, settings.duration, settings.seed, settings.number);
  return best;
}

}  // namespace

// A suite uses each record several times in a row: for its scene, its measures and each of its levels.
SyntheticRecord synthetic_record(const DesignSpectrum& target, const SyntheticSettings& settings) {
  require_settings(settings);
  struct Made {
    DesignSpectrum target;
    SyntheticSettings settings;
    SyntheticRecord record;
  };
  static std::mutex mutex;
  static std::optional<Made> last;
  const std::lock_guard lock(mutex);
  if (!last || last->target != target || last->settings != settings)
    last = Made{target, settings, make_record(target, settings)};
  return last->record;
}

}  // namespace quoin
