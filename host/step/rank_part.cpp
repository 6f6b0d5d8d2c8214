#include "step/rank_part.h"

#include <algorithm>
#include <functional>
#include <optional>

#include "base/ranks.h"
#include "model/scattered_points.h"
#include "model/shared_model.h"
#include "model/world_parts.h"
#include "step/borders.h"
#include "step/large_motion_run.h"
#include "step/lattice_fields.h"
#include "step/rank_agreement.h"
#include "step/rank_sums.h"
#include "step/set_up.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

// Unit groups of this rank, ascending.
std::vector<int> own_units(const Simulation::Impl& s) {
  std::vector<int> own;
  for (int u = 0; u < static_cast<int>(s.model.unit_groups.size()); ++u) {
    if (s.division.share.owns_item(u, s.ranks->rank())) own.push_back(u);
  }
  return own;
}

template <class Column>
void release_if_any(Column& column, const VectorRow& row) {
  if (!column.empty()) release_part(column, row.first, row.end);
}

}  // namespace

HeldParts held_with(const Simulation::Impl& s, const RankShare& shares) {
  HeldParts held{std::vector<bool>(shares.rank_of_item.size()), std::vector<bool>(shares.rank_of_chunk.size())};
  for (const int c : shares.chunks) {
    held.chunks[at(c)] = true;
    each_item_of_chunk(s, c, [&](int item) { held.items[at(item)] = true; });
  }
  for (const int item : shares.items) held.items[at(item)] = true;
  for (const LoadedBlock& loaded : s.controls.loaded_blocks) held.items[at(item_of_block(s, loaded.block))] = true;
  return held;
}

// All ranks hold all bodies.
RowsElsewhere rows_elsewhere(const Simulation::Impl& s, const HeldParts& held) {
  RowsElsewhere rows;
  const std::vector<bool> units_held(held.items.begin(),
                                     held.items.begin() + static_cast<std::ptrdiff_t>(s.model.unit_groups.size()));
  each_row(units_held, false, [&](std::size_t first, std::size_t end) {
    const Model::Extent of = s.model.extent_of_units(first, end);
    rows.gridpoints.push_back({of.first_line * kLine, of.end_line * kLine});
  });
  each_row(held.chunks, false, [&](std::size_t first, std::size_t end) {
    const ContactChunk& last = s.model.chunks[end - 1];
    rows.points.push_back({at(s.model.chunks[first].first_point), at(last.first_point + last.point_count)});
  });
  return rows;
}

void each_row_elsewhere(const Simulation::Impl& s, const RowsElsewhere& rows, Owner owner, int family,
                        std::size_t numbers, const std::function<void(std::size_t, std::size_t)>& visit) {
  if (numbers == 0) return;
  if (family < 0) {
    for (const VectorRow& row : owner == Owner::gridpoint ? rows.gridpoints : rows.points) visit(row.first, row.end);
    return;
  }
  const ContactFamily& of = s.model.families[at(family)];
  const auto first = at(of.first_point), count = at(of.point_count);
  for (std::size_t column = 0; count > 0 && column < numbers; column += count) {
    for (const VectorRow& row : rows.points) {
      const std::size_t from = std::max(row.first, first), to = std::min(row.end, first + count);
      if (from < to) visit(column + from - first, column + to - first);
    }
  }
}

void hold_all(Simulation::Impl& s) {
  if (s.parts.holds_all) return;
  s.model.lay_out_all();
  s.parts.holds_all = true;
}

void hold_part(Simulation::Impl& s) {
  if (!s.parts.divided) return;
  s.parts.gathered = s.parts.gathered_by_first = s.parts.has_row = false;
  if (s.large_motion) {
    s.parts.holds_all = false;
    return hold_blocks(*s.large_motion, rank_by_block(s), followed_blocks(s));
  }
  const std::vector<int> units = own_units(s);
  s.model.keep_alone(units, s.division.share.chunks);
  s.model.lay_out(units, s.division.share.chunks);
  const HeldParts held = held_with(s, s.division.share);
  for (const LoadedBlock& loaded : s.controls.loaded_blocks) s.model.weigh(item_of_block(s, loaded.block));
  for (int u = 0; needs_rows(s.scene.solver) && u < static_cast<int>(s.model.unit_groups.size()); ++u) {
    if (held.items[at(u)]) s.model.weigh(u);
  }
  s.parts.holds_all = false;

  const RowsElsewhere elsewhere = rows_elsewhere(s, held);
  for (const VectorRow& row : elsewhere.points) {
    for (auto& column : s.contacts.force) release_if_any(column, row);
    for (auto& column : s.contacts.energy_columns) release_if_any(column, row);
  }
  each_lattice_field(s.lattice, [&](const Field& field, auto& array, int family) {
    if constexpr (requires { release_part(array, 0, 0); }) {
      if (field.known_to_all) return;
      each_row_elsewhere(s, elsewhere, field.owner, family, array.size(),
                         [&](std::size_t first, std::size_t end) { release_part(array, first, end); });
    }
  });
  if (s.inertia.dt_over_mass.empty()) return;  // the first time, before there is a time step
  const std::unique_ptr<SharedModel> shared = needs_rows(s.scene.solver) ? share_of_model(s) : nullptr;
  s.inertia.in_use = inertia_in_use(s.model, solver_in_use(s), shared.get());
  s.inertia.share(s.model, s.time_step.time_step);
  bind_columns(s);
}

void hold_first_part(Simulation::Impl& s) {
  std::optional<Error> fault;  // fault of properties drawn for this part
  try {
    hold_part(s);
  } catch (const Error& error) {
    fault = error;
  }
  throw_together(s.ranks, fault);
  std::vector<double> most;
  for (const ContactFamily& family : s.model.families) {
    for (const PropertyColumn& column : family.columns) most.push_back(column.most);
  }
  s.ranks->largest(most);
  auto next = most.begin();
  for (ContactFamily& family : s.model.families) {
    for (PropertyColumn& column : family.columns) column.most = *next++;
  }
  bound_stiffness(s.model);
}

std::unique_ptr<SharedModel> share_of_model(Simulation::Impl& s) {
  std::vector<int> rank_of_body;
  for (const RigidBody& body : s.model.bodies)
    rank_of_body.push_back(s.division.share.rank_of_item[at(item_of_block(s, body.block))]);
  const auto bodies = at(s.model.line_count) * kLine;
  return std::make_unique<RankSums>(
      s.model, s.division.share, own_units(s), rank_of_body, *s.ranks, [&s, bodies](LaneVector<double>& vector) {
        return halo_on_borders(s, [&](int block, std::int32_t gridpoint, std::vector<double*>& numbers) {
          const int body = s.model.place[at(block)].body;
          for (std::size_t k = 0; body >= 0 && k < 6; ++k) numbers.push_back(&vector[bodies + 6 * at(body) + k]);
          for (std::size_t c = 0; body < 0 && c < 3; ++c) numbers.push_back(&vector[at(gridpoint) + c * kLanes]);
        });
      });
}

}  // namespace quoin
