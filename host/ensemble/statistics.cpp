#include "ensemble/statistics.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "ensemble/no_number.h"
#include "random/counter.h"
#include "random/distribution.h"

namespace quoin::ensemble {

namespace bm = boost::math;

namespace {

constexpr double kTail = 0.025;  // probability on either side of an interval

std::vector<double> finite(const std::vector<double>& values) {
  std::vector<double> result;
  for (const double v : values) {
    if (std::isfinite(v)) result.push_back(v);
  }
  return result;
}

// Ranks from 0; equal values have the mean of their ranks.
std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
  std::vector<double> rank(values.size());
  for (std::size_t first = 0; first < order.size();) {
    std::size_t end = first;
    while (end < order.size() && values[order[end]] == values[order[first]]) ++end;
    for (std::size_t k = first; k < end; ++k) rank[order[k]] = 0.5 * static_cast<double>(first + end - 1);
    first = end;
  }
  return rank;
}

double correlation(const std::vector<double>& x, const std::vector<double>& y) {
  const Moments mx = moments_of(x), my = moments_of(y);
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += (x[i] - mx.mean) * (y[i] - my.mean);
  return sum / (static_cast<double>(x.size() - 1) * mx.scatter * my.scatter);
}

double correlation_ratio(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  const std::size_t strata = std::min<std::size_t>(20, static_cast<std::size_t>(std::sqrt(static_cast<double>(n) / 2)));
  if (strata < 2) return kNone;
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return x[i] < x[j]; });
  const double mean = std::accumulate(y.begin(), y.end(), 0.0) / static_cast<double>(n);
  double between = 0.0, total = 0.0;
  for (std::size_t s = 0; s < strata; ++s) {
    const std::size_t first = s * n / strata, end = (s + 1) * n / strata;
    double sum = 0.0;
    for (std::size_t k = first; k < end; ++k) sum += y[order[k]] - mean;
    between += sum * sum / static_cast<double>(end - first);
  }
  for (const double v : y) total += (v - mean) * (v - mean);
  const double rest = (1.0 - between / total) * static_cast<double>(n - 1) / static_cast<double>(n - strata);
  return std::max(0.0, 1.0 - rest);
}

}  // namespace

Moments moments_of(const std::vector<double>& values) {
  const std::vector<double> v = finite(values);
  Moments m;
  m.count = v.size();
  const auto n = static_cast<double>(v.size());
  if (v.empty()) return {0, kNone, kNone, {kNone, kNone}, {kNone, kNone}};
  for (const double x : v) m.mean += x / n;
  if (v.size() < 2) return {1, m.mean, kNone, {kNone, kNone}, {kNone, kNone}};
  double squares = 0.0;
  for (const double x : v) squares += (x - m.mean) * (x - m.mean);
  m.scatter = std::sqrt(squares / (n - 1));
  const double half = bm::quantile(bm::complement(bm::students_t(n - 1), kTail)) * m.scatter / std::sqrt(n);
  m.of_mean = {m.mean - half, m.mean + half};
  const bm::chi_squared chi(n - 1);
  m.of_scatter = {std::sqrt(squares / bm::quantile(bm::complement(chi, kTail))),
                  std::sqrt(squares / bm::quantile(chi, kTail))};
  return m;
}

double quantile_of(std::vector<double> values, double probability) {
  std::vector<double> v = finite(values);
  if (v.empty()) return kNone;
  std::sort(v.begin(), v.end());
  const double place =
      std::clamp(probability * static_cast<double>(v.size()) - 0.5, 0.0, static_cast<double>(v.size() - 1));
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, v.size() - 1);
  return v[below] + (place - static_cast<double>(below)) * (v[above] - v[below]);
}

// The numbers of samples below and above the quantile have binomial distributions.
Interval quantile_interval(std::vector<double> values, double probability) {
  std::vector<double> v = finite(values);
  if (v.empty()) return {kNone, kNone};
  std::sort(v.begin(), v.end());
  const bm::binomial count(static_cast<double>(v.size()), probability);
  // The k-th of the sorted samples lies above the quantile where less than k of them lie below it.
  const auto passes = [&](const bm::binomial& number) {
    std::size_t k = 0;
    while (k < v.size() && bm::cdf(number, static_cast<double>(k)) <= kTail) ++k;
    return k;
  };
  const std::size_t low = passes(count), high = passes(bm::binomial(static_cast<double>(v.size()), 1.0 - probability));
  // Too few samples: no bound on that side.
  return {low > 0 ? v[low - 1] : kNone, high > 0 ? v[v.size() - high] : kNone};
}

