#include "results/parted_joints.h"

#include <algorithm>
#include <limits>

#include "geometry/vector.h"
#include "law/at_rest.h"
#include "step/large_motion.h"
#include "step/results.h"

namespace quoin {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Damage and flags that the laws return for points in the state of their last contact.
struct LastSeen {
  std::vector<std::array<double, QUOIN_DAMAGE_COUNT>> damage;
  std::vector<std::uint32_t> flags;
};

void evaluate_family(const std::vector<blocks::PartedPoint>& points, const blocks::Family& family, int index,
                     LastSeen& seen) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].family == index) chosen.push_back(i);
  }
  if (chosen.empty()) return;
  const std::size_t n = chosen.size();
  const auto column = [&](const auto& value) {
    std::vector<double> values;
    for (const std::size_t i : chosen) values.push_back(value(points[i]));
    return values;
  };
  const std::vector<double> jump = column([](const auto& p) { return p.normal_jump; });
  std::vector<std::vector<double>> traction, state;
  RestingPoints resting{n, jump.data(), {}, {}, {}};
  for (std::size_t k = 0; k < 3; ++k) traction.push_back(column([&](const auto& p) { return p.traction[k]; }));
  for (std::size_t k = 0; k < 3; ++k) resting.traction[k] = traction[k].data();
  for (std::size_t k = 0; k < family.state.size(); ++k) {
    state.push_back(column([&](const auto& p) { return p.state[k]; }));
    resting.state.push_back(state.back().data());
  }
  std::vector<PropertyColumn> properties;
  for (std::size_t k = 0; k < family.columns.size(); ++k) {
    const PropertyColumn& c = family.columns[k];
    const std::vector<double> values = column([&](const auto& p) { return p.properties[k]; });
    properties.push_back({c.id, c.is_drawn, c.usual, c.most, {values.begin(), values.end()}});
  }
  resting.properties = batch_columns(properties, *family.material, 0);

  std::array<std::vector<double>, QUOIN_DAMAGE_COUNT> damage;
  std::vector<std::uint32_t> flags(n, 0);
  for (auto& values : damage) values.assign(n, kUnknown);
  const std::uint64_t can = family.material->api().capabilities;
  if ((can & (QUOIN_CAN_DAMAGE | QUOIN_CAN_FLAGS)) == 0) return;
  evaluate_at_rest(*family.material, resting, [&](quoin_batch& batch) {
    if (can & QUOIN_CAN_FLAGS) batch.flags = {flags.data(), 1};
    for (std::size_t k = 0; k < damage.size() && (can & QUOIN_CAN_DAMAGE); ++k) batch.damage[k] = {damage[k].data(), 1};
  });
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < damage.size(); ++k) seen.damage[chosen[i]][k] = damage[k][i];
    seen.flags[chosen[i]] = flags[i];
  }
}

}  // namespace

std::vector<PartedPoint> parted_points(const Simulation& simulation, int first_block, int end_block) {
  const blocks::Model* large_motion = simulation.large_motion();
  if (!large_motion) return {};
  const std::vector<blocks::PartedPoint> points = parted_points(*large_motion, first_block, end_block);
  std::array<double, QUOIN_DAMAGE_COUNT> unknown;
  unknown.fill(kUnknown);
  LastSeen seen{std::vector(points.size(), unknown), std::vector<std::uint32_t>(points.size(), 0)};
  for (std::size_t f = 0; f < large_motion->contacts.families.size(); ++f)
    evaluate_family(points, large_motion->contacts.families[f], static_cast<int>(f), seen);

  std::vector<PartedPoint> parted;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const blocks::PartedPoint& p = points[i];
    const Law& law = large_motion->contacts.families[static_cast<std::size_t>(p.family)].material->law();
    const auto state = [&](const char* id) {
      const int k = law.state_index(id);
      return k < 0 ? kUnknown : p.state[static_cast<std::size_t>(k)];
    };
    ContactPoint contact{};
    contact.index = contact.joint = -1;
    contact.position = geometry::array(p.side_a);
    contact.normal = geometry::array(p.n), contact.s = geometry::array(p.s),
    contact.t = geometry::array(cross(p.n, p.s));
    contact.area = p.area, contact.family = p.family;
    contact.block_a = p.a, contact.block_b = p.b;
    contact.jump = {norm(p.side_b - p.side_a), 0.0, 0.0};
    contact.flags = seen.flags[i] | QUOIN_FLAG_OPEN;
    contact.condition = condition_of(contact.flags);
    PartedPoint& now = parted.emplace_back();
    now.joint = joint_point(simulation, contact, {seen.damage[i], state("slip"), state("w")});
    now.joint.crack = std::max(Crack::open, now.joint.crack);
    now.joint.gap = geometry::array(p.side_b - p.side_a);
    now.state = p.state;
  }
  return parted;
}

std::vector<PartedPoint> parted_points(const Simulation& simulation) {
  return parted_points(simulation, 0, static_cast<int>(simulation.block_count()));
}

}  // namespace quoin
