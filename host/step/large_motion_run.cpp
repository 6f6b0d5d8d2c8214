// Blocks that move without bound: what stages do to them, and what the history shows of them.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "law/at_rest.h"
#include "members/members.h"
#include "model/time_step.h"
#include "scene/generate_blocks.h"
#include "step/law_swap.h"
#include "step/monitor_side.h"
#include "step/state.h"

namespace quoin {

using geometry::Vector;

void Simulation::Impl::build_large_motion(const blocks::Assembly& shapes,
                                          std::vector<std::shared_ptr<const Material>> materials) {
  in_parts = may_ride_in_parts(shapes);
  large_motion =
      std::make_unique<blocks::Model>(shapes, scene.solver, std::move(materials), in_parts ? ranks : nullptr);
  find_restrained_blocks();
  if (in_parts) {
    agree_on_model();
    divide_work();
    large_motion->begin(rank_by_block());
  } else {
    large_motion->before_dividing([this] { gather(Part::all); });
  }
  large_motion->track_energy(want_energy);
  build_members();
  find_blocks_on_base();
  require_moving_ground();
  if (!left) extent = large_motion->extent();
  // Every name of every stage is looked up before anything runs.
  for (const Stage& s : scene.stages) {
    blocks_named_in(s);
    support_groups(s);
    const std::string& watched = watched_block(s);
    if (!watched.empty()) blocks_named(watched, s.source.text + ": monitor");
    if (s.displacement && watched.empty())
      throw Error(Exit::bad_input,
                  fmt::format("{}: stage '{}' ends by displacement but has no monitor; give stage.monitor or "
                              "output.monitor, the name of a block",
                              s.source.text, s.name));
  }
  large_motion->hold_by_springs(whiffletree_eigenvalue(scene.stages, [this](const Stage& s, const std::string& name) {
    std::vector<double> compliances;  // scaled masses are larger, and safe
    for (const int block : blocks_named(name, s.source.text)) compliances.push_back(1.0 / large_motion->mass_of(block));
    return compliances;
  }));
  follow_time_step();
  time_step.model_mass = large_motion->mass();
}

// Damage and properties that scatter are found over all contact points; a promotion hands over all of a lattice.
bool Simulation::Impl::may_ride_in_parts(const blocks::Assembly& shapes) const {
  return ranks && !left && scene.damage.empty() &&
         std::none_of(shapes.families.begin(), shapes.families.end(),
                      [](const JointFamily& family) { return family.scatters(); });
}

std::vector<int> Simulation::Impl::rank_by_block() const {
  std::vector<int> rank;
  for (const int item : item_by_block) rank.push_back(share.rank_of_item[static_cast<std::size_t>(item)]);
  return rank;
}

// What every rank follows through a stage, whoever advances it.
std::vector<int> Simulation::Impl::followed_blocks() const {
  std::vector<int> followed = monitor_blocks;
  bool on_ground = false;  // which moves as its record says: one block stands for all
  for (const Drive& drive : drives) {
    if (!drive.of_ground || drive.motion > 0 || !on_ground) followed.push_back(drive.block);
    on_ground = on_ground || (drive.of_ground && drive.motion == 0);
  }
  for (const blocks::Load& given : large_motion->loads()) followed.push_back(given.block);
  for (const blocks::Pressure& given : large_motion->pressures()) followed.push_back(given.block);
  for (const Floor& floor : whiffletree)
    followed.insert(followed.end(), floor.large_motion.begin(), floor.large_motion.end());
  return followed;
}

// Before a stage is bound that names them; previous: null: it is the first.
void Simulation::Impl::exchange_blocks_of_stage(const Stage& settings, const Stage* previous) {
  std::vector<int> followed = followed_blocks();
  for (const Stage* named_by : {&settings, previous}) {
    if (!named_by) continue;
    const std::vector<int> named = blocks_named_in(*named_by);
    followed.insert(followed.end(), named.begin(), named.end());
  }
  for (const Drive& drive : drives) {
    if (drive.of_ground) followed.push_back(drive.block);
  }
  for (int block = 0; settings.ground && block < large_motion->block_count(); ++block) {
    if (large_motion->assembly().blocks[static_cast<std::size_t>(block)].fixed) followed.push_back(block);
  }
  std::vector<int> watched;
  if (const std::string& name = watched_block(settings); !name.empty())
    watched = blocks_named(name, settings.source.text);
  followed.insert(followed.end(), watched.begin(), watched.end());
  std::sort(followed.begin(), followed.end());
  followed.erase(std::unique(followed.begin(), followed.end()), followed.end());
  large_motion->exchange_blocks(followed);
  large_motion->exchange_joints(watched);
}

std::vector<int> Simulation::Impl::blocks_named(const std::string& name, const std::string& where) const {
  return blocks::find_blocks(large_motion->assembly(), name, where);
}

const std::string& Simulation::Impl::watched_block(const Stage& settings) const {
  return settings.monitor.empty() ? scene.output.monitor : settings.monitor;
}

void Simulation::Impl::watch_blocks(const Stage& settings) {
  const std::string& watched = watched_block(settings);
  monitor_blocks.clear();
  if (!watched.empty()) monitor_blocks = blocks_named(watched, settings.source.text);
  monitor_stands_below = stands_below(monitor_blocks);
}

// ---- Stages --------------------------------------------------------------------------------------------------------

void Simulation::Impl::begin_large_motion_stage(const Stage& settings, const Stage* previous) {
  blocks::Model& m = *large_motion;
  m.clear_loads();
  bind_actions(settings, previous);
  stage_start_time = m.time();
  if (settings.solver) m.set_solver(*settings.solver);
  follow_time_step();
  watch_blocks(settings);
  monitor_start = block_translation(monitor_blocks);
}

void Simulation::Impl::swap_law_in_large_motion(std::size_t index, std::shared_ptr<const Material> material) {
  const blocks::Family& f = large_motion->families()[index];
  std::vector<double> area;
  for (const blocks::Point& p : f.point) area.push_back(p.area);
  FamilyColumns points;
  points.count = f.size();
  points.opening = f.normal_jump.data();  // of the last law call, as the tractions
  points.area = area.data();
  for (std::size_t k = 0; k < 3; ++k) points.traction[k] = f.traction[k].data();
  for (const auto& column : f.state) points.state.push_back(column.data());
  const JointFamily& description = large_motion->assembly().families[index];
  const MigratedFamily migrated = migrate(description, *f.material, *material, points);
  swaps.push_back(report_of(description.name, *f.material, *material, migrated.sums(0, points.count)));
  large_motion->replace_law(static_cast<int>(index), material, migrated.state, migrated.opening_shift);
  model.families[index].material = std::move(material);
  follow_time_step();
}

double Simulation::Impl::now() const {
  if (large_motion) return large_motion->time();
  return clock_start + static_cast<double>(step_count - clock_start_step) * data.time_step;
}

double Simulation::Impl::stage_time() const {
  return large_motion ? large_motion->time() - stage_start_time : static_cast<double>(stage_step) * data.time_step;
}

void Simulation::Impl::end_large_motion_step(double timed) {
  const long divisions = large_motion->divisions();
  const auto before = timed > 0.0 ? Clock::now() : Clock::time_point();
  const bool moved = large_motion->end_step();
  if (timed > 0.0) times[Phase::detection] += timed * seconds_since(before);
  if (ranks_failed)  // here all is well
    throw Error(Exit::numerical, fmt::format("step {}: another rank cannot go on", step_count));
  if (moved) {
    const auto found = Clock::now();
    large_motion->find_contacts();
    times[Phase::detection] += seconds_since(found);
  }
  if (large_motion->divisions() == divisions) return;
  partition_work();
  follow_time_step();
}

void Simulation::Impl::follow_time_step() {
  time_step.critical.value = large_motion->critical_time_step();
  time_step.time_step = data.time_step = large_motion->time_step();
  time_step.impacts = large_motion->impact_damping();
}

void Simulation::Impl::measure_large_motion_step() {
  if (in_parts) gather(Part::row);
  unbalanced_ratio = large_motion->unbalanced_ratio();
  const blocks::Energies& e = large_motion->energies();
  kinetic = large_motion->measured_kinetic_energy();
  if (sample_energy) {
    Energies now;
    now.kinetic = e.kinetic, now.strain = e.strain, now.contact_stored = e.contact_stored + e.members_stored;
    const double work = e.external - e.damping - e.detection;  // since energies were booked first
    check_energies(now, large_motion->dissipated_in_step(), work, -work);
    if (!watch.pending) end_check();
  }
  if (!want_energy) return;
  // On top of what the lattice has spent before a promotion.
  const double jump = outcome.promotion ? outcome.promotion->energy_jump : 0.0;
  energies = Energies{e.kinetic,
                      e.strain,
                      e.contact_stored,
                      energy_dissipated,
                      energy_external + e.external,
                      energy_damping + e.damping,
                      energy_inertia + e.detection - jump,
                      e.members_stored,
                      e.members_dissipated};
  for (std::size_t k = 0; k < 4; ++k) energies->dissipated[k] += e.dissipated[k];
}

// ---- Results -------------------------------------------------------------------------------------------------------

Vec3 Simulation::Impl::block_translation(int block) const {
  return geometry::array(large_motion->position(block) - large_motion->start_position(block));
}

Vec3 Simulation::Impl::block_translation(const std::vector<int>& blocks) const {
  Vec3 mean{};
  for (const int block : blocks) {
    const Vec3 moved = block_translation(block);
    for (std::size_t c = 0; c < 3; ++c) mean[c] += moved[c] / static_cast<double>(blocks.size());
  }
  return mean;
}

Vec3 Simulation::Impl::block_translation_at_forces(const std::vector<int>& blocks) const {
  Vec3 mean = block_translation(blocks);
  for (const int block : blocks) {
    const Vector v = large_motion->velocity(block);
    for (std::size_t c = 0; c < 3; ++c)
      mean[c] -= data.time_step * v[static_cast<int>(c)] / static_cast<double>(blocks.size());
  }
  return mean;
}

double Simulation::Impl::largest_displacement() const {
  double largest = 0.0;
  const auto look = [&](double moved) { largest = moved <= largest ? largest : moved; };  // NaN is kept
  for (std::size_t i = 0; !large_motion && i < model.assembly.bricks.size(); ++i)
    look(norm(geometry::vector((has_all() ? whole_motion_of(i) : whole_motions[i]).translation)));
  for (int i = 0; large_motion && i < large_motion->block_count(); ++i) {
    if (large_motion->assembly().blocks[static_cast<std::size_t>(i)].fixed) continue;
    look(large_motion->moved(i));
  }
  return largest;
}

void Simulation::Impl::measure_large_motion(HistoryRow& row) const {
  const auto direction = static_cast<std::size_t>(scene.stages[static_cast<std::size_t>(row.stage)].direction);
  row.multiplier = multiplier;
  row.largest_displacement = largest_displacement();
  const double whole = model.assembly.symmetry_factor;
  row.dynamic_force = whole * large_motion->net_force()[static_cast<int>(direction)];
  measure_base(row);
  if (monitor_blocks.empty()) return;
  row.monitor_displacement = row.monitor_relative = block_translation_at_forces(monitor_blocks);
  for (std::size_t c = 0; c < 3; ++c) row.monitor_relative[c] -= row.ground_displacement[c];
  for (const int block : monitor_blocks) {
    const Vec3 joints = geometry::array(large_motion->contact_force(block));
    for (std::size_t c = 0; c < 3; ++c) row.joint_force[c] += whole * joints[c];
  }
  row.displacement = row.monitor_displacement[direction] - monitor_start[direction];
  row.resistance = -row.joint_force[direction];
  row.vertical_force = monitor_stands_below ? -row.joint_force[1] : row.joint_force[1];  // compression positive
  if (whiffletree.empty()) return;
  // The roof against the shear force that the walls carry to the ground.
  row.monitor_displacement = {floor_displacement(whiffletree.size() - 1), 0.0, 0.0};
  row.displacement = row.monitor_displacement[0] - monitor_start[0];
  row.resistance = row.joint_force[0];
}

// What these blocks touch is above them, as over a bottom beam.
bool Simulation::Impl::stands_below(const std::vector<int>& blocks) const {
  MonitorSide side;
  for (const blocks::Contact& c : large_motion->contacts()) {
    for (const int block : blocks) {
      if (c.pair.a != block && c.pair.b != block) continue;
      for (std::size_t i = c.first; i < c.first + c.count; ++i)
        side.add(large_motion->place_of(large_motion->families()[static_cast<std::size_t>(c.family)].point[i]).y -
                 large_motion->position(block).y);
    }
  }
  return side.joints_are_above();
}

// Rotations only: blocks that ride may leave their joints altogether.
void Simulation::Impl::check_rotations() {
  for (int i = 0; i < large_motion->block_count(); ++i) {
    const double angle = large_motion->turned(i);
    if (!(angle <= motion_seen.rotation)) motion_seen.rotation = angle, motion_seen.turned_block = i;
  }
}

// All, or those of this rank where the others were not gathered.
std::vector<int> Simulation::Impl::chunks_in_large_motion() const {
  return !in_parts || has_all() ? whole_share(large_motion->chunk_count(), 0).chunks : share.chunks;
}

namespace {

// Of the points of families one after the other those in a range.
struct FamilyPart {
  const blocks::Family& family;
  int index;               // of the family
  std::size_t first, end;  // in it
  std::size_t before;      // points of the families before
};

// Chunk by chunk.
std::vector<FamilyPart> parts_of(const blocks::Model& large_motion, std::span<const int> chunks,
                                 const PointRange& range) {
  std::vector<std::size_t> before;
  std::size_t points = 0;
  for (const blocks::Family& f : large_motion.families()) before.push_back(points), points += f.size();
  std::vector<FamilyPart> parts;
  const auto from = static_cast<std::size_t>(range.first), to = static_cast<std::size_t>(range.end);
  for (const int c : chunks) {
    const auto [family, first_of_chunk, count] = large_motion.range_of_chunk(c);
    const std::size_t of_families = before[static_cast<std::size_t>(family)];
    const std::size_t first = std::max(from, of_families + first_of_chunk);
    const std::size_t end = std::min(to, of_families + first_of_chunk + count);
    if (first < end)
      parts.push_back({large_motion.families()[static_cast<std::size_t>(family)], family, first - of_families,
                       end - of_families, of_families});
  }
  return parts;
}

}  // namespace

void Simulation::Impl::ask_large_motion_at_rest(std::uint64_t capability, const PointRange& range,
                                                const PointOutputs& outputs) const {
  for (const auto& [f, index, first, end, before] : parts_of(*large_motion, chunks_in_large_motion(), range)) {
    if (!(f.material->api().capabilities & capability)) continue;
    RestingPoints points{
        end - first, f.normal_jump.data() + first, {}, {}, batch_columns(f.columns, *f.material, first)};
    for (std::size_t k = 0; k < 3; ++k) points.traction[k] = f.traction[k].data() + first;
    for (const auto& column : f.state) points.state.push_back(column.data() + first);
    evaluate_at_rest(*f.material, points, [&, at = before + first](quoin_batch& batch) { outputs(batch, at); });
  }
}

Simulation::BlockMesh Simulation::Impl::mesh_in_large_motion(int block) const {
  const blocks::ModelBlock& b = large_motion->block(block);
  const blocks::Block& input = large_motion->assembly().blocks[static_cast<std::size_t>(block)];
  BlockMesh mesh;
  mesh.unit = input.unit, mesh.course = input.course, mesh.fixed = input.fixed;
  mesh.face = b.shape->faces;  // the first gridpoints of deformable blocks are the vertices of their shapes
  if (b.body >= 0) {
    const geometry::Matrix turned = matrix(input.orientation);
    for (const Vector& p : b.shape->vertices) mesh.gridpoint.push_back(geometry::array(input.position + turned * p));
    return mesh;
  }
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i)
    mesh.gridpoint.push_back(geometry::array(large_motion->node_reference()[static_cast<std::size_t>(i)]));
  for (int z = b.first_zone; z < b.first_zone + b.zone_count; ++z) {
    std::array<int, 4>& zone = mesh.zone.emplace_back();
    for (std::size_t k = 0; k < 4; ++k)
      zone[k] = large_motion->zones()[static_cast<std::size_t>(z)].node[k] - b.first_node;
  }
  return mesh;
}

