#include "model/property_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

#include "base/error.h"
#include "law/at_rest.h"
#include "law/property_text.h"
#include "random/correlation.h"
#include "random/counter.h"

namespace quoin {

namespace {

using random::Quantity;

// Index of a cell of 10 um: equal for places that are equal to rounding. No gridpoint lies on a border of cells.
std::int64_t cell_of(double x) { return std::llround(x / 1e-5 + 0.3183); }

// Key of a contact point. It includes the joint, as two joints may have points at one place.
std::uint64_t point_key(const Vec3& x, std::uint64_t joint) {
  const std::array<std::int64_t, 4> parts{cell_of(x[0]), cell_of(x[1]), cell_of(x[2]),
                                          static_cast<std::int64_t>(joint)};
  return random::name_of({reinterpret_cast<const char*>(parts.data()), sizeof parts});
}

// A place with one drawn value.
struct Element {
  std::uint64_t key;
  long row;  // elements of one row are consecutive along the wall
  double x;  // position along the wall, m
};

// Places with one drawn value each, at a level of scatter, and the place of each point.
struct Elements {
  std::vector<Element> element;
  std::vector<std::size_t> of_point;
};

class Places {
 public:
  Places(std::span<const PlacedPoint> points, std::span<const PlacedBlock> blocks) : points_(points), blocks_(blocks) {}

  std::uint64_t joint(const PlacedPoint& p) const {
    return joint_key(unit_key(p.block_a, at(p.block_a)), unit_key(p.block_b, at(p.block_b)));
  }

  Elements at_level(ScatterLevel level) const {
    Elements elements;
    std::map<std::uint64_t, std::size_t> known;
    std::vector<double> weight;
    for (const PlacedPoint& p : points_) {
      const auto [found, is_new] = known.try_emplace(key(p, level), elements.element.size());
      if (is_new) elements.element.push_back({found->first, row(p, level), 0.0}), weight.push_back(0.0);
      elements.of_point.push_back(found->second);
      elements.element[found->second].x += p.area * p.position[0];
      weight[found->second] += p.area;
    }
    // In whole cells, so that equal places stay equal whatever the rounding.
    for (std::size_t e = 0; e < weight.size(); ++e)
      elements.element[e].x = 1e-5 * static_cast<double>(cell_of(elements.element[e].x / weight[e]));
    return elements;
  }

 private:
  const PlacedBlock& at(int block) const { return blocks_[static_cast<std::size_t>(block)]; }
  int laid(const PlacedPoint& p) const { return block_laid(p.block_a, p.block_b, blocks_); }
  std::uint64_t key(const PlacedPoint& p, ScatterLevel level) const {
    const int block = laid(p);
    switch (level) {
      case ScatterLevel::point:
        return point_key(p.position, joint(p));
      case ScatterLevel::joint:
        return joint(p);
      case ScatterLevel::unit:
        return unit_key(block, at(block));
      case ScatterLevel::course:
        return static_cast<std::uint64_t>(at(block).course + 1);
      case ScatterLevel::wall:
        break;
    }
    return 0;
  }
  // Joints below a course, in it, and above it (to a body that is not masonry) are rows of their own.
  long row(const PlacedPoint& p, ScatterLevel level) const {
    const int block = laid(p), other = block == p.block_a ? p.block_b : p.block_a;
    long which = 0;
    if (level != ScatterLevel::unit && at(other).course == at(block).course) which = 1;
    if (level != ScatterLevel::unit && at(other).course < 0 && (block == p.block_a ? 1.0 : -1.0) * p.axis[0][1] > 0.5)
      which = 2;
    return 3L * at(block).course + which;
  }

