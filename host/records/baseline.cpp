#include "records/baseline.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/error.h"

namespace quoin {
namespace {

TimeSeries less_polynomial(const TimeSeries& series, int order) {
  const auto n = static_cast<Eigen::Index>(series.time.size());
  if (n <= order)
    throw Error(Exit::bad_input, fmt::format("a baseline of order {} needs more than {} samples", order, n));
  // Legendre polynomials on [-1, 1]: powers of the time would lose all digits at order 10.
  Eigen::MatrixXd basis(n, order + 1);
  const double from = series.time.front(), length = series.time.back() - from;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = 2.0 * (series.time[static_cast<std::size_t>(i)] - from) / length - 1.0;
    basis(i, 0) = 1.0;
    if (order > 0) basis(i, 1) = x;
    for (int k = 2; k <= order; ++k)
      basis(i, k) = ((2.0 * k - 1.0) * x * basis(i, k - 1) - (k - 1.0) * basis(i, k - 2)) / k;
  }
  const Eigen::Map<const Eigen::VectorXd> value(series.value.data(), n);
  TimeSeries result = series;
  Eigen::Map<Eigen::VectorXd>(result.value.data(), n) -= basis * basis.householderQr().solve(value);
  return result;
}

// A section of second order, or of first with b2 = a2 = 0: y = b0 x + b1 x' + b2 x'' - a1 y' - a2 y''.
struct Section {
  double b0, b1, b2, a1, a2;
  void run(std::vector<double>& x) const {
    double z1 = 0.0, z2 = 0.0;  // transposed direct form II
    for (double& value : x) {
      const double y = b0 * value + z1;
      z1 = b1 * value - a1 * y + z2;
      z2 = b2 * value - a2 * y;
      value = y;
    }
  }
};

// Butterworth by the bilinear transform, with an exact corner frequency.
std::vector<Section> high_pass_sections(int order, double corner_times_step) {
  const double k = std::tan(std::numbers::pi * corner_times_step);
  std::vector<Section> sections;
  for (int i = 0; i < order / 2; ++i) {
    const double q = 2.0 * std::sin(std::numbers::pi * (2.0 * i + 1.0) / (2.0 * order));  // 1/Q of the pair of poles
    const double norm = 1.0 / (1.0 + q * k + k * k);
    sections.push_back({norm, -2.0 * norm, norm, 2.0 * (k * k - 1.0) * norm, (1.0 - q * k + k * k) * norm});
  }
  if (order % 2 == 1) sections.push_back({1.0 / (1.0 + k), -1.0 / (1.0 + k), 0.0, (k - 1.0) / (k + 1.0), 0.0});
  return sections;
}

TimeSeries high_pass(const TimeSeries& series, int order, double corner) {
  constexpr double kMostZeros = 1e7;  // at each end: 160 MB in all
  if (series.time.size() < 2)
    throw Error(Exit::bad_input,
                fmt::format("a high-pass filter needs 2 samples or more; the record has {}", series.time.size()));
  const double step = series.time[1] - series.time[0];
  for (std::size_t i = 1; i < series.time.size(); ++i) {
    if (std::abs(series.time[i] - series.time[i - 1] - step) > 1e-6 * step)
      throw Error(Exit::bad_input,
                  fmt::format("a high-pass filter needs equal steps of time; step {} is {} s, the first {} s", i,
                              series.time[i] - series.time[i - 1], step));
  }
  const double least = 1.5 * order / (kMostZeros * step);
  if (!(corner >= least && corner * step < 0.25))
    throw Error(
        Exit::bad_input,
        fmt::format("corner frequency (baseline_corner, --corner) of {:g} Hz; allowed: {:.3g} Hz or more, below "
                    "{:g} Hz. The filter adds {:g} of its periods at either end, in steps of {:g} s, and takes "
                    "{:g} steps there at most",
                    corner, least, 0.25 / step, 1.5 * order, step, kMostZeros));
  const auto pad = static_cast<std::size_t>(std::ceil(1.5 * order / (corner * step)));
  std::vector<double> x(series.value.size() + 2 * pad, 0.0);
  std::copy(series.value.begin(), series.value.end(), x.begin() + static_cast<std::ptrdiff_t>(pad));
  const std::vector<Section> sections = high_pass_sections(order, corner * step);
  for (int pass = 0; pass < 2; ++pass) {
    for (const Section& section : sections) section.run(x);
    std::reverse(x.begin(), x.end());
  }
  TimeSeries result = series;
  std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(pad), series.value.size(), result.value.begin());
  return result;
}

}  // namespace

TimeSeries correct_baseline(const TimeSeries& acceleration, const BaselineCorrection& correction) {
  const auto require_order = [&](int from, int to) {
    if (correction.order < from || correction.order > to)
      throw Error(Exit::bad_input, fmt::format("baseline order {}; allowed: {} to {}", correction.order, from, to));
  };
  switch (correction.kind) {
    case BaselineCorrection::Kind::none:
      return acceleration;
    case BaselineCorrection::Kind::polynomial:
      require_order(0, 10);
      return less_polynomial(acceleration, correction.order);
    case BaselineCorrection::Kind::high_pass:
      require_order(1, 8);
      return high_pass(acceleration, correction.order, correction.corner_Hz);
  }
  return acceleration;
}

}  // namespace quoin