std::optional<Dependence> dependence_of(const std::vector<double>& input, const std::vector<double>& output) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < input.size(); ++i) {
    if (std::isfinite(input[i]) && std::isfinite(output[i])) x.push_back(input[i]), y.push_back(output[i]);
  }
  if (x.size() < 5) return {};
  const auto is_constant = [](const std::vector<double>& v) {
    return std::all_of(v.begin(), v.end(), [&](double value) { return value == v[0]; });
  };
  if (is_constant(x) || is_constant(y)) return {};
  return Dependence{correlation(x, y), correlation(ranks(x), ranks(y)), correlation_ratio(x, y)};
}

namespace {

struct Row {
  double a, b, mixed;
};

// First and total index of rows row(0), row(1), ...
template <class RowAt>
std::array<double, 2> sobol_indices(std::size_t rows, const RowAt& row) {
  const auto n = static_cast<double>(rows);
  double mean = 0.0, variance = 0.0, first = 0.0, total = 0.0;
  for (std::size_t i = 0; i < rows; ++i) mean += (row(i).a + row(i).b) / (2 * n);
  for (std::size_t i = 0; i < rows; ++i) {
    const Row& r = row(i);
    variance += ((r.a - mean) * (r.a - mean) + (r.b - mean) * (r.b - mean)) / (2 * n);
    first += (r.b - mean) * (r.mixed - r.a) / n;
    total += (r.a - r.mixed) * (r.a - r.mixed) / (2 * n);
  }
  return {first / variance, total / variance};
}

}  // namespace

std::optional<SobolIndex> sobol_index_of(const std::vector<double>& a, const std::vector<double>& b,
                                         const std::vector<double>& mixed) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isfinite(a[i]) && std::isfinite(b[i]) && std::isfinite(mixed[i])) rows.push_back({a[i], b[i], mixed[i]});
  }
  const auto is_same = [&](const Row& r) { return r.a == rows[0].a && r.b == rows[0].a; };
  if (rows.size() < 8 || std::all_of(rows.begin(), rows.end(), is_same)) return {};
  const auto [first, total] = sobol_indices(rows.size(), [&](std::size_t i) { return rows[i]; });
  constexpr std::uint64_t kDraws = 1000;
  std::vector<double> firsts, totals;
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    const random::Quantity quantity{1, draw, random::name_of("rows of Sobol's indices")};
    std::vector<Row> drawn;
    for (std::size_t i = 0; i < rows.size(); ++i)
      drawn.push_back(rows[static_cast<std::size_t>(random::uniform(quantity, i) * static_cast<double>(rows.size()))]);
    const auto [f, t] = sobol_indices(drawn.size(), [&](std::size_t i) { return drawn[i]; });
    firsts.push_back(f), totals.push_back(t);
  }
  return SobolIndex{rows.size(),
                    first,
                    total,
                    {quantile_of(firsts, kTail), quantile_of(firsts, 1 - kTail)},
                    {quantile_of(totals, kTail), quantile_of(totals, 1 - kTail)}};
}

Fragility fragility_of(const std::vector<double>& values) {
  std::vector<double> logs;
  for (const double v : values) {
    if (std::isfinite(v) && v > 0.0) logs.push_back(std::log(v));
  }
  Fragility f{values.size(), logs.size(), kNone, kNone, {kNone, kNone}, "none"};
  if (logs.size() < 3) return f;
  if (logs.size() == values.size()) {
    const Moments m = moments_of(logs);
    f.median = std::exp(m.mean), f.spread = m.scatter;
    f.of_median = {std::exp(m.of_mean.low), std::exp(m.of_mean.high)};
    f.fit = "moments";
    return f;
  }
  // Censored values lie above all others: a straight line fits the logarithms over the normal quantiles of their ranks.
  std::sort(logs.begin(), logs.end());
  double sz = 0.0, sx = 0.0, szz = 0.0, szx = 0.0;
  const auto n = static_cast<double>(logs.size());
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const double z = random::normal_quantile((static_cast<double>(i) + 0.5) / static_cast<double>(values.size()));
    sz += z, sx += logs[i], szz += z * z, szx += z * logs[i];
  }
  f.spread = (szx - sz * sx / n) / (szz - sz * sz / n);
  f.median = std::exp((sx - f.spread * sz) / n);
  f.fit = "order statistics";
  return f;
}

