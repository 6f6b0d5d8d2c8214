#include "step/set_up.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>

#include "model/shared_model.h"
#include "model/time_step.h"
#include "step/actions/ground.h"
#include "step/block_motion.h"
#include "step/existing_damage.h"
#include "step/large_motion_run.h"
#include "step/rank_agreement.h"
#include "step/rank_part.h"
#include "step/reactions.h"
#include "step/results.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/state_hash.h"
#include "step/supports.h"
#include "step/work_division.h"

namespace quoin {

namespace {

// Begins damping of joints at the contact points that this rank holds. Before the first step there is no rate.
void begin_damping(Simulation::Impl& s) {
  const std::size_t points = s.time_step.damps_joints() ? static_cast<std::size_t>(s.model.point_count) : 0;
  for (auto& column : s.lattice.viscous) column.assign(points, 0.0);
  s.lattice.old_jump.assign(points, 0.0);
  for (BoundCall& call : s.contacts.calls) call.damping = 0.0;
  for (const int c : chunks_here(s)) {
    const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(c)];
    if (points > 0) std::fill_n(s.lattice.old_jump.begin() + chunk.first_point, chunk.point_count, std::nan(""));
  }
  const bool implicit = points > 0 && damping_of(solver_in_use(s)).is_implicit();
  s.contacts.implicit = implicit ? ImplicitContacts(s.model, s.inertia.in_use.node) : ImplicitContacts();
  if (implicit)
    s.contacts.implicit_end =
        shares(std::vector<double>(static_cast<std::size_t>(s.contacts.implicit.pieces()), 1.0), s.pool.thread_count());
}

void choose_time_step(Simulation::Impl& s) {
  const std::unique_ptr<SharedModel> shared = s.parts.divided ? share_of_model(s) : nullptr;
  s.time_step =
      choose_time_step(s.model, solver_in_use(s), &s.inertia.in_use, Limits::critical, s.scene.stages, shared.get());
}

void bind_inertia(Simulation::Impl& s) {
  s.inertia.bind_body_groups(s.model, s.time_step.time_step);
  s.inertia.share(s.model, s.time_step.time_step);
}

// Sets the initial states of the contact points that this rank holds.
void begin_states(Simulation::Impl& s) {
  std::vector<std::vector<double>> initial;  // by family and column
  for (std::size_t f = 0; f < s.model.families.size(); ++f) {
    initial.push_back(s.model.families[f].material->initial_state(s.model.assembly.families[f].initial_state));
    s.lattice.law_state.emplace_back(initial[f].size() * static_cast<std::size_t>(s.model.families[f].point_count));
  }
  for (const int c : chunks_here(s)) {
    const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(c)];
    const ContactFamily& family = s.model.families[static_cast<std::size_t>(chunk.family)];
    auto first =
        s.lattice.law_state[static_cast<std::size_t>(chunk.family)].begin() + (chunk.first_point - family.first_point);
    for (const double value : initial[static_cast<std::size_t>(chunk.family)]) {
      if (value != 0.0) std::fill_n(first, chunk.point_count, value);
      first += family.point_count;
    }
  }
}

}  // namespace

