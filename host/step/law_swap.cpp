#include "step/law_swap.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "base/error.h"
#include "law/at_rest.h"
#include "step/lattice_motion.h"
#include "step/promotion.h"
#include "step/rank_agreement.h"
#include "step/set_up.h"

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

// ---- On the lattice ---------------------------------------------------------------------------------------------

namespace {

// Consecutive contact points of a family, in these chunks.
struct PointRow {
  std::size_t first, end;
  std::vector<int> chunks;
};

// Sums of all chunks, each from the rank that owns it.
std::vector<SwapSums> of_all_chunks(const std::vector<SwapSums>& here, const RankShare& share, Ranks& ranks) {
  std::vector<SwapSums> own;
  std::vector<std::size_t> sizes(at(ranks.count())), next(sizes.size());
  for (std::size_t c = 0; c < here.size(); ++c) {
    sizes[at(share.rank_of_chunk[c])] += sizeof(SwapSums);
    if (share.owns_chunk(static_cast<int>(c), ranks.rank())) own.push_back(here[c]);
  }
  std::vector<SwapSums> by_rank(here.size()), all;
  ranks.gather(std::as_bytes(std::span(own)), sizes, std::as_writable_bytes(std::span(by_rank)));
  for (std::size_t r = 1; r < next.size(); ++r) next[r] = next[r - 1] + sizes[r - 1] / sizeof(SwapSums);
  for (const int rank : share.rank_of_chunk) all.push_back(by_rank[next[at(rank)]++]);
  return all;
}

}  // namespace

bool take_stiffness(Simulation::Impl& s, std::size_t f, const Material& material) {
  ContactFamily& family = s.model.families[f];
  const quoin_stiffness_bounds bounds = stiffness_bounds_of(s.model.assembly.families[f], material, family.columns);
  const bool is_stiffer = bounds.normal > family.normal_stiffness || bounds.shear > family.shear_stiffness;
  family.normal_stiffness = std::max(family.normal_stiffness, bounds.normal);
  family.shear_stiffness = std::max(family.shear_stiffness, bounds.shear);
  return is_stiffer;
}

void swap_lattice_law(Simulation::Impl& s, std::size_t f, std::shared_ptr<const Material> material) {
  ContactFamily& family = s.model.families[f];
  const auto first = at(family.first_point), count = at(family.point_count);
  std::vector<PointRow> rows;
  for (const int c : s.division.share.chunks) {
    const ContactChunk& chunk = s.model.chunks[at(c)];
    if (at(chunk.family) != f) continue;
    const auto begin = at(chunk.first_point), end = begin + at(chunk.point_count);
    if (rows.empty() || rows.back().end != begin) rows.push_back({begin, end, {}});
    rows.back().end = end;
    rows.back().chunks.push_back(c);
  }

  // The simulation is unchanged until all points are converted.
  const std::size_t state_count = material->api().state_count;
  LaneVector<double> state(state_count * count), shift = s.lattice.normal_shift;
  if (shift.empty()) shift.resize(at(s.model.point_count));
  std::vector<SwapSums> of_chunk(s.model.chunks.size());
  std::optional<Error> fault;
  for (const PointRow& row : rows) {
    std::vector<double> opening;  // openings at these tractions, m
    for (std::size_t p = row.first; p < row.end; ++p)
      opening.push_back(opening_at_traction(s, static_cast<std::int32_t>(p)));
    FamilyColumns points;
    points.count = row.end - row.first;
    points.normal_jump = opening.data();
    points.area = s.model.area.data() + row.first;
    for (std::size_t k = 0; k < 3; ++k) points.traction[k] = s.lattice.traction[k].data() + row.first;
    for (std::uint64_t k = 0; k < family.material->api().state_count; ++k)
      points.state.push_back(s.lattice.law_state[f].data() + k * count + (row.first - first));
    try {
      const MigratedFamily migrated = migrate(s.model.assembly.families[f], *family.material, *material, points);
      for (std::size_t k = 0; k < state_count; ++k)
        std::copy_n(migrated.state.begin() + static_cast<std::ptrdiff_t>(k * points.count), points.count,
                    state.begin() + static_cast<std::ptrdiff_t>(k * count + (row.first - first)));
      for (std::size_t i = 0; i < points.count; ++i) shift[row.first + i] += migrated.opening_shift[i];
      for (const int c : row.chunks) {
        const ContactChunk& chunk = s.model.chunks[at(c)];
        of_chunk[at(c)] = migrated.sums(at(chunk.first_point) - row.first, at(chunk.point_count));
      }
    } catch (const Error& error) {
      fault = error;
      break;
    }
  }
  throw_together(s.ranks, fault);

  SwapSums sums;
  for (const SwapSums& of_one : s.ranks ? of_all_chunks(of_chunk, s.division.share, *s.ranks) : of_chunk)
    sums.add(of_one);
  s.laws.swaps.push_back(report_of(family.name, *family.material, *material, sums));
  for (const PointRow& row : rows) {
    for (std::size_t p = row.first; p < row.end && s.lattice.damps_joints(); ++p)
      s.lattice.old_jump[p] += shift[p] - (s.lattice.normal_shift.empty() ? 0.0 : s.lattice.normal_shift[p]);
  }
  s.lattice.normal_shift = std::move(shift);
  s.lattice.law_state[f] = std::move(state);
  family.material = std::move(material);
  if (!take_stiffness(s, f, *family.material)) return bind_columns(s);
  const double added = s.energy.wanted ? added_kinetic_energy(s) : 0.0, old_step = s.data.time_step;
  follow_solver(s);
  if (s.energy.wanted) s.energy.lost_at_changes += added - added_kinetic_energy(s);
  for (long* const steps : {&s.progress.stage_step, &s.progress.next_row})  // of the time that the stage has run
    *steps = std::lround(static_cast<double>(*steps) * old_step / s.data.time_step);
}

}  // namespace quoin