namespace {

constexpr double kLeastSpread = 0.01;  // where capacities do not overlap, all smaller ones are equally likely
constexpr double kMostSpread = 20.0;   // beyond it the limit is reached as often at all intensities

double density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2.0 * M_PI); }
// Probability of a normal variable between two bounds, without cancellation in its tails.
double between(double low, double high) {
  const auto above = [](double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); };
  return std::max(1e-300, low > 0.0 ? above(low) - above(high) : above(-high) - above(-low));
}

// Logarithm of the likelihood. In a = 1/spread and b = -ln(median)/spread it is concave. Newton's method finds its
// maximum, with halved steps where it decreases.
struct Likelihood {
  double value = 0.0, a = 0.0, b = 0.0, aa = 0.0, ab = 0.0, bb = 0.0;  // value, and derivatives by a and b
};
Likelihood likelihood_of(const std::vector<Capacity>& capacities, double a, double b) {
  Likelihood l;
  for (const Capacity& c : capacities) {
    const bool from = c.low > 0.0, to = std::isfinite(c.high);
    const double x1 = from ? std::log(c.low) : 0.0, x2 = to ? std::log(c.high) : 0.0;
    const double z1 = from ? a * x1 + b : -HUGE_VAL, z2 = to ? a * x2 + b : HUGE_VAL;
    const double p = between(z1, z2), d1 = from ? density(z1) / p : 0.0, d2 = to ? density(z2) / p : 0.0;
    const double e1 = from ? z1 * d1 : 0.0, e2 = to ? z2 * d2 : 0.0;
    const double ga = d2 * x2 - d1 * x1, gb = d2 - d1;
    l.value += std::log(p), l.a += ga, l.b += gb;
    l.aa += e1 * x1 * x1 - e2 * x2 * x2 - ga * ga;
    l.ab += e1 * x1 - e2 * x2 - ga * gb;
    l.bb += e1 - e2 - gb * gb;
  }
  return l;
}

// Median and spread of the greatest likelihood.
std::optional<std::array<double, 2>> most_likely(const std::vector<Capacity>& capacities) {
  double middle = 0.0;
  std::size_t reached = 0, not_reached = 0;
  for (const Capacity& c : capacities) {
    reached += std::isfinite(c.high) ? 1 : 0, not_reached += c.low > 0.0 ? 1 : 0;
    middle += std::log(c.low <= 0.0            ? c.high
                       : std::isfinite(c.high) ? std::sqrt(c.low * c.high)
                                               : c.low) /
              static_cast<double>(capacities.size());
  }
  if (reached == 0 || not_reached == 0) return std::nullopt;
  constexpr double kFirstSpread = 0.5, kSettled = 1e-12;
  double a = 1.0 / kFirstSpread, b = -middle / kFirstSpread;
  Likelihood now = likelihood_of(capacities, a, b);
  for (int step = 0; step < 200; ++step) {
    const double determinant = now.aa * now.bb - now.ab * now.ab;
    double da = 0.0, db = 0.0;
    if (determinant > 0.0) {
      da = (now.ab * now.b - now.bb * now.a) / determinant, db = (now.ab * now.a - now.aa * now.b) / determinant;
    } else {
      const double size = std::hypot(now.a, now.b);
      if (size == 0.0) break;
      da = now.a / size, db = now.b / size;
    }
    bool better = false;
    for (double share = 1.0; share > 1e-10 && !better; share *= 0.5) {
      const double na = a + share * da, nb = b + share * db;
      if (!(na > 0.0)) continue;
      const Likelihood next = likelihood_of(capacities, na, nb);
      better = next.value > now.value;
      if (!better) continue;
      const double gain = next.value - now.value;
      a = na, b = nb, now = next;
      if (gain < kSettled) return std::array{std::exp(-b / a), std::max(kLeastSpread, 1.0 / a)};
    }
    if (!better || a > 1.0 / kLeastSpread) break;
  }
  return std::array{std::exp(-b / a), std::max(kLeastSpread, 1.0 / a)};
}