Simulation::Impl::Impl(Scene scene_in, int threads, Ranks* ranks_in)
    : scene(std::move(scene_in)),
      pool(threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
      ranks(ranks_in) {
  energy.wanted = contacts.keep_diagnostics = scene.output.energy;
}

void set_up(Simulation::Impl& s, Assembly assembly, std::vector<std::shared_ptr<const Material>> materials,
            const blocks::Assembly* shapes) {
  if (s.ranks) begin_with_ranks(s);
  take_bricks(s, std::move(assembly), materials);
  for (const ContactFamily& family : s.model.families) s.laws.first.push_back(family.material);
  if (shapes) build_large_motion(s, *shapes, std::move(materials));
  if (!shapes) require_moving_ground(s), find_base_of_lattice(s);
  // All names of all stages are checked before the run.
  for (std::size_t i = 0; !shapes && i < s.scene.stages.size(); ++i) support_groups(s, s.scene.stages[i]);
  find_restraints(s);
  take_damage(s);
  const auto before = Clock::now();
  bind_step(s);
  if (!s.ranks) return;
  agree_on_model(s);
  note_start(s);
  const double took = largest_of_ranks(s, seconds_since(before));
  if (!s.rank_load.costly_blocks) s.rank_load.balance.costs(took);
#ifdef __GLIBC__
  malloc_trim(0);  // returns free memory of set-up to the system: several ranks may share a machine
#endif
}

void bind_step(Simulation::Impl& s) {
  s.data.time_step = s.time_step.time_step;
  s.data.internal_forces = s.scene.solver.internal_forces;
  s.data.energies = s.energy.wanted;
  s.data.stiffness_damping = s.time_step.stiffness_damping;
  choose_damping(s);
  bind_columns(s);
  s.rank_load.measured_over_estimated.clear();
  partition_work(s);
}

void take_bricks(Simulation::Impl& s, Assembly assembly,
                 const std::vector<std::shared_ptr<const Material>>& materials) {
  s.parts.divided = s.ranks && !assembly.bricks.empty();
  s.parts.holds_all = !s.parts.divided;
  s.model = Model(std::move(assembly), materials, s.parts.divided ? LayOut::nothing : LayOut::all);
  s.small_motion.joint_sliding =
      JointSliding(s.model.assembly, s.parts.divided ? JointSliding::Places::recomputed : JointSliding::Places::kept);
  s.small_motion.unjoined = UnjoinedBlocks(s.model.assembly);
  if (!s.model.assembly.bricks.empty()) s.small_motion.extent = diagonal_of(s.model.assembly.bricks);
  s.small_motion.meeting_family = {};
  s.lattice.normal_shift.clear();
  s.lattice.bodies.clear(), s.lattice.place.clear(), s.actions.drives.clear();
  s.inertia.shared_dt_over_mass.clear(), s.inertia.tables.clear();
  s.lattice.law_state.clear(), s.contacts.calls.clear();
  s.monitor.blocks = {};
  s.monitor.points.clear(), s.small_motion.whole_motions.clear();
  s.controls.find_loaded_blocks(s.model);
  s.division.measured.resize(s.model.unit_groups.size() + s.model.body_groups.size() + s.model.lone_bodies.size());
  s.lattice.bodies.resize(s.model.body_groups.size() + s.model.lone_bodies.size());
  s.lattice.place.resize(s.model.bodies.size());
  for (std::size_t g = 0; g < s.model.body_groups.size(); ++g) {
    const BodyGroup& group = s.model.body_groups[g];
    for (int lane = 0; lane < group.body_count; ++lane)
      s.lattice.place[static_cast<std::size_t>(group.body[static_cast<std::size_t>(lane)])] = {static_cast<int>(g),
                                                                                               lane};
  }
  for (std::size_t i = 0; i < s.model.lone_bodies.size(); ++i)
    s.lattice.place[static_cast<std::size_t>(s.model.lone_bodies[i])] = {
        static_cast<int>(s.model.body_groups.size() + i), 0};
  if (s.parts.divided) {
    agree_on_model(s);
    divide_work(s);
    hold_first_part(s);
  }
  s.inertia.in_use = {};
  s.time_step = {};
  if (!s.model.assembly.bricks.empty()) choose_time_step(s);
  const auto doubles = static_cast<std::size_t>(s.model.line_count) * kLine;
  const auto points = static_cast<std::size_t>(s.model.point_count);
  s.lattice.displacement.assign(doubles, 0.0);
  s.lattice.velocity.assign(doubles, 0.0);
  for (auto& column : s.lattice.traction) column.assign(points, 0.0);
  for (auto& column : s.contacts.force) column.assign(points + kLanes, 0.0);
  s.lattice.flags.assign(points, 0);
  for (auto& column : s.contacts.energy_columns) column.assign(s.energy.wanted ? points : 0, 0.0);
  bind_inertia(s);
  for (int block = 0; block < block_count(s); ++block)
    if (is_fixed(s, block)) prescribe(s, block, {}, {}, kAllPrescribed);
  begin_states(s);
  begin_damping(s);
}

// Changes to the time step of a stage. It holds from the time of the displacements on; velocities are those of half an
// old step before.
void follow_solver(Simulation::Impl& s) {
  s.progress.clock_start = time_now(s), s.progress.clock_start_step = s.progress.step;
  choose_time_step(s);
  bind_inertia(s);
  begin_damping(s);
  bind_step(s);
}

void bind_columns(Simulation::Impl& s) {
  s.data.displacement = s.lattice.displacement.data();
  s.data.velocity = s.lattice.velocity.data();
  s.data.dt_over_mass = s.inertia.dt_over_mass.data();
  s.data.shared_dt_over_mass = s.inertia.shared_dt_over_mass.data();
  s.data.load = s.controls.load_of_group.data();
  s.data.deformation_inertia = s.inertia.in_use.deformation;
  s.data.unit_inertia = s.inertia.in_use.unit;
  s.data.block_motion = s.inertia.in_use.rigid.block.empty() ? nullptr : s.inertia.in_use.rigid.block.data();
  s.data.unit_motion = s.inertia.in_use.rigid.unit.empty() ? nullptr : s.inertia.in_use.rigid.unit.data();
  s.data.normal_shift = s.lattice.normal_shift.empty() ? nullptr : s.lattice.normal_shift.data();
  for (std::size_t k = 0; k < 3; ++k) {
    s.data.traction[k] = s.lattice.traction[k].data();
    s.data.force[k] = s.contacts.force[k].data();
  }
  s.contacts.calls.resize(s.model.chunks.size()), s.contacts.sums.resize(s.model.chunks.size());
  for (std::size_t c = 0; c < s.model.chunks.size(); ++c) {
    const ContactChunk& chunk = s.model.chunks[c];
    const auto f = static_cast<std::size_t>(chunk.family);
    const ContactFamily& family = s.model.families[f];
    const quoin_law& law = family.material->api();
    CallColumns columns{static_cast<std::size_t>(chunk.point_count),
                        {},
                        {},
                        batch_columns(family.columns, *family.material,
                                      static_cast<std::size_t>(chunk.first_point - family.first_point))};
    for (std::size_t k = 0; k < 3; ++k) columns.traction[k] = s.lattice.traction[k].data() + chunk.first_point;
    for (std::uint64_t k = 0; k < law.state_count; ++k) {
      columns.state.push_back(!keeps_state(s, law, k)
                                  ? nullptr
                                  : s.lattice.law_state[f].data() + k * static_cast<std::size_t>(family.point_count) +
                                        (chunk.first_point - family.first_point));
    }
    BoundCall& call = s.contacts.calls[c];
    call.bind(std::move(columns));
    if (s.energy.wanted && (law.capabilities & QUOIN_CAN_ENERGY)) s.contacts.bind_energies(call, chunk);
  }
}

}  // namespace quoin
