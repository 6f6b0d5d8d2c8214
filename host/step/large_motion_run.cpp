#include "step/large_motion_run.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "model/time_step.h"
#include "model/world_parts.h"
#include "model/world_results.h"
#include "scene/generate_blocks.h"
#include "scene/weight_axis.h"
#include "step/actions/actions.h"
#include "step/actions/ground.h"
#include "step/block_motion.h"
#include "step/gather.h"
#include "step/law_swap.h"
#include "step/monitor.h"
#include "step/rank_agreement.h"
#include "step/reactions.h"
#include "step/run_watch.h"
#include "step/state.h"
#include "step/supports.h"
#include "step/work_division.h"

namespace quoin {

using geometry::Vector;

namespace {

// Whether ranks may hold parts. Damage and properties that scatter need all contact points, a promotion the whole
// lattice.
bool may_ride_in_parts(const Simulation::Impl& s, const blocks::Assembly& shapes) {
  return s.ranks && !s.left && s.scene.damage.empty() &&
         std::none_of(shapes.families.begin(), shapes.families.end(),
                      [](const JointFamily& family) { return family.scatters(); });
}

}  // namespace

void build_large_motion(Simulation::Impl& s, const blocks::Assembly& shapes,
                        std::vector<std::shared_ptr<const Material>> materials) {
  s.parts.divided = may_ride_in_parts(s, shapes);
  s.large_motion = std::make_unique<blocks::Model>(shapes, s.scene.solver, std::move(materials),
                                                   s.parts.divided ? s.ranks : nullptr, &s.pool);
  find_restrained_blocks(s);
  if (s.parts.divided) {
    agree_on_model(s);
    divide_work(s);
    s.large_motion->begin(rank_by_block(s));
  } else {
    s.large_motion->part.is_shared = s.ranks;
    s.large_motion->part.fetch = [&s] { gather(s, Part::all); };
  }
  s.large_motion->track_energy(s.energy.wanted);
  build_members(s);
  find_blocks_on_base(s);
  require_moving_ground(s);
  if (!s.left) s.small_motion.extent = extent_of(*s.large_motion);
  // All names of all stages are checked before the run.
  if (!s.scene.output.monitor.empty()) blocks_named(s, s.scene.output.monitor, s.scene.file + ": output.monitor");
  for (const Stage& settings : s.scene.stages) {
    blocks_named_in(s, settings);
    support_groups(s, settings);
    watched_by(s, settings);
  }
  s.large_motion->hold_by_springs(
      whiffletree_eigenvalue(s.scene.stages, [&s](const Stage& settings, const std::string& name) {
        std::vector<double> compliances;  // 1/kg, without mass scaling, which lowers the eigenvalue
        for (const int block : blocks_named(s, name, settings.source.text))
          compliances.push_back(1.0 / s.large_motion->blocks[block].mass);
        return compliances;
      }));
  follow_time_step(s);
  s.time_step.model_mass = whole_mass(*s.large_motion);
}

std::vector<int> followed_blocks(const Simulation::Impl& s) {
  std::vector<int> followed = s.monitor.blocks;
  bool on_ground = false;  // whether a block that moves with the ground is included: one stands for all
  for (const Drive& drive : s.actions.drives) {
    if (!drive.of_ground || drive.motion > 0 || !on_ground) followed.push_back(drive.block);
    on_ground = on_ground || (drive.of_ground && drive.motion == 0);
  }
  for (const blocks::Load& given : s.large_motion->actions.loads) followed.push_back(given.block);
  for (const blocks::Pressure& given : s.large_motion->actions.pressures) followed.push_back(given.block);
  for (const std::vector<int>& floor : s.controls.floors) followed.insert(followed.end(), floor.begin(), floor.end());
  return followed;
}

void exchange_blocks_of_stage(Simulation::Impl& s, const Stage& settings, const Stage* previous) {
  std::vector<int> followed = followed_blocks(s);
  for (const Stage* named_by : {&settings, previous}) {
    if (!named_by) continue;
    const std::vector<int> named = blocks_named_in(s, *named_by);
    followed.insert(followed.end(), named.begin(), named.end());
  }
  for (const Drive& drive : s.actions.drives) {
    if (drive.of_ground) followed.push_back(drive.block);
  }
  for (int block = 0; settings.ground && block < s.large_motion->block_count(); ++block) {
    if (s.large_motion->assembly.blocks[static_cast<std::size_t>(block)].fixed) followed.push_back(block);
  }
  const std::vector<int> watched = watched_by(s, settings);
  followed.insert(followed.end(), watched.begin(), watched.end());
  std::sort(followed.begin(), followed.end());
  followed.erase(std::unique(followed.begin(), followed.end()), followed.end());
  exchange_blocks(*s.large_motion, followed);
  exchange_joints(*s.large_motion, watched);
}

// Whether a stage frees components of a block that were held before it.
bool is_freed(const blocks::Model& m, const Drive& drive) {
  if (!m.part.laid_out[at(drive.block)]) return false;
  const blocks::ModelBlock& b = m.blocks[at(drive.block)];
  if (b.body >= 0) return (m.bodies[at(b.body)].held & ~(drive.held | m.bodies[at(b.body)].support)) != 0;
  for (std::int32_t i = b.first_node; i < b.first_node + b.node_count; ++i)
    if ((m.nodes.held[at(i)] & ~(drive.held | m.nodes.support[at(i)])) != 0) return true;
  return false;
}

// Blocks that a stage frees have a frequency, which the time step may leave out while they are held.
void follow_freed_blocks(Simulation::Impl& s) {
  blocks::Model& m = *s.large_motion;
  bool freed = false;
  for (const Drive& drive : s.actions.drives) {
    if (!is_freed(m, drive)) continue;
    m.prescribe(drive.block, drive.velocity_from, drive.omega_from, drive.held);
    freed = true;
  }
  if (m.part.any(freed)) find_time_step(m);
}

void begin_large_motion_stage(Simulation::Impl& s, const Stage& settings, const Stage* previous) {
  blocks::Model& m = *s.large_motion;
  remove_forces(s);
  bind_actions(s, settings, previous);
  s.progress.stage_start = m.stepping.time;
  if (settings.solver) m.set_solver(*settings.solver);
  follow_freed_blocks(s);
  follow_time_step(s);
  watch_blocks(s, settings);
  s.monitor.start = displacement_now(s, s.monitor.blocks);
}

void swap_law_in_large_motion(Simulation::Impl& s, std::size_t index, std::shared_ptr<const Material> material) {
  const blocks::Family& f = s.large_motion->contacts.families[index];
  std::vector<double> area;
  for (const blocks::Point& p : f.point) area.push_back(p.area);
  FamilyColumns points;
  points.count = f.size();
  points.normal_jump = f.normal_jump.data();  // opening at the last law call, as the tractions
  points.area = area.data();
  for (std::size_t k = 0; k < 3; ++k) points.traction[k] = f.traction[k].data();
  for (const auto& column : f.state) points.state.push_back(column.data());
  const JointFamily& description = s.large_motion->assembly.families[index];
  const MigratedFamily migrated = migrate(description, *f.material, *material, points);
  s.laws.swaps.push_back(report_of(description.name, *f.material, *material, migrated.sums(0, points.count)));
  s.large_motion->replace_law(static_cast<int>(index), material, migrated.state, migrated.opening_shift);
  s.model.families[index].material = std::move(material);
  follow_time_step(s);
}

void end_large_motion_step(Simulation::Impl& s) {
  const long divisions = s.large_motion->chunks.divisions;
  const auto before = s.timing.now_if_timed();
  const bool moved = s.large_motion->end_step();
  if (s.timing.timed_steps > 0.0) s.timing.phases[Phase::detection] += s.timing.timed_steps * seconds_since(before);
  if (s.agreed.failed)  // no failure on this rank
    throw Error(Exit::numerical, fmt::format("step {}: another rank cannot go on", s.progress.step));
  if (moved) {
    const auto found = Clock::now();
    s.large_motion->find_contacts();
    s.timing.phases[Phase::detection] += seconds_since(found);
  }
  if (s.large_motion->chunks.divisions == divisions) return;
  partition_work(s);
  follow_time_step(s);
}

void follow_time_step(Simulation::Impl& s) {
  s.time_step.critical.value = s.large_motion->stepping.critical_dt;
  s.time_step.quiet_fraction = quiet_fraction_of(s.large_motion->solver);
  s.time_step.time_step = s.data.time_step = s.large_motion->stepping.dt;
  s.time_step.impacts = s.large_motion->impact_damping();
}

void measure_large_motion_step(Simulation::Impl& s) {
  if (s.parts.divided) gather(s, Part::row);
  s.progress.unbalanced_ratio = unbalanced_ratio(*s.large_motion);
  const Energies& e = s.large_motion->step_sums.energies;
  s.energy.kinetic = s.large_motion->measured_kinetic;
  if (s.energy.sampled) {
    Energies now;
    now.kinetic = e.kinetic, now.strain = e.strain, now.contact_stored = e.contact_stored + e.members_stored;
    const double work = e.external - e.damping - e.detection;  // since the first of the two steps
    check_energies(s, now, s.large_motion->step_sums.dissipated, work, -work);
    if (!s.watch.pending) end_check(s);
  }
  if (!s.energy.wanted) return;
  // Includes the work on the lattice before a promotion.
  const double jump = s.outcome.promotion ? s.outcome.promotion->energy_jump : 0.0;
  Energies& now = s.energy.now.emplace(e);
  for (std::size_t k = 0; k < now.dissipated.size(); ++k) now.dissipated[k] += s.energy.dissipated[k];
  now.external += s.energy.external, now.damping += s.energy.damping;
  now.detection = s.energy.lost_at_changes + e.detection - jump;
}

void check_rotations(Simulation::Impl& s) {
  for (int i = 0; i < s.large_motion->block_count(); ++i) {
    const double angle = turned(*s.large_motion, i);
    if (!(angle <= s.small_motion.seen.rotation))
      s.small_motion.seen.rotation = angle, s.small_motion.seen.turned_block = i;
  }
}

}  // namespace quoin