// Whether half of the spread is as likely, with the intercept that suits it best.
bool smaller_spread_is_as_likely(const std::vector<Capacity>& capacities, double median, double spread) {
  constexpr double kAsLikely = 1e-6;  // difference of the logarithms of likelihoods
  const double most = likelihood_of(capacities, 1.0 / spread, -std::log(median) / spread).value;
  const double a = 2.0 / spread;
  double b = -std::log(median) * a, best = likelihood_of(capacities, a, b).value;
  for (double step = 4.0; step > 1e-9; step *= 0.5) {
    for (bool better = true; better;) {
      better = false;
      for (const double other : {b - step, b + step}) {
        const double value = likelihood_of(capacities, a, other).value;
        if (value > best) best = value, b = other, better = true;
      }
    }
  }
  return best >= most - kAsLikely;
}

}  // namespace

std::optional<FittedFragility> FittedFragility::of(const std::vector<Capacity>& capacities, std::uint64_t seed) {
  const auto fit = most_likely(capacities);
  if (!fit) return std::nullopt;
  FittedFragility f;
  f.median = (*fit)[0], f.spread = (*fit)[1];
  if (!(f.spread < kMostSpread)) return std::nullopt;
  f.spread_is_bound = smaller_spread_is_as_likely(capacities, f.median, f.spread);
  std::vector<std::vector<Capacity>> by_record;
  for (const Capacity& c : capacities) {
    if (by_record.size() <= c.record) by_record.resize(c.record + 1);
    by_record[c.record].push_back(c);
  }
  std::erase_if(by_record, [](const auto& of_record) { return of_record.empty(); });
  constexpr std::uint64_t kDraws = 1000;
  constexpr std::size_t kLeastRecords = 3;  // least number of records for an interval
  const bool many = by_record.size() >= kLeastRecords;
  std::vector<double> medians, spreads;
  for (std::uint64_t draw = 0; many && draw < kDraws; ++draw) {
    const random::Quantity quantity{seed, draw, random::name_of("records of a fragility")};
    std::vector<Capacity> drawn;
    for (std::size_t i = 0; i < by_record.size(); ++i) {
      const auto record =
          static_cast<std::size_t>(random::uniform(quantity, i) * static_cast<double>(by_record.size()));
      drawn.insert(drawn.end(), by_record[record].begin(), by_record[record].end());
    }
    const auto of_draw = most_likely(drawn);
    if (!of_draw || !((*of_draw)[1] < kMostSpread)) continue;
    f.drawn_.push_back(*of_draw);
    medians.push_back((*of_draw)[0]), spreads.push_back((*of_draw)[1]);
  }
  f.of_median = {quantile_of(medians, kTail), quantile_of(medians, 1.0 - kTail)};
  f.of_spread = {quantile_of(spreads, kTail), quantile_of(spreads, 1.0 - kTail)};
  return f;
}

double FittedFragility::probability(double intensity) const {
  return random::normal_probability(std::log(intensity / median) / spread);
}

Interval FittedFragility::probability_interval(double intensity) const {
  std::vector<double> of_draws;
  for (const auto& [m, s] : drawn_) of_draws.push_back(random::normal_probability(std::log(intensity / m) / s));
  return {quantile_of(of_draws, kTail), quantile_of(of_draws, 1.0 - kTail)};
}

double force_at(const Curve& curve, double displacement) {
  const auto after = std::lower_bound(curve.displacement.begin(), curve.displacement.end(), displacement);
  if (after == curve.displacement.end()) return kNone;
  const auto i = static_cast<std::size_t>(after - curve.displacement.begin());
  if (i == 0) return curve.force[0];
  const double a = curve.displacement[i - 1], b = curve.displacement[i];
  return curve.force[i - 1] + (displacement - a) / (b - a) * (curve.force[i] - curve.force[i - 1]);
}

}  // namespace quoin::ensemble
