// Blocks that move without bound: what stages do to them, and what the history shows of them.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "law/at_rest.h"
#include "model/time_step.h"
#include "scene/generate_blocks.h"
#include "step/law_swap.h"
#include "step/state.h"

namespace quoin {

using geometry::Vector;

namespace {

constexpr double kUplift = 1e-4;  // m, opening of a bed joint that counts as uplift
constexpr double kBed = 0.7;      // cosine of the normal to the vertical from which on a joint is a bed joint

}  // namespace

void Simulation::Impl::build_riding(const blocks::Assembly& shapes,
                                    std::vector<std::shared_ptr<const Material>> materials) {
  in_parts = may_ride_in_parts(shapes);
  riding = std::make_unique<blocks::Model>(shapes, scene.solver, std::move(materials), in_parts ? ranks : nullptr);
  if (in_parts) {
    agree_on_model();
    divide_work();
    riding->begin(rank_of_riding_blocks());
  } else {
    riding->before_dividing([this] { gather(Part::all); });
  }
  riding->track_energy(want_energy);
  find_blocks_on_base();
  require_moving_ground();
  if (!left) extent = riding->extent();
  // Every name of every stage is looked up before anything runs.
  for (const Stage& s : scene.stages) {
    for (const BodyControl& control : s.controls) blocks_named(control.body, s.source.text);
    for (const PointForce& given : s.forces) blocks_named(given.block, s.source.text);
    for (const FacePressure& given : s.pressures) blocks_named(given.block, s.source.text);
    const std::string& watched = watched_block(s);
    if (!watched.empty()) blocks_named(watched, s.source.text + ": monitor");
    if (s.displacement && watched.empty())
      throw Error(Exit::bad_input,
                  fmt::format("{}: stage '{}' ends by displacement but has no monitor; give stage.monitor or "
                              "output.monitor, the name of a block",
                              s.source.text, s.name));
  }
  riding->hold_by_springs(whiffletree_eigenvalue(scene.stages, [this](const Stage& s, const std::string& name) {
    std::vector<double> compliances;  // scaled masses are larger, and safe
    for (const int block : blocks_named(name, s.source.text)) compliances.push_back(1.0 / riding->mass_of(block));
    return compliances;
  }));
  follow_time_step();
  time_step.model_mass = riding->mass();
}

// Blocks on their own side of the border alone: watch_uplift asks each rank for its own.
void Simulation::Impl::find_blocks_on_base() {
  const auto& blocks = riding->assembly().blocks;
  on_base.assign(blocks.size(), 0);
  const auto& contacts = riding->contacts();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const blocks::Contact& c = contacts[i];
    if (c.count == 0 || !riding->owns(c) || std::abs(riding->place_of_pair(i).separation.normal.y) < kBed) continue;
    const auto a = static_cast<std::size_t>(c.pair.a), b = static_cast<std::size_t>(c.pair.b);
    if (blocks[a].fixed) on_base[b] = 1;
    if (blocks[b].fixed) on_base[a] = 1;
  }
  if (in_parts)
    tell_all(ranks, std::span(on_base), [rank = rank_of_riding_blocks()](std::size_t block) { return rank[block]; });
}

// Damage and properties that scatter are found over all contact points; a promotion hands over all of a lattice.
bool Simulation::Impl::may_ride_in_parts(const blocks::Assembly& shapes) const {
  return ranks && !left && scene.damage.empty() &&
         std::none_of(shapes.families.begin(), shapes.families.end(),
                      [](const JointFamily& family) { return family.scatters(); });
}

std::vector<int> Simulation::Impl::rank_of_riding_blocks() const {
  std::vector<int> rank;
  for (const int item : item_of_riding_block) rank.push_back(share.rank_of_item[static_cast<std::size_t>(item)]);
  return rank;
}

// What every rank follows through a stage, whoever advances it.
std::vector<int> Simulation::Impl::followed_blocks() const {
  std::vector<int> followed = monitor_blocks;
  for (const Drive& drive : drives) {
    if (!drive.of_ground) followed.push_back(drive.block);  // the ground moves as its record says
  }
  for (const blocks::Load& given : riding->loads()) followed.push_back(given.block);
  for (const blocks::Pressure& given : riding->pressures()) followed.push_back(given.block);
  for (const Floor& floor : whiffletree) followed.insert(followed.end(), floor.riding.begin(), floor.riding.end());
  return followed;
}

