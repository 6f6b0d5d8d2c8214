#include "step/points_at_rest.h"

#include <algorithm>
#include <array>
#include <limits>

#include "base/rank_rows.h"
#include "base/ranks.h"
#include "law/at_rest.h"
#include "step/gather.h"
#include "step/large_motion_results.h"
#include "step/lattice_motion.h"
#include "step/results.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

std::array<long, kConditionCount> own_conditions(Simulation::Impl& s) {
  const std::vector<std::uint32_t> now = current_flags(s, whole_range(s));
  std::array<long, kConditionCount> counts{};
  for (const int c : s.division.share.chunks) {
    if (!s.division.share.owns_chunk(c, s.ranks->rank())) continue;
    const PointRange points = points_of_chunk(s, c);
    for (int i = points.first; i < points.end; ++i) ++counts[static_cast<std::size_t>(condition_of(now[at(i)]))];
  }
  return counts;
}

}  // namespace

Condition condition_of(std::uint32_t flags) {
  if (flags & QUOIN_FLAG_CRUSHING_COMPLETE) return Condition::crushed_out;
  if (flags & QUOIN_FLAG_CRUSHED) return Condition::crushing;
  if ((flags & QUOIN_FLAG_OPEN) && (flags & QUOIN_FLAG_TENSION_COMPLETE)) return Condition::open;
  if (flags & QUOIN_FLAG_SLIPPING) return Condition::slipping;
  if (flags & (QUOIN_FLAG_TENSION_DAMAGED | QUOIN_FLAG_SHEAR_DAMAGED)) return Condition::softening;
  return Condition::elastic;
}

std::size_t contact_point_count(const Simulation::Impl& s) {
  return s.large_motion ? s.large_motion->point_count() : at(s.model.point_count);
}

long Simulation::point_count() const { return static_cast<long>(contact_point_count(*impl_)); }

const char* condition_name(Condition condition) {
  constexpr const char* names[kConditionCount] = {"crushed_out", "crushing",  "open",
                                                  "slipping",    "softening", "elastic"};
  return names[static_cast<std::size_t>(condition)];
}

void evaluate_points_at_rest(const Simulation::Impl& s, std::uint64_t capability, const PointRange& range,
                             const PointOutputs& outputs) {
  if (s.large_motion) return evaluate_large_motion_at_rest(s, capability, range, outputs);
  std::vector<double> normal(kChunk);
  const auto begin = std::partition_point(s.model.chunks.begin(), s.model.chunks.end(),
                                          [&](const ContactChunk& c) { return c.first_point < range.first; });
  for (auto there = begin; there != s.model.chunks.end() && there->first_point < range.end; ++there) {
    const ContactChunk& chunk = *there;
    const auto index = static_cast<int>(there - s.model.chunks.begin());
    // Points of other ranks that are not gathered have no state for a law call.
    if (!has_all(s) && !std::binary_search(s.division.share.chunks.begin(), s.division.share.chunks.end(), index))
      continue;
    const Material& material = *s.model.families[at(chunk.family)].material;
    if (!(material.api().capabilities & capability)) continue;
    for (int i = 0; i < chunk.point_count; ++i) normal[at(i)] = opening_at_traction(s, chunk.first_point + i);
    const BoundCall& call = s.contacts.calls[at(index)];
    RestingPoints points{at(chunk.point_count), normal.data(), {}, {}, call.properties};
    for (std::size_t k = 0; k < 3; ++k) points.traction[k] = call.batch.traction_old[k].data;
    for (const quoin_in& column : call.state_old) points.state.push_back(column.data);
    evaluate_at_rest(material, points, [&](quoin_batch& batch) { outputs(batch, at(chunk.first_point)); });
  }
}

// Flags of the last step if it has reported them, else those of a step without motion.
std::vector<std::uint32_t> current_flags(const Simulation::Impl& s, const PointRange& range) {
  if (!s.large_motion && s.lattice.flags_step == s.progress.step - 1)
    return {s.lattice.flags.begin() + range.first, s.lattice.flags.begin() + range.end};
  std::vector<std::uint32_t> result(at(range.end - range.first), 0);
  evaluate_points_at_rest(s, QUOIN_CAN_FLAGS, range, [&](quoin_batch& batch, std::size_t first) {
    batch.flags = {result.data() + first - at(range.first), 1};
  });
  return result;
}

PointRange all_points(const Simulation::Impl& s) { return whole_range(s); }

DamageColumns damage_of_points(const Simulation::Impl& s, const PointRange& range) {
  DamageColumns result;
  for (auto& column : result) column.assign(at(range.end - range.first), std::numeric_limits<double>::quiet_NaN());
  evaluate_points_at_rest(s, QUOIN_CAN_DAMAGE, range, [&](quoin_batch& batch, std::size_t first) {
    for (std::size_t k = 0; k < result.size(); ++k) batch.damage[k] = {result[k].data() + first - at(range.first), 1};
  });
  return result;
}

std::array<long, kConditionCount> condition_counts(const Simulation::Impl& s) {
  if (s.agreed.end_conditions && !has_all(s)) return *s.agreed.end_conditions;
  return conditions_here(s);
}

std::array<long, kConditionCount> conditions_here(const Simulation::Impl& s) {
  std::array<long, kConditionCount> counts{};
  for (const std::uint32_t f : current_flags(s, whole_range(s))) ++counts[static_cast<std::size_t>(condition_of(f))];
  return counts;
}

std::array<long, kConditionCount> conditions_of_all(Simulation::Impl& s) {
  std::array<long, kConditionCount> sum{};
  for (const auto& counts : of_all_ranks(*s.ranks, own_conditions(s))) {
    for (std::size_t k = 0; k < counts.size(); ++k) sum[k] += counts[k];
  }
  return sum;
}

}  // namespace quoin
