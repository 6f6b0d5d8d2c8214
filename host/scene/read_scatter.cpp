#include "scene/read_scatter.h"

#include "random/correlation.h"
#include "scene/scatter_text.h"

namespace quoin::reader {

namespace {

const Named<random::Shape> kShapes = {{"normal", random::Shape::normal},
                                      {"lognormal", random::Shape::lognormal},
                                      {"weibull", random::Shape::weibull},
                                      {"uniform", random::Shape::uniform}};
const Named<ScatterLevel> kLevels = {{"point", ScatterLevel::point},
                                     {"joint", ScatterLevel::joint},
                                     {"unit", ScatterLevel::unit},
                                     {"course", ScatterLevel::course},
                                     {"wall", ScatterLevel::wall}};

}  // namespace

random::Distribution read_distribution(Table& t) {
  random::Distribution d;
  if (!t.choice("distribution", d.shape, kShapes, true)) {
    for (const char* key : {"mean", "cov", "sd", "lower", "upper"}) t.accept(key);
    return d;
  }
  const bool uniform = d.shape == random::Shape::uniform;
  bool read = true;
  if (!uniform) {
    read = t.number("mean", d.mean, kAny, "", true);
    double variation = 0.0;
    if (t.has("cov") == t.has("sd")) {
      t.context().fault(t.where() + ": give one of cov (standard deviation over mean) and sd (standard deviation)");
      t.accept("cov"), t.accept("sd");
      read = false;
    } else if (t.has("cov")) {
      read = t.number("cov", variation, kNotNegative, "(standard deviation over mean)") && read;
      d.scatter = variation * std::abs(d.mean);
    } else {
      read = t.number("sd", d.scatter, kNotNegative, "(standard deviation, in the unit of the mean)") && read;
    }
  }
  read = (t.number("lower", d.lower, kAny, "", uniform) || !t.has("lower")) && read;
  read = (t.number("upper", d.upper, kAny, "", uniform) || !t.has("upper")) && read;
  if (read && !d.fault().empty())
    t.context().fault(fmt::format("{} = {}: allowed: {}", t.where(), quoin::text_of(d), d.fault()));
  return d;
}

Scatter read_scatter(Table t) {
  Scatter s;
  s.distribution = read_distribution(t);
  t.choice("level", s.level, kLevels);
  const bool along = s.level == ScatterLevel::point || s.level == ScatterLevel::joint || s.level == ScatterLevel::unit;
  if (t.number("correlation_length", s.correlation_length, kNotNegative, "m along the wall (0: independent)") &&
      !along && s.correlation_length > 0.0)
    t.refuse("correlation_length",
             "only with level = \"point\", \"joint\" or \"unit\": a course or wall has one value");
  t.choice("scatter_of", s.of_joint_mean, {{"point", false}, {"joint", true}});
  if (s.of_joint_mean) {
    const bool known =
        (s.distribution.shape == random::Shape::normal || s.distribution.shape == random::Shape::lognormal) &&
        !s.distribution.truncated();
    if (s.level != ScatterLevel::point)
      t.refuse("scatter_of", "only with level = \"point\"; of other levels a joint has one value, which is its mean");
    else if (!known)
      t.refuse("scatter_of", "\"joint\" only with a normal or lognormal distribution without lower and upper");
  }
  t.finish();
  return s;
}

std::vector<double> read_correlation(Table& t, const std::vector<std::string>& names, const std::string& what,
                                     std::vector<PropertyCorrelation>& pairs) {
  const std::string key = "correlation", allowed = "a list as [[\"a\", \"b\", 0.8]], of " + what;
  const std::size_t n = names.size();
  std::vector<double> matrix(n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) matrix[i * n + i] = 1.0;
  const toml::array* list = t.list(key, allowed);
  for (std::size_t k = 0; list && k < list->size(); ++k) {
    const toml::array* entry = list->get(k)->as_array();
    if (!entry || entry->size() != 3) return t.wrong_type(key, allowed), std::vector<double>{};
    const auto first = entry->get(0)->value<std::string>(), second = entry->get(1)->value<std::string>();
    const std::optional<double> value = number_of(*entry->get(2));
    if (!first || !second || !value) return t.wrong_type(key, allowed), std::vector<double>{};
    std::string fault;
    std::array<std::size_t, 2> place{};
    for (std::size_t i = 0; const std::string& name : {*first, *second}) {
      place[i] = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
      if (place[i++] == n)
        fault = fmt::format("{}: {}; '{}' is none of them", what, names.empty() ? "none" : join(names), name);
    }
    const auto is_same = [&](const PropertyCorrelation& c) {
      return std::minmax(c.first, c.second) == std::minmax(*first, *second);
    };
    if (*first == *second || !(std::abs(*value) < 1.0))
      fault = "two different names, and a number between -1 and 1 without these";
    else if (std::ranges::any_of(pairs, is_same))
      fault = fmt::format("each pair once; {} and {} are given twice, remove one", *first, *second);
    if (!fault.empty()) return t.refuse(key, fault), std::vector<double>{};
    matrix[place[0] * n + place[1]] = matrix[place[1] * n + place[0]] = *value;
    pairs.push_back({*first, *second, *value});
  }
  std::vector<double> mix = random::mix_of(matrix, n);
  if (n > 0 && mix.empty()) t.refuse(key, "correlations that can be together: those given are not positive definite");
  return mix;
}

void read_correlation(Table& t, JointFamily& family) {
  std::vector<std::string> ids;
  for (const PropertySetting& p : family.properties) {
    if (p.scatter) ids.push_back(p.id);
  }
  read_correlation(t, ids, "properties that scatter", family.correlation);
  const auto scatter_of = [&](const std::string& id) {
    return *std::ranges::find(family.properties, id, &PropertySetting::id)->scatter;
  };
  for (const PropertyCorrelation& c : family.correlation) {
    const Scatter a = scatter_of(c.first), b = scatter_of(c.second);
    if (a.level != b.level || a.correlation_length != b.correlation_length)
      return t.refuse("correlation",
                      fmt::format("properties of the same level and correlation_length, which {} and {} are not",
                                  c.first, c.second));
  }
}

RandomSample read_random(Table& t) {
  constexpr long kMost = 1L << 53;  // largest integer that a double has exactly
  RandomSample random;
  t.integer("seed", random.seed, 0, kMost);
  t.integer("sample", random.sample, 0, kMost);
  return random;
}

}  // namespace quoin::reader