// Before a stage is bound that names them; previous: null: it is the first.
void Simulation::Impl::tell_blocks_of_stage(const Stage& settings, const Stage* previous) {
  std::vector<int> told = followed_blocks();
  const auto add = [&](const std::string& name) {
    const std::vector<int> named = blocks_named(name, settings.source.text);
    told.insert(told.end(), named.begin(), named.end());
  };
  for (const BodyControl& control : settings.controls) add(control.body);
  for (const Drive& drive : drives) {
    if (drive.of_ground) told.push_back(drive.block);
  }
  for (int block = 0; settings.ground && block < riding->block_count(); ++block) {
    if (riding->assembly().blocks[static_cast<std::size_t>(block)].fixed) told.push_back(block);
  }
  for (const Stage* stage_of_loads : {&settings, previous}) {
    if (!stage_of_loads) continue;
    for (const PointForce& given : stage_of_loads->forces) add(given.block);
    for (const FacePressure& given : stage_of_loads->pressures) add(given.block);
  }
  if (settings.whiffletree) {
    for (const auto& floor : settings.whiffletree->floors) std::for_each(floor.begin(), floor.end(), add);
  }
  std::vector<int> watched;
  if (const std::string& name = watched_block(settings); !name.empty())
    watched = blocks_named(name, settings.source.text);
  told.insert(told.end(), watched.begin(), watched.end());
  std::sort(told.begin(), told.end());
  told.erase(std::unique(told.begin(), told.end()), told.end());
  riding->tell_blocks(told);
  riding->tell_joints(watched);
}

std::vector<int> Simulation::Impl::blocks_named(const std::string& name, const std::string& where) const {
  return blocks::find_blocks(riding->assembly(), name, where);
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

void Simulation::Impl::begin_riding_stage(const Stage& settings, const Stage* previous) {
  blocks::Model& m = *riding;
  bind_drives(settings, previous);
  riding_stage_start = m.time();
  multiplier = 0.0;
  first_load = {};
  if (settings.solver) m.set_solver(*settings.solver);
  follow_time_step();
  watch_blocks(settings);
  monitor_start = riding_displacement(monitor_blocks);

  // Loads of before fade while those of this stage grow.
  m.clear_loads();
  fading_loads = fading_pressures = 0;
  if (previous) {
    add_loads(*previous);
    fading_loads = m.loads().size(), fading_pressures = m.pressures().size();
  }
  add_loads(settings);
}

void Simulation::Impl::swap_riding_law(std::size_t index, std::shared_ptr<const Material> material) {
  const blocks::Family& f = riding->families()[index];
  std::vector<double> area;
  for (const blocks::Point& p : f.point) area.push_back(p.area);
  FamilyColumns points;
  points.count = f.size();
  points.opening = f.normal_jump.data();  // of the last law call, as the tractions
  points.area = area.data();
  for (std::size_t k = 0; k < 3; ++k) points.traction[k] = f.traction[k].data();
  for (const auto& column : f.state) points.state.push_back(column.data());
  const JointFamily& description = riding->assembly().families[index];
  const MigratedFamily migrated = migrate(description, *f.material, *material, points);
  swaps.push_back(report_of(description.name, *f.material, *material, migrated.sums(0, points.count)));
  riding->replace_law(static_cast<int>(index), material, migrated.state, migrated.opening_shift);
  model.families[index].material = std::move(material);
  follow_time_step();
}

Vector Simulation::Impl::record_velocity(const Stage& of_stage, double time) const {
  if (!of_stage.ground) return {};
  return of_stage.ground->acceleration.integral(time - riding_stage_start) *
         normalized(geometry::vector(of_stage.ground->direction));
}

// Drives of the stage, and what was driven before and is now let go. Velocities grow from those of now, forces of
// components that are let go from what their support has carried. previous: null: there was no stage.
void Simulation::Impl::bind_drives(const Stage& settings, const Stage* previous) {
  blocks::Model& m = *riding;
  std::vector<Drive> before = std::move(drives);
  drives.clear();
  // Velocities are those of half a step ago; that of a record is known for now, and may be back at rest.
  constexpr double kRest = 1e-12;  // m/s, rounding of a record that ends at rest
  Vector record, left_of_ground;
  if (previous)
    record = record_velocity(*previous, m.time()) - record_velocity(*previous, m.time() - 0.5 * m.time_step());
  const auto start = [&](int block) {
    Drive drive;
    drive.block = block;
    drive.velocity_from = m.velocity(block);
    drive.omega_from = m.angular_velocity(block);
    const auto old = std::find_if(before.begin(), before.end(), [&](const Drive& d) { return d.block == block; });
    if (old == before.end()) return drive;
    for (int c = 0; c < 3; ++c) {
      if (old->of_ground >> c & 1) drive.velocity_from[c] += record[c];
      if (std::abs(drive.velocity_from[c]) <= kRest && old->of_ground) drive.velocity_from[c] = 0.0;
    }
    const Vector carried = -1.0 * m.contact_force(block) - m.mass_of(block) * geometry::vector(data.gravity);
    for (int c = 0; c < 3; ++c) drive.force_from[c] = old->held >> c & 1 ? carried[c] : old->force_to[c];
    return drive;
  };
  for (const BodyControl& control : settings.controls) {
    for (const int block : blocks_named(control.body, settings.source.text)) {
      Drive drive = start(block);
      for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c);
        if (control.kind[k] == DofKind::velocity) {
          drive.held |= static_cast<std::uint8_t>(1 << c);
          drive.velocity_to[c] = control.velocity[k];
          if (control.in_cycles == c) drive.in_cycles |= static_cast<std::uint8_t>(1 << c);
          drive.force_from[c] = 0.0;
        } else {
          drive.force_to[c] = control.force[k];
        }
      }
      if (!control.may_turn) drive.held |= 0x38;
      drive.omega_to = geometry::vector(control.omega);
      drives.push_back(drive);
    }
  }
  for (const Drive& old : before) {
    if (old.of_ground) left_of_ground = start(old.block).velocity_from;
    if (std::any_of(drives.begin(), drives.end(), [&](const Drive& d) { return d.block == old.block; })) continue;
    Drive released = start(old.block);
    if (m.assembly().blocks[static_cast<std::size_t>(old.block)].fixed) {
      released.held = 0x3f;
      released.force_from = {};
      released.of_ground = old.of_ground;
    }
    drives.push_back(released);
  }
  bind_ground(settings, left_of_ground);
}

