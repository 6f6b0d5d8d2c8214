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

const Scatter* scatter_of(const JointFamily& family, const std::string& id) {
  for (const PropertySetting& p : family.properties) {
    if (p.id == id && p.scatter) return &*p.scatter;
  }
  return nullptr;
}

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

void read_correlation(Table& t, JointFamily& family) {
  const std::string key = "correlation", allowed = "a list as [[\"tensile_strength\", \"cohesion\", 0.8]]";
  const toml::array* list = t.list(key, allowed);
  if (!list) return;
  std::vector<std::string> ids;
  const auto index_of = [&](const std::string& id) {
    return static_cast<std::size_t>(std::find(ids.begin(), ids.end(), id) - ids.begin());
  };
  for (const toml::node& element : *list) {
    const toml::array* entry = element.as_array();
    if (!entry || entry->size() != 3) return t.wrong_type(key, allowed);
    const auto first = entry->get(0)->value<std::string>(), second = entry->get(1)->value<std::string>();
    const std::optional<double> value = number_of(*entry->get(2));
    if (!first || !second || !value) return t.wrong_type(key, allowed);
    if (*first == *second || !(std::abs(*value) < 1.0))
      return t.refuse(key, "two properties, and a number between -1 and 1 without these");
    const Scatter *a = scatter_of(family, *first), *b = scatter_of(family, *second);
    if (!a || !b) return t.refuse(key, fmt::format("properties that scatter; {} has one value", a ? *second : *first));
    if (a->level != b->level || a->correlation_length != b->correlation_length)
      return t.refuse(key, fmt::format("properties of the same level and correlation_length, which {} and {} are not",
                                       *first, *second));
    for (const std::string& id : {*first, *second}) {
      if (index_of(id) == ids.size()) ids.push_back(id);
    }
    family.correlation.push_back({*first, *second, *value});
  }
  std::vector<double> matrix(ids.size() * ids.size(), 0.0);
  for (std::size_t i = 0; i < ids.size(); ++i) matrix[i * ids.size() + i] = 1.0;
  for (const PropertyCorrelation& c : family.correlation) {
    const std::size_t i = index_of(c.first), j = index_of(c.second);
    matrix[i * ids.size() + j] = matrix[j * ids.size() + i] = c.value;
  }
  if (!ids.empty() && random::mix_of(matrix, ids.size()).empty())
    t.refuse(key, "correlations that can be together: those given are not positive definite");
}

RandomSample read_random(Table& t) {
  constexpr long kMost = 1L << 53;  // largest integer that a double has exactly
  RandomSample random;
  t.integer("seed", random.seed, 0, kMost);
  t.integer("sample", random.sample, 0, kMost);
  return random;
}

}  // namespace quoin::reader
