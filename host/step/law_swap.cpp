#include "step/law_swap.h"

#include <fmt/core.h>

#include "base/error.h"
#include "law/at_rest.h"

namespace quoin {

namespace {

// Energy stored under the old law, J/m2, from a step without motion. Zeros where the law does not compute it.
std::vector<double> stored_energy(const Material& material, const FamilyColumns& points) {
  std::vector<double> stored(points.count, 0.0);
  if (!(material.api().capabilities & QUOIN_CAN_ENERGY)) return stored;
  evaluate_at_rest(material, points, [&](quoin_batch& batch) { batch.energy_stored = {stored.data(), 1}; });
  return stored;
}

}  // namespace

std::shared_ptr<const Material> successor(const JointFamily& family, const std::string& name) {
  const Law law = Law::find(name);
  std::vector<PropertySetting> properties;
  for (const PropertySetting& setting : family.properties) {
    for (std::uint64_t i = 0; i < law.law->property_count; ++i) {
      if (setting.id == law.law->properties[i]->id) properties.push_back(setting);
    }
  }
  auto material = std::make_shared<const Material>(law, properties);
  if (!(law.law->capabilities & QUOIN_CAN_MIGRATE) || !law.law->migrate_state) {
    throw Error(Exit::law_refused, fmt::format("joint family '{}': law '{}' cannot take over the state of another law",
                                               family.name, law.law->id));
  }
  return material;
}

LawSwap report_of(const std::string& family, const Material& from, const Material& to, const SwapSums& sums) {
  return {family, from.api().id, to.api().id, sums.points, sums.limited, sums.stored_before, sums.energy_jump};
}

SwapSums MigratedFamily::sums(std::size_t first, std::size_t count) const {
  SwapSums sums;
  for (std::size_t i = first; i < first + count; ++i) sums.add(terms[i]);
  return sums;
}

MigratedFamily migrate(const JointFamily& family, const Material& from, const Material& to,
                       const FamilyColumns& points) {
  const quoin_law &old_law = from.api(), &new_law = to.api();
  MigratedFamily result;
  result.state.assign(new_law.state_count * points.count, 0.0);
  result.opening_shift.assign(points.count, 0.0);
  if (points.count == 0) return result;

  const std::vector<double> stored = stored_energy(from, points);
  std::vector<double> energy_jump(points.count, 0.0);
  std::vector<std::uint32_t> point_status(points.count, QUOIN_POINT_OK);
  std::vector<const char*> ids;
  std::vector<quoin_in> old_state;
  std::vector<quoin_out> new_state;
  for (std::uint64_t k = 0; k < old_law.state_count; ++k) {
    ids.push_back(old_law.states[k]->id);
    old_state.push_back({points.state[k], 1});
  }
  for (std::uint64_t k = 0; k < new_law.state_count; ++k)
    new_state.push_back({result.state.data() + k * points.count, 1});
  char message[1024] = "";
  quoin_text text{sizeof(quoin_text), message, sizeof message, 0};
  quoin_migration migration{};
  migration.struct_size = sizeof migration;
  migration.count = points.count;
  migration.from_law = old_law.id;
  migration.from_schema = old_law.state_schema;
  migration.from_state_count = old_law.state_count;
  migration.from_state_ids = ids.data();
  migration.from_states = old_state.data();
  migration.normal_jump = {points.normal_jump, 1};
  for (std::size_t k = 0; k < 3; ++k) migration.traction[k] = {points.traction[k], 1};
  migration.energy_stored = {stored.data(), 1};
  migration.normal_shift = {result.opening_shift.data(), 1};
  migration.energy_jump = {energy_jump.data(), 1};
  migration.status = {point_status.data(), 1};
  migration.state_new = new_state.data();
  const quoin_status status = to.law().call([&] { return new_law.migrate_state(to.handle(), &migration, &text); });
  if (status != QUOIN_OK || migration.failed_count > 0) {
    throw Error(Exit::law_refused,
                fmt::format("joint family '{}': law '{}' did not take over the state of law '{}' ({} of {} points "
                            "refused): {}",
                            family.name, new_law.id, old_law.id, migration.failed_count, points.count, message));
  }
  for (std::size_t i = 0; i < points.count; ++i) {
    result.terms.push_back({1, point_status[i] == QUOIN_POINT_CLAMPED ? 1 : 0, points.area[i] * stored[i],
                            points.area[i] * energy_jump[i]});
  }
  return result;
}

}  // namespace quoin