// The ground is all fixed blocks that no table of the stage drives. What earlier records have left of its velocity goes
// on, or fades over the ramp of the stage if it has one.
void Simulation::Impl::bind_ground(const Stage& settings, const Vector& left_over) {
  std::vector<std::int32_t> drive_of(static_cast<std::size_t>(riding->block_count()), -1);
  for (std::size_t d = 0; d < drives.size(); ++d)
    drive_of[static_cast<std::size_t>(drives[d].block)] = static_cast<std::int32_t>(d);
  std::set<int> controlled;
  for (const BodyControl& control : settings.controls) {
    for (const int block : blocks_named(control.body, settings.source.text)) controlled.insert(block);
  }
  for (int block = 0; block < riding->block_count(); ++block) {
    if (!riding->assembly().blocks[static_cast<std::size_t>(block)].fixed || controlled.contains(block)) continue;
    std::int32_t& index = drive_of[static_cast<std::size_t>(block)];
    if (index < 0 && !settings.ground) continue;
    if (index < 0) {
      Drive drive;
      drive.block = block;
      drive.held = 0x3f;
      drive.velocity_from = riding->velocity(block);
      index = static_cast<std::int32_t>(drives.size());
      drives.push_back(drive);
    }
    Drive& drive = drives[static_cast<std::size_t>(index)];
    if (!settings.ground && !drive.of_ground) continue;  // has been driven by itself, and comes to rest
    drive.of_ground = 7;
    drive.velocity_to = settings.ramp_time > 0.0 ? Vector{} : left_over;
  }
}

void Simulation::Impl::add_loads(const Stage& settings) {
  blocks::Model& m = *riding;
  const auto& assembly = m.assembly();
  for (const PointForce& given : settings.forces) {
    blocks::Load added{};
    added.block = blocks_named(given.block, settings.source.text).front();
    added.force = geometry::vector(given.force);
    added.point = geometry::vector(given.point);
    m.add(added);
  }
  for (const FacePressure& pressure : settings.pressures) {
    blocks::Pressure added{};
    added.block = blocks_named(pressure.block, settings.source.text).front(), added.value = pressure.pressure;
    const blocks::Block& block = assembly.blocks[static_cast<std::size_t>(added.block)];
    const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(block.shape)];
    const geometry::Matrix turned = matrix(block.orientation);
    const auto towards = [&](std::size_t face) {
      return dot(turned * shape.normals[face], geometry::vector(pressure.normal));
    };
    for (std::size_t f = 1; f < shape.faces.size(); ++f) {
      if (towards(f) > towards(static_cast<std::size_t>(added.face))) added.face = static_cast<int>(f);
    }
    m.add(added);
  }
}