Simulation::BlockSize Simulation::Impl::size_in_large_motion(int block) const {
  const blocks::ModelBlock& b = large_motion->block(block);
  BlockSize size;
  size.gridpoints = b.body >= 0 ? b.shape->vertices.size() : static_cast<std::uint64_t>(b.node_count);
  size.zones = static_cast<std::uint64_t>(b.zone_count);
  size.faces = b.shape->faces.size();
  for (const auto& face : b.shape->faces) size.face_corners += face.size();
  return size;
}

std::vector<Vec3> Simulation::Impl::gridpoint_displacements(int block) const {
  const blocks::ModelBlock& b = large_motion->block(block);
  std::vector<Vec3> result;
  const BlockMesh mesh = mesh_in_large_motion(block);
  for (std::size_t i = 0; i < mesh.gridpoint.size(); ++i) {
    const Vector now = b.body >= 0 ? large_motion->corner(block, static_cast<int>(i))
                                   : large_motion->node_positions()[static_cast<std::size_t>(b.first_node) + i];
    result.push_back(geometry::array(now - geometry::vector(mesh.gridpoint[i])));
  }
  return result;
}

std::vector<Vec3> Simulation::Impl::gridpoint_velocities(int block) const {
  const blocks::ModelBlock& b = large_motion->block(block);
  std::vector<Vec3> result;
  for (int i = 0; b.body < 0 && i < b.node_count; ++i)
    result.push_back(geometry::array(large_motion->node_velocities()[static_cast<std::size_t>(b.first_node + i)]));
  for (std::size_t i = 0; b.body >= 0 && i < b.shape->vertices.size(); ++i)
    result.push_back(
        geometry::array(large_motion->velocity(block) +
                        cross(large_motion->angular_velocity(block),
                              large_motion->corner(block, static_cast<int>(i)) - large_motion->position(block))));
  return result;
}

