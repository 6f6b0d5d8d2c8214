// Ground motion: all fixed blocks that no table of a stage drives, and what stands on them does to them.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "members/members.h"
#include "scene/generate_blocks.h"
#include "step/actions/action.h"

namespace quoin {

using geometry::Vector;

Vector Simulation::Impl::record_velocity(const Stage& of_stage, double time) const {
  if (!of_stage.ground) return {};
  Vector of_record;
  for (const GroundMotion::Component& c : of_stage.ground->components)
    of_record += c.velocity.at(c.acceleration, time - stage_start_time) * normalized(geometry::vector(c.direction));
  return of_record;
}

// The ground is all fixed blocks that no table of the stage drives. What earlier records have left of its velocity goes
// on, or fades over the ramp of the stage if it has one.
void Simulation::Impl::bind_ground(const Stage& settings, const Stage*) {
  const auto old = std::find_if(drives.begin(), drives.end(), [](const Drive& d) { return d.of_ground != 0; });
  const Vector left_over = old == drives.end() ? Vector{} : old->velocity_from;
  std::vector<std::int32_t> drive_of(static_cast<std::size_t>(large_motion->block_count()), -1);
  for (std::size_t d = 0; d < drives.size(); ++d)
    drive_of[static_cast<std::size_t>(drives[d].block)] = static_cast<std::int32_t>(d);
  std::set<int> controlled;
  for (const BodyControl& control : settings.controls) {
    for (const int block : blocks_named(control.body, settings.source.text)) controlled.insert(block);
  }
  for (int block = 0; block < large_motion->block_count(); ++block) {
    if (!large_motion->assembly().blocks[static_cast<std::size_t>(block)].fixed || controlled.contains(block)) continue;
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
    drive.of_ground = 7;
    drive.velocity_to = settings.ramp_time > 0.0 ? Vector{} : left_over;
  }
}

// What damping brakes against. It moves as its first block does.
void Simulation::Impl::follow_ground(const Stage& settings, double s) {
  const auto ground = std::find_if(drives.begin(), drives.end(), [](const Drive& d) { return d.of_ground == 7; });
  const bool on_springs = large_motion->members() && !large_motion->members()->beds().empty();
  if (ground == drives.end() && !on_springs) return large_motion->move_ground({}, {});
  const Vector left_over =
      ground == drives.end() ? Vector{} : ground->velocity_from + s * (ground->velocity_to - ground->velocity_from);
  const double now = large_motion->time(), half = 0.5 * large_motion->time_step();
  large_motion->move_ground(left_over + record_velocity(settings, now - half),
                            left_over + record_velocity(settings, now));
}

// What stands on fixed blocks does to them.
void Simulation::Impl::measure_base(HistoryRow& row) const {
  const auto ground =
      std::find_if(drives.begin(), drives.end(), [](const Drive& drive) { return drive.of_ground == 7; });
  Vec3 moved{};  // by now, as the contact points
  if (ground != drives.end()) {
    moved = block_translation(ground->block);
    row.ground_displacement = block_translation_at_forces({ground->block});
  }
  const double whole = model.assembly.symmetry_factor;
  const auto& blocks = large_motion->assembly().blocks;
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
  for (const blocks::Contact& c : large_motion->contacts()) {
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

}  // namespace quoin