// What controls impose in the coming step; s: how far the ramp has come, 0 to 1.
void Simulation::Impl::drive_blocks(double s) {
  blocks::Model& m = *riding;
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  const Vector record = record_velocity(settings, m.time() + 0.5 * m.time_step());
  for (Drive& d : drives) {
    Vector driven = d.velocity_from + s * (d.velocity_to - d.velocity_from);
    for (int c = 0; c < 3; ++c) {
      if (d.in_cycles >> c & 1) driven[c] = velocity_in_cycles(d.velocity_from[c]);
      if (d.of_ground >> c & 1) driven[c] += record[c];
    }
    m.prescribe(d.block, driven, d.omega_from + s * (d.omega_to - d.omega_from), d.held);
    d.force_now = d.force_from + s * (d.force_to - d.force_from);
    if (dot(d.force_now, d.force_now) > 0.0 || dot(d.force_from, d.force_from) > 0.0)
      m.apply_force(d.block, d.force_now);
  }
  for (std::size_t i = 0; i < m.loads().size(); ++i) m.loads()[i].scale = i < fading_loads ? 1.0 - s : s;
  for (std::size_t i = 0; i < m.pressures().size(); ++i) m.pressures()[i].scale = i < fading_pressures ? 1.0 - s : s;
  Vector g = geometry::vector(data.gravity);
  if (settings.collapse) {
    multiplier = settings.collapse->start * s +
                 settings.collapse->rate * std::max(0.0, m.time() - riding_stage_start - settings.ramp_time);
    g += multiplier * norm(geometry::vector(settings.gravity)) *
         normalized(geometry::vector(settings.collapse->direction));
  }
  m.set_gravity(g);
}

// Along x, in place of what else is applied there.
void Simulation::Impl::pull_block(int block, double pull) {
  const auto drive = std::find_if(drives.begin(), drives.end(), [block](const Drive& d) { return d.block == block; });
  Vector applied = drive == drives.end() ? Vector{} : drive->force_now;
  applied.x = pull;
  riding->apply_force(block, applied);
}

bool Simulation::Impl::collapse_ended(std::vector<Warning>* told) {
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  if (!settings.collapse) return false;
  gather(Part::row);
  watch_uplift();
  const Collapse& c = *settings.collapse;
  const double moved = largest_displacement();
  if (!(moved > c.displacement)) {
    if (stage_time() >= settings.ramp_time)
      first_load.look(stage_time(), moved, 0.1 * c.displacement, FirstLoad::time_of(c, settings.gravity));
    return multiplier > c.limit;
  }
  if (c.start <= 0.0 || first_load.carried) {
    outcome.collapse_multiplier = multiplier;
    return true;
  }
  warn_once(
      "collapse_multiplier",
      fmt::format("stage '{}': blocks have moved by {:g} m at the multiplier {:.4g} before they came to rest under "
                  "collapse.start = {:g}: the ramp has brought them there, and the collapse multiplier is not "
                  "known. It may lie below start or little above it; give a smaller start, or a longer ramp_time "
                  "({:g} s)",
                  settings.name, c.displacement, multiplier, c.start, settings.ramp_time),
      told);
  return true;
}

double FirstLoad::time_of(const Collapse& c, const Vec3& gravity) {
  return std::max(0.01 * c.start / c.rate, 4.0 * std::sqrt(2.0 * c.displacement / norm(geometry::vector(gravity))));
}

void FirstLoad::look(double time, double moved, double allowed, double needed) {
  lowest = std::min(lowest, moved), highest = std::max(highest, moved);
  if (since < 0.0 || highest - lowest > allowed) since = time, lowest = highest = moved;
  carried = carried || time - since >= needed;
}

