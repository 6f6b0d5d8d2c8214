// What each rank holds of a model on the lattice, where it is held in parts, and the highest frequency of all of it.
//
// Arrays have the numbers of the whole model; memory they have where this rank works (base/sparse_memory.h). That is
// for own items, the chunks that touch them, and what those chunks touch of others.
#include <algorithm>

#include "model/scattered_points.h"
#include "step/lattice_fields.h"
#include "step/rank_sums.h"

namespace quoin {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

template <class Column>
void forget_if_any(Column& column, const VectorRow& row) {
  if (!column.empty()) forget_part(column, row.first, row.end);
}

}  // namespace

std::vector<int> Simulation::Impl::own_units() const {
  std::vector<int> own;
  for (int u = 0; u < static_cast<int>(model.unit_groups.size()); ++u) {
    if (share.owns_item(u, ranks->rank())) own.push_back(u);
  }
  return own;
}

Simulation::Impl::Held Simulation::Impl::held_with(const RankShare& shares) const {
  Held held{std::vector<bool>(shares.rank_of_item.size()), std::vector<bool>(shares.rank_of_chunk.size())};
  for (const int c : shares.chunks) {
    held.chunks[at(c)] = true;
    each_item(c, [&](int item) { held.items[at(item)] = true; });
  }
  for (const int item : shares.items) held.items[at(item)] = true;
  for (const LoadedBlock& loaded : loaded_blocks) held.items[at(item_of_block(loaded.block))] = true;
  return held;
}

// Bodies are held by all.
Simulation::Impl::Rows Simulation::Impl::rows_elsewhere(const Held& held) const {
  Rows rows;
  const std::vector<bool> units_held(held.items.begin(),
                                     held.items.begin() + static_cast<std::ptrdiff_t>(model.unit_groups.size()));
  each_row(units_held, false, [&](std::size_t first, std::size_t end) {
    const Model::Extent of = model.extent_of_units(first, end);
    rows.gridpoints.push_back({of.first_line * kLine, of.end_line * kLine});
  });
  each_row(held.chunks, false, [&](std::size_t first, std::size_t end) {
    const ContactChunk& last = model.chunks[end - 1];
    rows.points.push_back({at(model.chunks[first].first_point), at(last.first_point + last.point_count)});
  });
  return rows;
}

void Simulation::Impl::each_row_elsewhere(const Rows& rows, Owner owner, int family, std::size_t numbers,
                                          const std::function<void(std::size_t, std::size_t)>& visit) const {
  if (numbers == 0) return;
  if (family < 0) {
    for (const VectorRow& row : owner == Owner::gridpoint ? rows.gridpoints : rows.points) visit(row.first, row.end);
    return;
  }
  const ContactFamily& of = model.families[at(family)];
  const auto first = at(of.first_point), count = at(of.point_count);
  for (std::size_t column = 0; count > 0 && column < numbers; column += count) {
    for (const VectorRow& row : rows.points) {
      const std::size_t from = std::max(row.first, first), to = std::min(row.end, first + count);
      if (from < to) visit(column + from - first, column + to - first);
    }
  }
}

void Simulation::Impl::hold_all() {
  if (holds_all) return;
  model.lay_out_all();
  holds_all = true;
}

void Simulation::Impl::hold_part() {
  if (!in_parts) return;
  gathered = gathered_by_first = has_row = false;
  if (large_motion) {
    holds_all = false;
    return large_motion->hold(rank_by_block(), followed_blocks());
  }
  const std::vector<int> units = own_units();
  model.keep_alone(units, share.chunks);
  model.lay_out(units, share.chunks);
  const Held held = held_with(share);
  for (const LoadedBlock& loaded : loaded_blocks) model.weigh(item_of_block(loaded.block));
  for (int u = 0; needs_rows(scene.solver) && u < static_cast<int>(model.unit_groups.size()); ++u) {
    if (held.items[at(u)]) model.weigh(u);
  }
  holds_all = false;

  const Rows elsewhere = rows_elsewhere(held);
  for (const VectorRow& row : elsewhere.points) {
    for (auto& column : force) forget_if_any(column, row);
    for (auto& column : energy_columns) forget_if_any(column, row);
  }
  each_lattice_field(*this, [&](const Field& field, auto& array, int family) {
    if constexpr (requires { forget_part(array, 0, 0); }) {
      if (field.known_to_all) return;
      each_row_elsewhere(elsewhere, field.owner, family, array.size(),
                         [&](std::size_t first, std::size_t end) { forget_part(array, first, end); });
    }
  });
  if (dt_over_mass.empty()) return;  // the first time, before there is a time step
  const std::unique_ptr<SharedModel> shared = needs_rows(scene.solver) ? share_of_model() : nullptr;
  inertia = inertia_in_use(model, solver_in_use(), shared.get());
  share_inertia();
  bind_columns();
}

void Simulation::Impl::throw_together(const std::optional<Error>& fault) {
  if (!ranks) {
    if (fault) throw *fault;
    return;
  }
  const int count = ranks->count();
  const std::string text = fault ? fault->what() : "";
  // The lowest rank, and what it has to say: its exit code, and how long its words are.
  const double first = count - largest_of_ranks(fault ? count - ranks->rank() : 0.0);
  if (first == count) return;
  const bool here = ranks->rank() == static_cast<int>(first);
  double shared[] = {here ? static_cast<double>(fault->exit_code) : 0.0, here ? static_cast<double>(text.size()) : 0.0};
  ranks->largest(shared);
  std::vector<std::size_t> sizes(at(count));
  sizes[static_cast<std::size_t>(first)] = static_cast<std::size_t>(shared[1]);
  std::string of_first(static_cast<std::size_t>(shared[1]), ' ');
  ranks->gather(std::as_bytes(std::span(here ? text : std::string())), sizes,
                std::as_writable_bytes(std::span(of_first)));
  throw Error(static_cast<Exit>(static_cast<int>(shared[0])), of_first);
}

void Simulation::Impl::hold_first_part() {
  std::optional<Error> fault;  // of properties drawn for this part
  try {
    hold_part();
  } catch (const Error& error) {
    fault = error;
  }
  throw_together(fault);
  std::vector<double> most;
  for (const ContactFamily& family : model.families) {
    for (const PropertyColumn& column : family.columns) most.push_back(column.most);
  }
  ranks->largest(most);
  auto next = most.begin();
  for (ContactFamily& family : model.families) {
    for (PropertyColumn& column : family.columns) column.most = *next++;
  }
  bound_stiffness(model);
}

std::unique_ptr<SharedModel> Simulation::Impl::share_of_model() {
  std::vector<int> rank_of_body;
  for (const RigidBody& body : model.bodies) rank_of_body.push_back(share.rank_of_item[at(item_of_block(body.block))]);
  const auto bodies = at(model.line_count) * kLine;
  return std::make_unique<RankSums>(
      model, share, own_units(), rank_of_body, *ranks, [this, bodies](LaneVector<double>& vector) {
        return halo_on_borders([&](int block, std::int32_t gridpoint, std::vector<double*>& numbers) {
          const int body = model.place[at(block)].body;
          for (std::size_t k = 0; body >= 0 && k < 6; ++k) numbers.push_back(&vector[bodies + 6 * at(body) + k]);
          for (std::size_t c = 0; body < 0 && c < 3; ++c) numbers.push_back(&vector[at(gridpoint) + c * kLanes]);
        });
      });
}

}  // namespace quoin
