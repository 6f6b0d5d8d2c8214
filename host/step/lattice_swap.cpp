#include "step/lattice_swap.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "step/lattice_motion.h"
#include "step/law_swap.h"
#include "step/promotion.h"
#include "step/rank_agreement.h"
#include "step/set_up.h"
#include "step/state.h"

namespace quoin {

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
  throw_together(s, fault);

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