void Simulation::Impl::watch_uplift() {
  if (outcome.base_slip_at_uplift) return;
  double opened = 0.0;
  const auto& contacts = riding->contacts();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const blocks::Contact& c = contacts[k];
    if (c.count == 0 || !riding->owns(c) || std::abs(riding->place_of_pair(k).separation.normal.y) < kBed) continue;
    const auto& family = riding->families()[static_cast<std::size_t>(c.family)];
    for (std::uint32_t i = c.first; i < c.first + c.count; ++i) opened = std::max(opened, family.normal_jump[i]);
  }
  if (in_parts) opened = largest_of_ranks(opened);
  if (opened < kUplift) return;
  double slip = 0.0;
  for (int b = 0; b < riding->block_count(); ++b) {
    if (!on_base[static_cast<std::size_t>(b)] || !riding->owns(b)) continue;
    const Vec3 d = riding_displacement(b);
    slip = std::max(slip, std::hypot(d[0], d[2]));
  }
  outcome.base_slip_at_uplift = in_parts ? largest_of_ranks(slip) : slip;
}

double Simulation::Impl::now() const {
  return riding ? riding->time() : static_cast<double>(step_count) * data.time_step;
}

double Simulation::Impl::stage_time() const {
  return riding ? riding->time() - riding_stage_start : static_cast<double>(stage_step) * data.time_step;
}

void Simulation::Impl::end_riding_step(double timed) {
  const long divisions = riding->divisions();
  const auto before = timed > 0.0 ? Clock::now() : Clock::time_point();
  const bool moved = riding->end_step();
  if (timed > 0.0) times[Phase::detection] += timed * seconds_since(before);
  if (ranks_failed)  // here all is well
    throw Error(Exit::numerical, fmt::format("step {}: another rank cannot go on", step_count));
  if (moved) {
    const auto found = Clock::now();
    riding->find_contacts();
    times[Phase::detection] += seconds_since(found);
  }
  if (riding->divisions() == divisions) return;
  partition_work();
  follow_time_step();
}

void Simulation::Impl::follow_time_step() {
  time_step.critical.value = riding->critical_time_step();
  time_step.time_step = data.time_step = riding->time_step();
}

void Simulation::Impl::measure_riding_step() {
  if (in_parts) gather(Part::row);
  unbalanced_ratio = riding->unbalanced_ratio();
  const blocks::Energies& e = riding->energies();
  kinetic = riding->measured_kinetic_energy();
  if (!want_energy) return;
  // On top of what the lattice has spent before a promotion.
  const double jump = outcome.promotion ? outcome.promotion->energy_jump : 0.0;
  energies = Energies{e.kinetic,
                      e.strain,
                      e.contact_stored,
                      energy_dissipated,
                      energy_external + e.external,
                      energy_damping + e.damping,
                      e.detection - jump};
  for (std::size_t k = 0; k < 4; ++k) energies->dissipated[k] += e.dissipated[k];
}

// ---- Results -------------------------------------------------------------------------------------------------------

Vec3 Simulation::Impl::riding_displacement(int block) const {
  return geometry::array(riding->position(block) - riding->start_position(block));
}

Vec3 Simulation::Impl::riding_displacement(const std::vector<int>& blocks) const {
  Vec3 mean{};
  for (const int block : blocks) {
    const Vec3 moved = riding_displacement(block);
    for (std::size_t c = 0; c < 3; ++c) mean[c] += moved[c] / static_cast<double>(blocks.size());
  }
  return mean;
}

double Simulation::Impl::largest_displacement() const {
  double largest = 0.0;
  const auto look = [&](double moved) { largest = moved <= largest ? largest : moved; };  // NaN is kept
  for (std::size_t i = 0; !riding && i < model.assembly.bricks.size(); ++i)
    look(norm(geometry::vector((has_all() ? whole_motion_of(i) : whole_motions[i]).translation)));
  for (int i = 0; riding && i < riding->block_count(); ++i) {
    if (riding->assembly().blocks[static_cast<std::size_t>(i)].fixed) continue;
    look(riding->moved(i));
  }
  return largest;
}

void Simulation::Impl::measure_riding(HistoryRow& row) const {
  const auto direction = static_cast<std::size_t>(scene.stages[static_cast<std::size_t>(row.stage)].direction);
  row.multiplier = multiplier;
  row.largest_displacement = largest_displacement();
  const double whole = model.assembly.symmetry_factor;
  row.dynamic_force = whole * riding->net_force()[static_cast<int>(direction)];
  if (monitor_blocks.empty()) return;
  row.monitor_displacement = riding_displacement(monitor_blocks);
  for (const int block : monitor_blocks) {
    const Vec3 joints = geometry::array(riding->contact_force(block));
    for (std::size_t c = 0; c < 3; ++c) row.joint_force[c] += whole * joints[c];
  }
  row.displacement = row.monitor_displacement[direction] - monitor_start[direction];
  row.resistance = -row.joint_force[direction];
  row.vertical_force = scene.blocks || !monitor_stands_below ? row.joint_force[1] : -row.joint_force[1];
  if (whiffletree.empty()) return;
  // The roof against the shear force that the walls carry to the ground.
  row.monitor_displacement = {floor_displacement(whiffletree.size() - 1), 0.0, 0.0};
  row.displacement = row.monitor_displacement[0] - monitor_start[0];
  row.resistance = row.joint_force[0];
}