  std::span<const PlacedPoint> points_;
  std::span<const PlacedBlock> blocks_;
};

// Standard normal variables of the elements, correlated along rows: each depends on the one before it.
std::vector<double> normal_field(const std::vector<Element>& elements, double length,
                                 const std::vector<double>& fresh) {
  std::vector<double> z = fresh;
  if (length == 0.0) return z;
  std::vector<std::size_t> order(elements.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    const Element &a = elements[i], &b = elements[j];
    return std::tie(a.row, a.x, a.key) < std::tie(b.row, b.x, b.key);
  });
  for (std::size_t k = 1; k < order.size(); ++k) {
    const Element &last = elements[order[k - 1]], &now = elements[order[k]];
    if (last.row != now.row) continue;
    const random::Follow f = random::follow(now.x - last.x, length);
    z[order[k]] = f.share * z[order[k - 1]] + f.fresh * fresh[order[k]];
  }
  return z;
}

// Values by point, drawn by the sampler of its joint: the mean over the joint has the given distribution.
std::vector<double> values_by_joint(const Scatter& scatter, const Places& places, std::span<const PlacedPoint> points,
                                    const std::vector<double>& z) {
  std::map<std::uint64_t, std::vector<std::size_t>> joints;
  for (std::size_t i = 0; i < points.size(); ++i) joints[places.joint(points[i])].push_back(i);
  std::map<std::vector<long>, random::Sampler> by_pattern;  // by places and weights, which most joints share
  std::vector<double> values(points.size());
  for (const auto& [key, members] : joints) {
    std::vector<double> x, weight;
    double area = 0.0;
    for (const std::size_t i : members) area += points[i].area;
    std::vector<long> pattern;
    for (const std::size_t i : members) {
      x.push_back(points[i].position[0] - points[members[0]].position[0]);
      weight.push_back(points[i].area / area);
      pattern.push_back(std::lround(x.back() * 1e7)), pattern.push_back(std::lround(weight.back() * 1e9));
    }
    auto sampler = by_pattern.find(pattern);
    if (sampler == by_pattern.end())
      sampler =
          by_pattern
              .emplace(pattern,
                       random::Sampler(random::of_points(scatter.distribution, scatter.correlation_length, x, weight)))
              .first;
    for (const std::size_t i : members) values[i] = sampler->second.at_normal(z[i]);
  }
  return values;
}

std::string where(const JointFamily& family) {
  return fmt::format("{}, sample {} of seed {}", family.source.text, family.random.sample, family.random.seed);
}
std::string place_text(const PlacedPoint& p) {
  return fmt::format("({:.4f}, {:.4f}, {:.4f}) m", p.position[0], p.position[1], p.position[2]);
}

void refuse_outside(const JointFamily& family, const quoin_property_info& info, const std::vector<double>& values,
                    std::span<const PlacedPoint> points) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double v = values[i];
    const bool low = (info.flags & QUOIN_PROPERTY_LOWER_OPEN) ? v > info.lower : v >= info.lower;
    const bool high = (info.flags & QUOIN_PROPERTY_UPPER_OPEN) ? v < info.upper : v <= info.upper;
    if (low && high) continue;
    throw Error(Exit::bad_input,
                fmt::format("{}: {} = {:g} {} was drawn at {}; allowed: {:g} to {:g}; truncate the distribution with "
                            "lower and upper, or take one that has no such values, as lognormal",
                            where(family), info.id, v, info.unit, place_text(points[i]), info.lower, info.upper));
  }
}