std::vector<std::array<double, 6>> Simulation::Impl::zone_stresses(int block) const {
  const blocks::ModelBlock& b = large_motion->block(block);
  std::vector<std::array<double, 6>> result;
  for (int z = b.first_zone; z < b.first_zone + b.zone_count; ++z) {
    const geometry::Matrix s = large_motion->zone_stress(z);
    result.push_back({s.row[0].x, s.row[1].y, s.row[2].z, s.row[0].y, s.row[1].z, s.row[2].x});
  }
  return result;
}

void Simulation::Impl::each_point_in_large_motion(const std::function<void(std::int32_t, int)>& visit) const {
  for (const auto& [f, index, first, end, before] : parts_of(*large_motion, chunks_in_large_motion(), all_points())) {
    for (std::size_t i = first; i < end; ++i) visit(static_cast<std::int32_t>(before + i), f.point[i].a);
  }
}

std::vector<ContactPoint> Simulation::Impl::points_in_large_motion(const PointRange& range,
                                                                   const std::function<bool(int block)>& wanted) const {
  const std::vector<std::uint32_t> flags_there = current_flags(range);
  std::vector<ContactPoint> points;
  for (const auto& [f, index, first, end, before] : parts_of(*large_motion, chunks_in_large_motion(), range)) {
    for (std::size_t i = first; i < end; ++i) {
      const blocks::Point& p = f.point[i];
      if (!wanted(p.a)) continue;
      const geometry::Matrix r = large_motion->frame_of(p);
      ContactPoint point{};
      point.index = static_cast<std::int32_t>(before + i);
      point.position = geometry::array(large_motion->place_of(p));
      point.normal = geometry::array(r.row[0]);
      point.s = geometry::array(r.row[1]);
      point.t = geometry::array(r.row[2]);
      point.area = p.area;
      point.joint = -1;
      point.family = index;
      point.block_a = p.a;
      point.block_b = p.b;
      point.jump = {f.normal_jump[i], 0.0, 0.0};  // slip is the law's to keep: points are placed again
      point.traction = {f.traction[0][i], f.traction[1][i], f.traction[2][i]};
      point.flags = flags_there[static_cast<std::size_t>(point.index - range.first)];
      point.condition = condition_of(point.flags);
      points.push_back(point);
    }
  }
  return points;
}

std::vector<double> Simulation::Impl::state_in_large_motion(const std::string& id, const PointRange& range) const {
  std::vector<double> values;
  for (const auto& [f, index, first, end, before] :
       parts_of(*large_motion, whole_share(large_motion->chunk_count(), 0).chunks, range)) {
    const int k = f.material->law().state_index(id);
    const std::size_t count = end - first;
    if (k < 0) {
      values.resize(values.size() + count, std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const std::span column(f.state[static_cast<std::size_t>(k)]);
    values.insert(values.end(), column.begin() + static_cast<std::ptrdiff_t>(first),
                  column.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return values;
}

}  // namespace quoin