// What these blocks touch is above them, as over a bottom beam.
bool Simulation::Impl::stands_below(const std::vector<int>& blocks) const {
  double arms = 0.0;
  for (const blocks::Contact& c : riding->contacts()) {
    for (const int block : blocks) {
      if (c.pair.a != block && c.pair.b != block) continue;
      for (std::size_t i = c.first; i < c.first + c.count; ++i)
        arms += riding->place_of(riding->families()[static_cast<std::size_t>(c.family)].point[i]).y -
                riding->position(block).y;
    }
  }
  return arms > 0.0;
}

// Rotations only: blocks that ride may leave their joints altogether.
void Simulation::Impl::look_at_riding_motion() {
  for (int i = 0; i < riding->block_count(); ++i) {
    const double angle = riding->turned(i);
    if (!(angle <= motion_seen.rotation)) motion_seen.rotation = angle, motion_seen.turned_block = i;
  }
}

// All, or where others have not told of theirs, those of this rank.
std::vector<int> Simulation::Impl::riding_chunks_here() const {
  return !in_parts || has_all() ? whole_share(riding->chunk_count(), 0).chunks : share.chunks;
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
std::vector<FamilyPart> parts_of(const blocks::Model& riding, std::span<const int> chunks, const PointRange& range) {
  std::vector<std::size_t> before;
  std::size_t points = 0;
  for (const blocks::Family& f : riding.families()) before.push_back(points), points += f.size();
  std::vector<FamilyPart> parts;
  const auto from = static_cast<std::size_t>(range.first), to = static_cast<std::size_t>(range.end);
  for (const int c : chunks) {
    const auto [family, first_of_chunk, count] = riding.range_of_chunk(c);
    const std::size_t of_families = before[static_cast<std::size_t>(family)];
    const std::size_t first = std::max(from, of_families + first_of_chunk);
    const std::size_t end = std::min(to, of_families + first_of_chunk + count);
    if (first < end)
      parts.push_back({riding.families()[static_cast<std::size_t>(family)], family, first - of_families,
                       end - of_families, of_families});
  }
  return parts;
}

}  // namespace

void Simulation::Impl::ask_riding_at_rest(std::uint64_t capability, const PointRange& range,
                                          const PointOutputs& outputs) const {
  for (const auto& [f, index, first, end, before] : parts_of(*riding, riding_chunks_here(), range)) {
    if (!(f.material->api().capabilities & capability)) continue;
    RestingPoints points{
        end - first, f.normal_jump.data() + first, {}, {}, batch_columns(f.columns, *f.material, first)};
    for (std::size_t k = 0; k < 3; ++k) points.traction[k] = f.traction[k].data() + first;
    for (const auto& column : f.state) points.state.push_back(column.data() + first);
    evaluate_at_rest(*f.material, points, [&, at = before + first](quoin_batch& batch) { outputs(batch, at); });
  }
}

Simulation::BlockMesh Simulation::Impl::riding_mesh(int block) const {
  const blocks::ModelBlock& b = riding->block(block);
  const blocks::Block& input = riding->assembly().blocks[static_cast<std::size_t>(block)];
  BlockMesh mesh;
  mesh.unit = input.unit, mesh.course = input.course, mesh.fixed = input.fixed;
  mesh.face = b.shape->faces;  // the first gridpoints of deformable blocks are the vertices of their shapes
  if (b.body >= 0) {
    const geometry::Matrix turned = matrix(input.orientation);
    for (const Vector& p : b.shape->vertices) mesh.gridpoint.push_back(geometry::array(input.position + turned * p));
    return mesh;
  }
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i)
    mesh.gridpoint.push_back(geometry::array(riding->node_reference()[static_cast<std::size_t>(i)]));
  for (int z = b.first_zone; z < b.first_zone + b.zone_count; ++z) {
    std::array<int, 4>& zone = mesh.zone.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) zone[k] = riding->zones()[static_cast<std::size_t>(z)].node[k] - b.first_node;
  }
  return mesh;
}

