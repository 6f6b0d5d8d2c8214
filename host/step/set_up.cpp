// From scene and bricks to the arrays that the step goes over.
#include <algorithm>
#include <cmath>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "base/error.h"
#include "step/state.h"

namespace quoin {

Simulation::Impl::Impl(Scene scene_in, Assembly assembly, int threads,
                       std::vector<std::shared_ptr<const Material>> materials, const blocks::Assembly* shapes,
                       Ranks* ranks_in)
    : scene(std::move(scene_in)),
      pool(threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
      want_energy(scene.output.energy),
      keep_diagnostics(scene.output.energy),
      ranks(ranks_in) {
  if (ranks) begin_with_ranks();
  take_bricks(std::move(assembly), materials);
  for (const ContactFamily& family : model.families) first_materials.push_back(family.material);
  if (shapes) build_large_motion(*shapes, std::move(materials));
  if (!shapes) require_moving_ground(), find_base_of_lattice();
  // Every name of every stage is looked up before anything runs.
  for (std::size_t i = 0; !shapes && i < scene.stages.size(); ++i) support_groups(scene.stages[i]);
  find_restraints();
  take_damage();
  const auto before = Clock::now();
  bind_step();
  if (!ranks) return;
  agree_on_model();
  note_start();
  const double took = largest_of_ranks(seconds_since(before));
  if (!costly_blocks) balance.costs(took);
#ifdef __GLIBC__
  malloc_trim(0);  // what building has left free: several ranks may share a machine
#endif
}

void Simulation::Impl::bind_step() {
  data.time_step = time_step.time_step;
  data.internal_forces = scene.solver.internal_forces;
  data.energies = want_energy;
  const SolverSettings& solver = solver_in_use();
  data.damping = solver.damping;
  data.mass_damping = solver.damping == DampingKind::viscous ? solver.mass_damping : 0.0;
  data.stiffness_damping = time_step.stiffness_damping;
  choose_damping();
  bind_columns();
  measured_over_estimated.clear();
  partition_work();
}

void Simulation::Impl::take_bricks(Assembly assembly, const std::vector<std::shared_ptr<const Material>>& materials) {
  in_parts = ranks && !assembly.bricks.empty();
  holds_all = !in_parts;
  model = Model(std::move(assembly), materials, in_parts ? LayOut::nothing : LayOut::all);
  joint_sliding =
      JointSliding(model.assembly, in_parts ? JointSliding::Places::recomputed : JointSliding::Places::kept);
  unjoined = UnjoinedBlocks(model.assembly);
  if (!model.assembly.bricks.empty()) extent = diagonal_of(model.assembly.bricks);
  meeting_family = {};
  normal_shift.clear();
  body_lanes.clear(), body_place.clear(), group_inertia.clear(), ramps.clear();
  loaded_blocks.clear(), load_of_group.clear(), load_ramps.clear();
  shared_dt_over_mass.clear(), inertia_tables.clear();
  law_state.clear(), calls.clear();
  monitor.clear(), monitor_loaded.clear(), monitor_points.clear(), ramped_bodies.clear(), whole_motions.clear();
  find_loaded_blocks();
  measured.resize(model.unit_groups.size() + model.body_groups.size() + model.lone_bodies.size());
  body_lanes.resize(model.body_groups.size() + model.lone_bodies.size());
  body_place.resize(model.bodies.size());
  for (std::size_t g = 0; g < model.body_groups.size(); ++g) {
    const BodyGroup& group = model.body_groups[g];
    for (int lane = 0; lane < group.body_count; ++lane)
      body_place[static_cast<std::size_t>(group.body[static_cast<std::size_t>(lane)])] = {static_cast<int>(g), lane};
  }
  for (std::size_t i = 0; i < model.lone_bodies.size(); ++i)
    body_place[static_cast<std::size_t>(model.lone_bodies[i])] = {static_cast<int>(model.body_groups.size() + i), 0};
  std::unique_ptr<SharedModel> shared;
  if (in_parts) {
    agree_on_model();
    divide_work();
    hold_first_part();
    shared = share_of_model();
  }
  inertia = {};
  time_step = {};
  if (!model.assembly.bricks.empty())
    time_step = choose_time_step(model, solver_in_use(), &inertia, Limits::critical, scene.stages, shared.get());
  shared.reset();
  const auto doubles = static_cast<std::size_t>(model.line_count) * kLine;
  const auto points = static_cast<std::size_t>(model.point_count);
  displacement.assign(doubles, 0.0);
  velocity.assign(doubles, 0.0);
  for (auto& column : traction) column.assign(points, 0.0);
  for (auto& column : force) column.assign(points + kLanes, 0.0);
  flags.assign(points, 0);
  for (auto& column : energy_columns) column.assign(want_energy ? points : 0, 0.0);
  ramps.resize(model.bodies.size());
  for (const BodyGroup& group : model.body_groups)
    group_inertia.push_back(inertia_of(group, model, inertia, time_step.time_step));
  share_inertia();
  begin_states();
  begin_damping();
}

// A step that a stage has chosen begins at the time of the displacements; velocities stay those of half a step before.
void Simulation::Impl::follow_solver() {
  clock_start = now(), clock_start_step = step_count;
  std::unique_ptr<SharedModel> shared;
  if (in_parts) shared = share_of_model();
  time_step = choose_time_step(model, solver_in_use(), &inertia, Limits::critical, scene.stages, shared.get());
  shared.reset();
  group_inertia.clear();
  for (const BodyGroup& group : model.body_groups)
    group_inertia.push_back(inertia_of(group, model, inertia, time_step.time_step));
  share_inertia();
  begin_damping();
  bind_step();
}

// Impact damping of contact points that are laid out. It begins without a rate, as there was no step yet.
void Simulation::Impl::begin_damping() {
  const std::size_t points = time_step.impacts.viscosity.empty() ? 0 : static_cast<std::size_t>(model.point_count);
  for (auto& column : viscous) column.assign(points, 0.0);
  old_jump.assign(points, 0.0);
  for (const int c : chunks_here()) {
    const ContactChunk& chunk = model.chunks[static_cast<std::size_t>(c)];
    if (points > 0) std::fill_n(old_jump.begin() + chunk.first_point, chunk.point_count, std::nan(""));
  }
  const bool implicit = points > 0 && solver_in_use().implicit_contacts;
  implicit_contacts = implicit ? ImplicitContacts(model, inertia.node) : ImplicitContacts();
  if (implicit)
    implicit_end =
        shares(std::vector<double>(static_cast<std::size_t>(implicit_contacts.pieces()), 1.0), pool.thread_count());
}

std::vector<int> Simulation::Impl::chunks_here() const {
  return holds_all ? whole_share(static_cast<int>(model.chunks.size()), 0).chunks : share.chunks;
}

// Of points that are laid out.
void Simulation::Impl::begin_states() {
  std::vector<std::vector<double>> initial;  // by family and column
  for (std::size_t f = 0; f < model.families.size(); ++f) {
    initial.push_back(model.families[f].material->initial_state(model.assembly.families[f].initial_state));
    law_state.emplace_back(initial[f].size() * static_cast<std::size_t>(model.families[f].point_count));
  }
  for (const int c : chunks_here()) {
    const ContactChunk& chunk = model.chunks[static_cast<std::size_t>(c)];
    const ContactFamily& family = model.families[static_cast<std::size_t>(chunk.family)];
    auto first = law_state[static_cast<std::size_t>(chunk.family)].begin() + (chunk.first_point - family.first_point);
    for (const double value : initial[static_cast<std::size_t>(chunk.family)]) {
      if (value != 0.0) std::fill_n(first, chunk.point_count, value);
      first += family.point_count;
    }
  }
}

// Of the gridpoints that are laid out.
void Simulation::Impl::share_inertia() {
  const std::size_t doubles = model.node_free.size();
  dt_over_mass = LaneVector<double>(doubles);
  for (std::size_t i = 0; i < doubles; ++i) {
    if (model.node_free[i] != 0.0 && inertia.node[i] > 0.0)
      dt_over_mass[i] = time_step.time_step / (inertia.deformation * inertia.node[i]);
  }
  shared_dt_over_mass.clear(), inertia_tables.clear();
  for (const BlockGroup& group : model.groups) {
    std::vector<double> table;
    bool uniform = true;
    for (int n = 0; n < model.templates[static_cast<std::size_t>(group.brick_template)].node_count; ++n) {
      for (int c = 0; c < 3; ++c) {
        const double* lane = dt_over_mass.data() + (group.first_line + n) * kLine + c * kLanes;
        table.push_back(lane[0]);
        uniform = uniform && std::all_of(lane, lane + group.block_count, [&](double x) { return x == lane[0]; });
      }
    }
    shared_dt_over_mass.push_back(uniform ? inertia_tables.insert(std::move(table)).first->data() : nullptr);
  }
}

void Simulation::Impl::bind_columns() {
  data.displacement = displacement.data();
  data.velocity = velocity.data();
  data.dt_over_mass = dt_over_mass.data();
  data.shared_dt_over_mass = shared_dt_over_mass.data();
  data.load = load_of_group.data();
  data.deformation_inertia = inertia.deformation;
  data.unit_inertia = inertia.unit;
  data.block_motion = inertia.rigid.block.empty() ? nullptr : inertia.rigid.block.data();
  data.unit_motion = inertia.rigid.unit.empty() ? nullptr : inertia.rigid.unit.data();
  data.normal_shift = normal_shift.empty() ? nullptr : normal_shift.data();
  for (std::size_t k = 0; k < 3; ++k) {
    data.traction[k] = traction[k].data();
    data.force[k] = force[k].data();
  }
  calls.resize(model.chunks.size());
  for (std::size_t c = 0; c < model.chunks.size(); ++c) {
    const ContactChunk& chunk = model.chunks[c];
    const auto f = static_cast<std::size_t>(chunk.family);
    const ContactFamily& family = model.families[f];
    const quoin_law& law = family.material->api();
    LawCall& call = calls[c];
    call.state_old.clear();
    call.state_new.clear();
    for (std::uint64_t k = 0; k < law.state_count; ++k) {
      double* column = law_state[f].data() + k * static_cast<std::size_t>(family.point_count) +
                       (chunk.first_point - family.first_point);
      if (law.states[k]->role == QUOIN_ROLE_DIAGNOSTIC && !keep_diagnostics) column = nullptr;
      call.state_old.push_back({column, 1});
      call.state_new.push_back({column, 1});
    }
    call.batch = {};
    call.batch.struct_size = sizeof(quoin_batch);
    call.batch.count = static_cast<std::uint64_t>(chunk.point_count);
    for (std::size_t k = 0; k < 3; ++k) {
      call.batch.traction_old[k] = {traction[k].data() + chunk.first_point, 1};
      call.batch.traction_new[k] = {traction[k].data() + chunk.first_point, 1};
    }
    call.batch.state_old = call.state_old.data();
    call.batch.state_new = call.state_new.data();
    call.properties = batch_columns(family.columns, *family.material,
                                    static_cast<std::size_t>(chunk.first_point - family.first_point));
    call.batch.property_column_count = call.properties.size();
    call.batch.property_columns = call.properties.data();
    if (want_energy && (law.capabilities & QUOIN_CAN_ENERGY)) bind_energies(call, chunk);
  }
}

void Simulation::Impl::bind_energies(LawCall& call, const ContactChunk& chunk) {
  call.batch.energy_stored = {energy_columns[0].data() + chunk.first_point, 1};
  for (std::size_t k = 0; k < 4; ++k) call.batch.dissipated[k] = {energy_columns[k + 1].data() + chunk.first_point, 1};
}

void Simulation::Impl::partition_work() {
  divide_work();
  hold_part();
  bind_work();
}

void Simulation::Impl::divide_work() {
  chunk_cost.clear(), item_cost.clear(), unit_of_group.clear();
  for (const ContactChunk& chunk : model.chunks) chunk_cost.push_back(chunk.point_count);
  for (int c = 0; large_motion && c < large_motion->chunk_count(); ++c)
    chunk_cost.push_back(large_motion->chunk_work(c));

  // One contact point of a lone body costs about as much as 20 coefficients of a group, 8 of a body group as 12.
  constexpr double kBodyPoint = 20.0, kBodySlot = 12.0;
  largest_group = 0;
  for (const UnitGroup& unit : model.unit_groups) {
    item_cost.push_back(0.0);
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      unit_of_group.push_back(static_cast<int>(item_cost.size()) - 1);
      const BlockGroup& group = model.groups[static_cast<std::size_t>(g)];
      const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
      item_cost.back() += static_cast<double>(shape.stiffness.coefficient.size());
      largest_group = std::max(largest_group, static_cast<std::size_t>(shape.node_count) * kLine);
    }
  }
  for (const BodyGroup& group : model.body_groups)
    item_cost.push_back(kBodySlot * (model.body_slots[static_cast<std::size_t>(group.slots)].slot_count() + 8.0));
  for (const int b : model.lone_bodies)
    item_cost.push_back(kBodyPoint *
                        (static_cast<double>(model.bodies[static_cast<std::size_t>(b)].point.size()) + 2.0));
  for (int p = 0; large_motion && p < large_motion->piece_count(); ++p)
    item_cost.push_back(large_motion->piece_work(p));
  item_by_block.assign(large_motion ? static_cast<std::size_t>(large_motion->block_count()) : 0, -1);
  for (int p = 0; large_motion && p < large_motion->piece_count(); ++p) {
    for (const std::int32_t block : large_motion->blocks_of_piece(p))
      item_by_block[static_cast<std::size_t>(block)] = p;
  }
  restrained_of_item.assign(item_cost.size(), {});
  for (const int block : restrained_blocks) {
    const int item = large_motion ? item_by_block[static_cast<std::size_t>(block)] : -1;
    if (item >= 0) restrained_of_item[static_cast<std::size_t>(item)].push_back(block);
  }
  share = share_of_this_rank();
}

void Simulation::Impl::bind_work() {
  bind_halo();
  const auto ends = [&](std::span<const int> pieces, const std::vector<double>& cost) {
    std::vector<double> weight;
    for (const int i : pieces) weight.push_back(cost[static_cast<std::size_t>(i)]);
    return shares(weight, pool.thread_count());
  };
  chunk_end = ends(share.chunks, chunk_cost);
  border_end = ends(std::span(share.items).first(share.border_items), item_cost);
  item_end = ends(std::span(share.items).subspan(share.border_items), item_cost);
  data.scratch_doubles = kScratchColumns * largest_group;
  for (int t = static_cast<int>(scratch.size()); t < pool.thread_count(); ++t) {
    scratch.emplace_back(kUnitBlocks * data.scratch_doubles, 0.0);
    jumps.push_back(std::make_unique<ChunkJumps>());
    clocks.emplace_back();
  }
}

}  // namespace quoin