// Throws for values that the law refuses in combination: a trial step without motion shows it.
void refuse_together(const JointFamily& family, const Material& material, std::span<const PlacedPoint> points,
                     const std::vector<PropertyColumn>& columns) {
  const std::size_t n = points.size();
  const std::vector<double> initial = material.initial_state(family.initial_state), zero(n, 0.0);
  std::vector<std::vector<double>> state;
  RestingPoints resting{
      n, zero.data(), {zero.data(), zero.data(), zero.data()}, {}, batch_columns(columns, material, 0)};
  for (const double value : initial) resting.state.push_back(state.emplace_back(n, value).data());
  std::vector<std::uint32_t> status(n);
  const AnswerAtRest answer = evaluate_at_rest(material, resting, [&](quoin_batch& batch) {
    batch.status = {status.data(), 1};
  });
  if (!answer.failed()) return;
  material.require_no_fault(Exit::law_refused);
  const char* const law = material.api().id;
  if (answer.status != QUOIN_OK)
    throw Error(Exit::law_refused, fmt::format("{}: law {} refuses properties point by point with status {}",
                                               where(family), law, answer.status));
  const auto failed =
      static_cast<std::size_t>(std::find(status.begin(), status.end(), QUOIN_POINT_FAILED) - status.begin());
  std::string drawn;
  for (const PropertyColumn& c : columns)
    drawn += fmt::format("{}{} = {:g}", drawn.empty() ? "" : ", ", c.id, c.values[std::min(failed, n - 1)]);
  throw Error(
      Exit::bad_input,
      fmt::format("{}: law {} refuses the properties drawn for {} of {} contact points, as at {}: {}; let "
                  "strengths and fracture energies go together (correlation), or truncate their distributions",
                  where(family), law, answer.failed_count, n, place_text(points[std::min(failed, n - 1)]), drawn));
}

}  // namespace

int block_laid(int block_a, int block_b, std::span<const PlacedBlock> blocks) {
  const int later = std::max(block_a, block_b), earlier = std::min(block_a, block_b);
  const auto is_masonry = [&](int block) { return blocks[static_cast<std::size_t>(block)].unit >= 0; };
  return !is_masonry(later) && is_masonry(earlier) ? earlier : later;
}

namespace {

std::vector<const PropertySetting*> scattered_in(const JointFamily& family) {
  std::vector<const PropertySetting*> scattered;
  for (const PropertySetting& p : family.properties) {
    if (p.scatter && family.random.sample != 0) scattered.push_back(&p);
  }
  return scattered;
}

// Columns of the properties that are drawn, without values.
std::vector<PropertyColumn> empty_columns(std::span<const PropertySetting* const> scattered, const Material& material) {
  std::vector<PropertyColumn> columns;
  for (const PropertySetting* setting : scattered) {
    columns.push_back({find_property(material.api(), setting->id)->id,
                       true,
                       material.number(setting->id),
                       -std::numeric_limits<double>::infinity(),
                       {}});
  }
  return columns;
}

// Adds a column for each property whose default is the value of one that has a column.
void add_defaults(const JointFamily& family, const Material& material, std::vector<PropertyColumn>& columns) {
  const quoin_law& law = material.api();
  for (std::uint64_t k = 0; k < law.property_count; ++k) {
    const quoin_property_info& info = *law.properties[k];
    if (!info.default_from || !(info.flags & QUOIN_PROPERTY_PER_POINT)) continue;
    if (std::ranges::find(family.properties, info.id, &PropertySetting::id) != family.properties.end()) continue;
    const std::string_view from = info.default_from;
    const auto drawn = std::ranges::find(columns, from, &PropertyColumn::id);
    if (drawn == columns.end()) continue;
    PropertyColumn column = *drawn;
    column.id = info.id, column.is_drawn = false;
    columns.push_back(std::move(column));
  }
}

}  // namespace

std::vector<PropertyColumn> scattered_columns(const JointFamily& family, const Material& material) {
  std::vector<PropertyColumn> columns = empty_columns(scattered_in(family), material);
  add_defaults(family, material, columns);
  return columns;
}