Simulation::BlockSize Simulation::Impl::riding_size(int block) const {
  const blocks::ModelBlock& b = riding->block(block);
  BlockSize size;
  size.gridpoints = b.body >= 0 ? b.shape->vertices.size() : static_cast<std::uint64_t>(b.node_count);
  size.zones = static_cast<std::uint64_t>(b.zone_count);
  size.faces = b.shape->faces.size();
  for (const auto& face : b.shape->faces) size.face_corners += face.size();
  return size;
}

std::vector<Vec3> Simulation::Impl::riding_displacements(int block) const {
  const blocks::ModelBlock& b = riding->block(block);
  std::vector<Vec3> result;
  const BlockMesh mesh = riding_mesh(block);
  for (std::size_t i = 0; i < mesh.gridpoint.size(); ++i) {
    const Vector now = b.body >= 0 ? riding->corner(block, static_cast<int>(i))
                                   : riding->node_positions()[static_cast<std::size_t>(b.first_node) + i];
    result.push_back(geometry::array(now - geometry::vector(mesh.gridpoint[i])));
  }
  return result;
}

std::vector<Vec3> Simulation::Impl::riding_velocities(int block) const {
  const blocks::ModelBlock& b = riding->block(block);
  std::vector<Vec3> result;
  for (int i = 0; b.body < 0 && i < b.node_count; ++i)
    result.push_back(geometry::array(riding->node_velocities()[static_cast<std::size_t>(b.first_node + i)]));
  for (std::size_t i = 0; b.body >= 0 && i < b.shape->vertices.size(); ++i)
    result.push_back(geometry::array(
        riding->velocity(block) +
        cross(riding->angular_velocity(block), riding->corner(block, static_cast<int>(i)) - riding->position(block))));
  return result;
}

std::vector<std::array<double, 6>> Simulation::Impl::riding_stress(int block) const {
  const blocks::ModelBlock& b = riding->block(block);
  std::vector<std::array<double, 6>> result;
  for (int z = b.first_zone; z < b.first_zone + b.zone_count; ++z) {
    const geometry::Matrix s = riding->zone_stress(z);
    result.push_back({s.row[0].x, s.row[1].y, s.row[2].z, s.row[0].y, s.row[1].z, s.row[2].x});
  }
  return result;
}

void Simulation::Impl::each_riding_point_here(const std::function<void(std::int32_t, int)>& visit) const {
  for (const auto& [f, index, first, end, before] : parts_of(*riding, riding_chunks_here(), all_points())) {
    for (std::size_t i = first; i < end; ++i) visit(static_cast<std::int32_t>(before + i), f.point[i].a);
  }
}

std::vector<ContactPoint> Simulation::Impl::riding_points(const PointRange& range,
                                                          const std::function<bool(int block)>& wanted) const {
  const std::vector<std::uint32_t> flags_there = current_flags(range);
  std::vector<ContactPoint> points;
  for (const auto& [f, index, first, end, before] : parts_of(*riding, riding_chunks_here(), range)) {
    for (std::size_t i = first; i < end; ++i) {
      const blocks::Point& p = f.point[i];
      if (!wanted(p.a)) continue;
      const geometry::Matrix r = riding->frame_of(p);
      ContactPoint point{};
      point.index = static_cast<std::int32_t>(before + i);
      point.position = geometry::array(riding->place_of(p));
      point.normal = geometry::array(r.row[0]);
      point.s = geometry::array(r.row[1]);
      point.t = geometry::array(r.row[2]);
      point.area = p.area;
      point.joint = -1;
      point.family = index;
      point.block_a = p.a;
      point.block_b = p.b;
      point.jump = {f.normal_jump[i], 0.0, 0.0};  // slip is the law's to keep: points are placed anew
      point.traction = {f.traction[0][i], f.traction[1][i], f.traction[2][i]};
      point.flags = flags_there[static_cast<std::size_t>(point.index - range.first)];
      point.condition = condition_of(point.flags);
      points.push_back(point);
    }
  }
  return points;
}

std::vector<double> Simulation::Impl::riding_state(const std::string& id, const PointRange& range) const {
  std::vector<double> values;
  for (const auto& [f, index, first, end, before] :
       parts_of(*riding, whole_share(riding->chunk_count(), 0).chunks, range)) {
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
