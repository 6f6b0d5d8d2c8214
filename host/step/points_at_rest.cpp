#include "step/points_at_rest.h"

#include <algorithm>
#include <array>
#include <limits>

#include "base/rank_rows.h"
#include "base/ranks.h"
#include "law/at_rest.h"
#include "step/gather.h"
#include "step/lattice_motion.h"
#include "step/results.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

std::array<long, kConditionCount> own_conditions(Simulation::Impl& s) {
  const std::vector<std::uint32_t> now = current_flags(s, all_points(s));
  std::array<long, kConditionCount> counts{};
  for (const int c : s.division.share.chunks) {
    if (!s.division.share.owns_chunk(c, s.ranks->rank())) continue;
    const PointRange points = points_of_chunk(s, c);
    for (int i = points.first; i < points.end; ++i) ++counts[static_cast<std::size_t>(condition_of(now[at(i)]))];
  }
  return counts;
}

void evaluate_large_motion_at_rest(const Simulation::Impl& s, std::uint64_t capability, const PointRange& range,
                                   const PointOutputs& outputs) {
  each_chunk_in(s, range, [&](int index, const PointRange& of_chunk) {
    const blocks::Chunk& chunk = s.large_motion->chunks.all[at(index)];
    const blocks::Family& f = s.large_motion->contacts.families[at(chunk.family)];
    if (!(f.material->api().capabilities & capability)) return;
    const std::size_t first = chunk.first;
    RestingPoints points{
        chunk.count, f.normal_jump.data() + first, {}, {}, batch_columns(f.columns, *f.material, first)};
    for (std::size_t k = 0; k < 3; ++k) points.traction[k] = f.traction[k].data() + first;
    for (const auto& column : f.state) points.state.push_back(column.data() + first);
    quoin_out_u32 flags{};
    evaluate_at_rest(*f.material, points, [&](quoin_batch& batch) {
      outputs(batch, at(of_chunk.first));
      flags = batch.flags;
    });
    if (!flags.data) return;
    // Nothing slips at rest: that is asked with the slip of the last step, which steps keep.
    std::vector<std::uint32_t> in_motion(chunk.count, 0);
    evaluate_at_rest(*f.material, points, [&](quoin_batch& batch) {
      for (std::size_t k = 0; k < 2; ++k) batch.slip_increment[k] = {f.slip[k].data() + first, 1};
      batch.flags = {in_motion.data(), 1};
    });
    for (std::size_t i = 0; i < in_motion.size(); ++i)
      flags.data[static_cast<std::ptrdiff_t>(i) * flags.stride] |= in_motion[i] & QUOIN_FLAG_SLIPPING;
  });
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
  each_chunk_in(s, range, [&](int index, const PointRange& of_chunk) {
    const Material& material = *s.model.families[at(s.model.chunks[at(index)].family)].material;
    if (!(material.api().capabilities & capability)) return;
    for (std::int32_t p = of_chunk.first; p < of_chunk.end; ++p)
      normal[at(p - of_chunk.first)] = opening_at_traction(s, p);
    const BoundCall& call = s.contacts.calls[at(index)];
    const Answers last = answers_of(call);
    RestingPoints points{last.count, normal.data(), {}, last.state, call.properties};
    std::copy_n(last.traction, 3, points.traction.begin());
    evaluate_at_rest(material, points, [&](quoin_batch& batch) { outputs(batch, at(of_chunk.first)); });
  });
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

PointRange all_points(const Simulation::Impl& s) { return {0, static_cast<std::int32_t>(contact_point_count(s))}; }

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
  for (const std::uint32_t f : current_flags(s, all_points(s))) ++counts[static_cast<std::size_t>(condition_of(f))];
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