std::vector<PropertyColumn> draw_properties(const JointFamily& family, const Material& material,
                                            std::span<const PlacedPoint> points, std::span<const PlacedBlock> blocks) {
  const std::vector<const PropertySetting*> scattered = scattered_in(family);
  if (scattered.empty() || points.empty()) return {};

  const std::size_t n = scattered.size();
  std::vector<double> correlations(n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) correlations[i * n + i] = 1.0;
  const auto index_of = [&](const std::string& id) {
    return static_cast<std::size_t>(
        std::find_if(scattered.begin(), scattered.end(), [&](const auto* p) { return p->id == id; }) -
        scattered.begin());
  };
  for (const PropertyCorrelation& c : family.correlation) {
    const std::size_t i = index_of(c.first), j = index_of(c.second);
    correlations[i * n + j] = correlations[j * n + i] = c.value;
  }
  const std::vector<double> mix = random::mix_of(correlations, n);

  const Places places(points, blocks);
  std::vector<PropertyColumn> columns = empty_columns(scattered, material);
  for (std::size_t i = 0; i < n; ++i) {
    const PropertySetting& setting = *scattered[i];
    const Scatter& scatter = *setting.scatter;
    const Elements elements = places.at_level(scatter.level);
    std::vector<double> fresh(elements.element.size(), 0.0);
    for (std::size_t j = 0; j <= i; ++j) {
      if (mix[i * n + j] == 0.0) continue;
      const Quantity quantity{family.random.seed, family.random.sample,
                              random::name_of("joints." + family.name + "." + scattered[j]->id)};
      for (std::size_t e = 0; e < fresh.size(); ++e)
        fresh[e] += mix[i * n + j] * random::normal(quantity, elements.element[e].key);
    }
    const std::vector<double> of_element = normal_field(elements.element, scatter.correlation_length, fresh);
    std::vector<double> values(points.size());
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = of_element[elements.of_point[k]];
    if (scatter.of_joint_mean) {
      values = values_by_joint(scatter, places, points, values);
    } else {
      const random::Sampler sampler(scatter.distribution);
      for (double& v : values) v = sampler.at_normal(v);
    }
    const quoin_property_info* info = find_property(material.api(), setting.id);
    refuse_outside(family, *info, values, points);
    columns[i].most = *std::max_element(values.begin(), values.end());
    columns[i].values.assign(values.begin(), values.end());
  }
  add_defaults(family, material, columns);
  refuse_together(family, material, points, columns);
  return columns;
}

std::vector<quoin_property_column> batch_columns(const std::vector<PropertyColumn>& columns, const Material& material,
                                                 std::size_t first) {
  std::vector<quoin_property_column> result;
  for (const PropertyColumn& c : columns) {
    const quoin_property_info* info = find_property(material.api(), c.id);
    if (info && (info->flags & QUOIN_PROPERTY_PER_POINT)) result.push_back({info->id, {c.values.data() + first, 1}});
  }
  return result;
}

const PropertyColumn* find_column(const std::vector<PropertyColumn>& columns, std::string_view id) {
  const auto found = std::ranges::find(columns, id, &PropertyColumn::id);
  return found == columns.end() ? nullptr : &*found;
}

double scatter_factor(const std::vector<PropertyColumn>& columns, std::string_view id, std::size_t point) {
  const PropertyColumn* const column = find_column(columns, id);
  return !column || point >= column->values.size() ? 1.0 : column->values[point] / column->usual;
}

quoin_stiffness_bounds stiffness_bounds_at(const Material& material, const std::vector<PropertyColumn>& columns,
                                           std::size_t point) {
  quoin_stiffness_bounds bounds = material.stiffness_bounds();
  bounds.normal *= scatter_factor(columns, "normal_stiffness", point);
  bounds.shear *= scatter_factor(columns, "shear_stiffness", point);
  return bounds;
}

quoin_stiffness_bounds stiffness_bounds_of(const JointFamily& family, const Material& material,
                                           const std::vector<PropertyColumn>& columns) {
  std::vector<PropertySetting> stiffest = family.properties;
  bool scatters = false;
  for (const PropertyColumn& c : columns) {
    const quoin_property_info* info = find_property(material.api(), c.id);
    if (!info || std::strcmp(info->unit, "Pa/m") != 0) continue;
    scatters = true;
    for (PropertySetting& p : stiffest) {
      if (p.id == c.id) p.numbers = {std::max(c.usual, c.most)};
    }
  }
  return scatters ? Material(material.law(), stiffest).stiffness_bounds() : material.stiffness_bounds();
}

}  // namespace quoin
