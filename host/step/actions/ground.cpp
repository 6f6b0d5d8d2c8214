// Ground motion: all fixed blocks that no table of a stage drives, and what stands on them does to them.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "members/members.h"
#include "scene/from_bricks.h"
#include "scene/generate_blocks.h"
#include "step/actions/action.h"

namespace quoin {

using geometry::Vector;

Vector Simulation::Impl::record_velocity(const Stage& of_stage, double time, std::int32_t motion) const {
  if (!of_stage.ground) return {};
  const GroundMotion& ground = *of_stage.ground;
  if (motion > static_cast<std::int32_t>(ground.supports.size())) return {};  // of a stage before
  const GroundMotion& moving = motion > 0 ? ground.supports[static_cast<std::size_t>(motion) - 1] : ground;
  Vector of_record;
  for (const GroundMotion::Component& c : moving.components)
    of_record += c.velocity.at(c.acceleration, time - stage_start_time) * normalized(geometry::vector(c.direction));
  return of_record;
}

// Velocities of what moves are those of half a step ago; that of a record is known for now, and may be back at rest.
Vector Simulation::Impl::record_since_half_step(const Stage* of_stage, std::int32_t motion) const {
  if (!of_stage) return {};
  const double half = 0.5 * (large_motion ? large_motion->time_step() : data.time_step);
  return record_velocity(*of_stage, now(), motion) - record_velocity(*of_stage, now() - half, motion);
}

Vec3 Simulation::Impl::left_over_velocity(const Stage* previous, int body) const {
  const std::int64_t motion = ramps[static_cast<std::size_t>(body)].motion;
  const Vector record = record_since_half_step(previous, static_cast<std::int32_t>(motion));
  Vec3 after = of_body(body, &BodyLanes::velocity);
  for (std::size_t c = 0; c < 3; ++c) {
    after[c] += record[static_cast<int>(c)];
    if (std::abs(after[c]) <= kGroundAtRest) after[c] = 0.0;
  }
  return after;
}

int Simulation::Impl::ground_body() const {
  int found = -1;
  for (std::size_t b = 0; b < ramps.size(); ++b) {
    if (ramps[b].of_ground != 7) continue;
    if (ramps[b].motion == 0) return static_cast<int>(b);
    if (found < 0) found = static_cast<int>(b);
  }
  return found;
}

std::vector<std::int32_t> Simulation::Impl::support_groups(const Stage& settings) const {
  const std::size_t blocks =
      large_motion ? static_cast<std::size_t>(large_motion->block_count()) : model.assembly.bricks.size();
  std::vector<std::int32_t> group(blocks, 0);
  if (!settings.ground || settings.ground->supports.empty()) return group;
  std::optional<blocks::Assembly> of_bricks;
  if (!large_motion) of_bricks = blocks::from_bricks(model.assembly);
  const blocks::Assembly& assembly = large_motion ? large_motion->assembly : *of_bricks;
  std::int32_t index = 0;
  for (const GroundMotion& support : settings.ground->supports) {
    ++index;
    for (const std::string& name : support.blocks) {
      for (const int block : blocks::find_blocks(assembly, name, settings.source.text)) {
        std::int32_t& of_block = group[static_cast<std::size_t>(block)];
        if (!assembly.blocks[static_cast<std::size_t>(block)].fixed)
          throw Error(Exit::bad_input,
                      fmt::format("{}: ground_motion.support.{}: block '{}' is not fixed, and only supports follow "
                                  "records; give it fixed = true",
                                  settings.source.text, index, name));
        if (of_block != 0)
          throw Error(Exit::bad_input, fmt::format("{}: ground_motion.support.{}: block '{}' is in two groups of "
                                                   "supports, {} and {}; leave it in one",
                                                   settings.source.text, index, name, of_block, index));
        of_block = index;
      }
    }
  }
  return group;
}

const Drive* Simulation::Impl::ground_drive() const {
  const Drive* found = nullptr;
  for (const Drive& drive : drives) {
    if (drive.of_ground != 7) continue;
    if (drive.motion == 0) return &drive;
    if (!found) found = &drive;
  }
  return found;
}

// The ground is all fixed blocks that no table of the stage drives. What earlier records have left of its velocity goes
// on, or fades over the ramp of the stage if it has one.
void Simulation::Impl::bind_ground(const Stage& settings, const Stage*) {
  const auto old = std::find_if(drives.begin(), drives.end(), [](const Drive& d) { return d.of_ground != 0; });
  const Vector left_over = old == drives.end() ? Vector{} : old->velocity_from;
  const std::vector<std::int32_t> groups = support_groups(settings);
  std::vector<std::int32_t> drive_of(static_cast<std::size_t>(large_motion->block_count()), -1);
  for (std::size_t d = 0; d < drives.size(); ++d)
    drive_of[static_cast<std::size_t>(drives[d].block)] = static_cast<std::int32_t>(d);
  std::set<int> controlled;
  for (const BodyControl& control : settings.controls) {
    for (const int block : blocks_named(control.body, settings.source.text)) controlled.insert(block);
  }
  for (int block = 0; block < large_motion->block_count(); ++block) {
    if (!large_motion->assembly.blocks[static_cast<std::size_t>(block)].fixed || controlled.contains(block)) continue;
    std::int32_t& index = drive_of[static_cast<std::size_t>(block)];
    if (index < 0 && !settings.ground) continue;
    if (index < 0) {
      Drive drive;
      drive.block = block;
      drive.held = 0x3f;
      drive.velocity_from = large_motion->velocity(block);
      index = static_cast<std::int32_t>(drives.size());
      drives.push_back(drive);
    }
    Drive& drive = drives[static_cast<std::size_t>(index)];
    if (!settings.ground && !drive.of_ground) continue;  // has been driven by itself, and comes to rest
    // What has moved with the ground before goes on as it did, group by group.
    const Vector goes_on = drive.of_ground ? drive.velocity_from : left_over;
    drive.of_ground = 7;
    if (settings.ground) drive.motion = groups[static_cast<std::size_t>(block)];
    drive.velocity_to = settings.ramp_time > 0.0 ? Vector{} : goes_on;
  }
}

// What damping brakes against. It moves as its first block does.
void Simulation::Impl::follow_ground(const Stage& settings, double s) {
  const Drive* const ground = ground_drive();
  const bool on_springs = large_motion->members() && !large_motion->members()->beds().empty();
  if (!ground && !on_springs) return large_motion->move_ground({}, {});
  const Vector left_over =
      ground ? ground->velocity_from + s * (ground->velocity_to - ground->velocity_from) : Vector{};
  const std::int32_t motion = ground ? ground->motion : 0;
  const double now = large_motion->time(), half = 0.5 * large_motion->time_step();
  large_motion->move_ground(left_over + record_velocity(settings, now - half, motion),
                            left_over + record_velocity(settings, now, motion));
}

void Simulation::Impl::follow_ground_of_lattice(double s) {
  const int body = ground_body();
  data.ground_velocity = {};
  if (body < 0 || stage < 0) return;
  const BodyRamp& ramp = ramps[static_cast<std::size_t>(body)];
  const double half = data.damping == DampingKind::viscous ? 0.0 : 0.5 * data.time_step;
  const Vector record = record_velocity(scene.stages[at_stage()], now() - half, static_cast<std::int32_t>(ramp.motion));
  for (std::size_t c = 0; c < 3; ++c)
    data.ground_velocity[c] =
        ramp.velocity_from[c] + s * (ramp.velocity_to[c] - ramp.velocity_from[c]) + record[static_cast<int>(c)];
}

// What stands on fixed blocks does to them.
void Simulation::Impl::measure_base(HistoryRow& row) const {
  if (!large_motion) return measure_base_on_lattice(row);
  const Drive* const ground = ground_drive();
  Vec3 moved{};  // by now, as the contact points
  if (ground) {
    moved = block_translation(ground->block);
    row.ground_displacement = block_translation_at_forces({ground->block});
  }
  const double whole = model.assembly.symmetry_factor;
  const auto& blocks = large_motion->assembly.blocks;
  for (int block = 0; block < large_motion->block_count(); ++block) {
    if (!blocks[static_cast<std::size_t>(block)].fixed) continue;
    const Vec3 joints = geometry::array(large_motion->contact_force(block));
    for (std::size_t c = 0; c < 3; ++c) row.base_force[c] += whole * joints[c];
  }
  for (std::size_t i = 0; large_motion->members() && i < large_motion->members()->beds().size(); ++i) {
    const Vec3 bed = geometry::array(large_motion->members()->force_of(large_motion->members()->beds()[i]));
    for (std::size_t c = 0; c < 3; ++c) row.base_force[c] -= bed[c];
  }
  if (in_parts) return;  // no rank has all contact points
  const Vector centre = base_centre + geometry::vector(moved);
  Vector moment;
  for (const blocks::Contact& c : large_motion->contacts.list) {
    const bool a = blocks[static_cast<std::size_t>(c.pair.a)].fixed,
               b = blocks[static_cast<std::size_t>(c.pair.b)].fixed;
    if (a == b) continue;
    const blocks::Family& f = large_motion->families()[static_cast<std::size_t>(c.family)];
    for (std::size_t i = c.first; i < c.first + c.count; ++i) {
      const geometry::Matrix frame = large_motion->frame_of(f.point[i]);
      Vector on_a;
      for (std::size_t k = 0; k < 3; ++k)
        on_a += f.point[i].area * (f.traction[k][i] + (f.viscous[k].empty() ? 0.0 : f.viscous[k][i])) *
                frame.row[static_cast<int>(k)];
      moment += (a ? whole : -whole) * cross(large_motion->place_of(f.point[i]) - centre, on_a);
    }
  }
  row.overturning_moment = geometry::array(moment);
}

void Simulation::Impl::measure_base_on_lattice(HistoryRow& row) const {
  const int ground = ground_body();
  if (ground >= 0) {
    const Vec3 moved = of_body(ground, &BodyLanes::displacement), v = of_body(ground, &BodyLanes::velocity);
    for (std::size_t c = 0; c < 3; ++c) row.ground_displacement[c] = moved[c] - data.time_step * v[c];
  }
  const double whole = model.assembly.symmetry_factor;
  Vector moment;
  bool any = false;
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) {
    if (!model.assembly.bricks[static_cast<std::size_t>(model.bodies[static_cast<std::size_t>(b)].block)].fixed)
      continue;
    const JointWrench joints = has_all() ? sum_joint_wrench(b) : body_wrench[static_cast<std::size_t>(b)];
    any = true;
    for (std::size_t c = 0; c < 3; ++c) row.base_force[c] += whole * joints.force[c];
    moment += whole * (geometry::vector(joints.moment) +
                       cross(geometry::vector(joints.centre) - base_centre, geometry::vector(joints.force)));
  }
  if (any) row.overturning_moment = geometry::array(moment);
}

// Centre of the beds between fixed bricks and others, at the start.
void Simulation::Impl::find_base_of_lattice() {
  const auto is_fixed = [&](int brick) { return model.assembly.bricks[static_cast<std::size_t>(brick)].fixed; };
  base_centre = {};
  double area = 0.0;
  const auto& bricks = model.assembly.bricks;
  for (std::size_t j = 0; j < model.assembly.joints.size(); ++j) {
    const Joint& joint = model.assembly.joints[j];
    if (joint.face_a / 2 != 1 || is_fixed(joint.block_a) == is_fixed(joint.block_b)) continue;
    const Brick &a = bricks[static_cast<std::size_t>(joint.block_a)],
                &b = bricks[static_cast<std::size_t>(joint.block_b)];
    double of_joint = 1.0;
    for (const std::size_t c : {std::size_t{0}, std::size_t{2}})
      of_joint *= std::min(a.origin[c] + a.size[c], b.origin[c] + b.size[c]) - std::max(a.origin[c], b.origin[c]);
    area += of_joint;
    base_centre += of_joint * geometry::vector(joint_sliding.centre(static_cast<int>(j)));
  }
  if (area > 0.0) base_centre = base_centre / area;
}

}  // namespace quoin
