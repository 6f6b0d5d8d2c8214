#include "step/actions/ground.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/index.h"
#include "base/smooth_step.h"
#include "members/members.h"
#include "model/world_results.h"
#include "scene/brick_overlap.h"
#include "scene/from_bricks.h"
#include "scene/generate_blocks.h"
#include "scene/weight_axis.h"
#include "step/actions/action.h"
#include "step/block_motion.h"
#include "step/gather.h"
#include "step/reactions.h"
#include "step/small_motion.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

using geometry::Vector;

namespace {

// Components that follow the ground; those that a controller has set are 0.
Vector followed(std::uint64_t of_ground, Vector velocity) {
  for (int c = 0; c < 3; ++c) {
    if ((of_ground >> c & 1) == 0) velocity[c] = 0.0;
  }
  return velocity;
}

}  // namespace

Vector record_velocity(const Simulation::Impl& s, const Stage& of_stage, double time, std::int32_t motion) {
  if (!of_stage.ground) return {};
  const GroundMotion& ground = *of_stage.ground;
  if (motion > static_cast<std::int32_t>(ground.supports.size())) return {};  // a group of supports of an earlier stage
  const GroundMotion& moving = motion > 0 ? ground.supports[static_cast<std::size_t>(motion) - 1] : ground;
  Vector of_record;
  for (const GroundMotion::Component& c : moving.components)
    of_record +=
        c.velocity.at(c.acceleration, time - s.progress.stage_start) * normalized(geometry::vector(c.direction));
  return of_record;
}

// Velocities of blocks are those of half a step before; those of records are current, and may be back at rest.
Vector record_since_half_step(const Simulation::Impl& s, const Stage* of_stage, std::int32_t motion) {
  if (!of_stage) return {};
  const double half = 0.5 * s.data.time_step;
  return record_velocity(s, *of_stage, time_now(s), motion) - record_velocity(s, *of_stage, time_now(s) - half, motion);
}

std::vector<std::int32_t> support_groups(const Simulation::Impl& s, const Stage& settings) {
  std::vector<std::int32_t> group(at(block_count(s)), 0);
  if (!settings.ground || settings.ground->supports.empty()) return group;
  const auto blocks_of = [&](const std::string& name) {
    std::vector<int> bricks;
    for (std::size_t b = 0; !s.large_motion && b < group.size(); ++b)
      if (const Brick& brick = s.model.assembly.bricks[b]; brick.name == name || brick.body == name)
        bricks.push_back(static_cast<int>(b));
    if (!bricks.empty()) return bricks;
    return blocks::find_blocks(s.large_motion ? s.large_motion->assembly : blocks::from_bricks(s.model.assembly), name,
                               settings.source.text);
  };
  std::int32_t index = 0;
  for (const GroundMotion& support : settings.ground->supports) {
    ++index;
    for (const std::string& name : support.blocks) {
      for (const int block : blocks_of(name)) {
        std::int32_t& of_block = group[static_cast<std::size_t>(block)];
        if (!(s.large_motion ? s.large_motion->assembly.blocks[at(block)].fixed
                             : s.model.assembly.bricks[at(block)].fixed))
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

const Drive* Actions::ground_drive() const {
  const Drive* found = nullptr;
  int highest = 0;
  for (const Drive& drive : drives) {
    const int rank = ground_rank(drive.of_ground, drive.motion);
    if (rank > highest) highest = rank, found = &drive;
  }
  return found;
}

int ground_block(const Simulation::Impl& s) {
  if (const Drive* const drive = s.actions.ground_drive()) return drive->block;
  for (int earlier = s.progress.stage - 1; earlier >= 0; --earlier) {
    const Stage& settings = s.scene.stages[static_cast<std::size_t>(earlier)];
    if (!settings.ground) continue;
    const std::vector<std::int32_t> group = support_groups(s, settings);
    for (std::size_t i = 0; i < group.size(); ++i) {
      if (group[i] == 0 && is_fixed(s, static_cast<int>(i))) return static_cast<int>(i);
    }
  }
  return -1;
}

namespace {

// Velocity that earlier records have left, at a time. It changes from the one to the other over the ramp of the stage
// that runs; when a stage begins, of the one before.
Vector left_over_at(const Simulation::Impl& s, const Vector& from, const Vector& to, double time) {
  const double ramp = current_stage(s).ramp_time;
  return from + (ramp > 0.0 ? smooth_step((time - s.progress.stage_start) / ramp) : 1.0) * (to - from);
}

// Velocity of the ground below springs that no block follows, m/s, in a stage that runs.
Vector velocity_below_springs(const Simulation::Impl& s, const Stage& stage, double time) {
  const Vector& left = s.actions.ground_left;
  return left_over_at(s, left, stage.ramp_time > 0.0 ? Vector{} : left, time) + record_velocity(s, stage, time, 0);
}

// That at the end of the stage before, with which this one begins.
Vector left_below_springs(const Simulation::Impl& s, const Stage* previous) {
  if (s.actions.ground_drive() || beds_of(s).empty() || !previous) return {};
  const Vector left = velocity_below_springs(s, *previous, time_now(s));
  return norm(left) <= kGroundAtRest ? Vector{} : left;
}

// The ground consists of all fixed blocks that no table of the stage drives. Velocity that earlier records have left
// continues, or fades over the ramp of the stage.
void bind_ground(Simulation::Impl& s, const Stage& settings, const Stage* previous) {
  s.actions.ground_left = left_below_springs(s, previous);
  const Drive* const old = s.actions.ground_drive();
  const Vector left_over = old ? followed(old->of_ground, old->velocity_from) : s.actions.ground_left;
  const std::vector<std::int32_t> groups = support_groups(s, settings);
  std::vector<std::int32_t> drive_of(groups.size(), -1);
  for (std::size_t d = 0; d < s.actions.drives.size(); ++d)
    drive_of[static_cast<std::size_t>(s.actions.drives[d].block)] = static_cast<std::int32_t>(d);
  std::set<int> controlled;
  for (const BodyControl& control : settings.controls) {
    for (const int block : blocks_named(s, control.body, settings.source.text)) controlled.insert(block);
  }
  for (int block = 0; block < block_count(s); ++block) {
    if (!is_fixed(s, block) || controlled.contains(block)) continue;
    std::int32_t& index = drive_of[static_cast<std::size_t>(block)];
    if (index < 0 && !settings.ground) continue;
    if (index < 0) {
      index = static_cast<std::int32_t>(s.actions.drives.size());
      s.actions.drives.emplace_back(Drive{block, kAllPrescribed}).velocity_from = velocity_of(s, block);
    }
    Drive& drive = s.actions.drives[static_cast<std::size_t>(index)];
    if (!settings.ground && !drive.of_ground) continue;  // was driven by a table before, and comes to rest
    // Blocks that moved with the ground before continue, group by group. Others join it.
    if (!drive.of_ground) drive.velocity_from = left_over;
    const Vector goes_on = followed(drive.of_ground ? drive.of_ground : kOfGround, drive.velocity_from);
    drive.of_ground = kOfGround;
    if (settings.ground) drive.motion = groups[static_cast<std::size_t>(block)];
    drive.velocity_to = settings.ramp_time > 0.0 ? Vector{} : goes_on;
  }
}

// Sets the velocity of the ground, from which damping takes velocities: that of its first block.
void follow_ground(Simulation::Impl& s, const Stage& settings, double) {
  const Drive* const ground = s.actions.ground_drive();
  const auto velocity = [&](double time) {
    if (!ground) return beds_of(s).empty() ? Vector{} : velocity_below_springs(s, settings, time);
    return left_over_at(s, ground->velocity_from, ground->velocity_to, time) +
           followed(ground->of_ground, record_velocity(s, settings, time, ground->motion));
  };
  const double now = time_now(s), dt = s.data.time_step;
  if (s.large_motion) return s.large_motion->move_ground(velocity(now - 0.5 * dt), velocity(now));
  s.data.ground_velocity = geometry::array(velocity(s.data.mass_damping > 0.0 ? now : now - 0.5 * dt));
}

}  // namespace

void warn_of_no_monitor(Simulation::Impl& s, std::vector<Warning>* warnings) {
  if (!current_stage(s).ground || !shown_blocks(s).empty()) return;
  warn_once(s, "monitor",
            fmt::format(
                "stage '{}' moves the ground, and no block is watched: displacement and force of the monitor "
                "are empty in its rows, whatever moves; give a monitor; those of [[monitor]] are in monitors.csv alone",
                current_stage(s).name),
            warnings);
}

void measure_base(const Simulation::Impl& s, std::span<const JointWrench> supports, std::span<const std::uint8_t> held,
                  HistoryRow& row) {
  Vec3 moved{};  // displacement of the ground when the contact points of the wrenches were where they count
  if (const int ground = ground_block(s); ground >= 0) {
    row.ground_displacement = displacement_at_forces(s, {ground});
    moved = s.large_motion ? displacement_now(s, {ground}) : row.ground_displacement;
  } else if (!beds_of(s).empty()) {
    moved = row.ground_displacement = geometry::array(members_of(s)->ground());
  }
  const Vector centre = s.reactions.base_centre + geometry::vector(moved);
  Vector force, moment;
  bool is_held = s.large_motion != nullptr;
  for (std::size_t i = 0; i < supports.size(); ++i) {
    const int block = s.reactions.restrained_blocks[i];
    if (!is_fixed(s, block) || held[at(block)] == 0) continue;
    const Vector on_block = geometry::vector(supports[i].force);
    is_held = true;
    force += on_block;
    moment += geometry::vector(supports[i].moment) + cross(geometry::vector(supports[i].centre) - centre, on_block);
  }
  for (const members::Bed& bed : beds_of(s)) {
    force -= bed.force();
    for (const members::SpringPoint& p : bed.points)
      moment -= cross(members_of(s)->nodes()[at(p.node)].x - centre, p.state.force);
  }
  row.base_force = force_on_whole(s, geometry::array(force));
  if (is_held) row.overturning_moment = moment_on_whole(s, geometry::array(moment));
}

// Centre of the beds between fixed bricks and others, at the start.
void find_base_of_lattice(Simulation::Impl& s) {
  const auto is_fixed = [&](int brick) { return s.model.assembly.bricks[at(brick)].fixed; };
  const int upright = upright_axis(s.scene);
  s.reactions.base_centre = {};
  double area = 0.0;
  const auto& bricks = s.model.assembly.bricks;
  for (std::size_t j = 0; j < s.model.assembly.joints.size(); ++j) {
    const Joint& joint = s.model.assembly.joints[j];
    if (joint.face_a / 2 != upright || is_fixed(joint.block_a) == is_fixed(joint.block_b)) continue;
    const Overlap shared = overlap_of(bricks[at(joint.block_a)], bricks[at(joint.block_b)]);
    const double of_joint = shared.gap(at((upright + 1) % 3)) * shared.gap(at((upright + 2) % 3));
    area += of_joint;
    s.reactions.base_centre += of_joint * geometry::vector(s.small_motion.joint_sliding.centre(static_cast<int>(j)));
  }
  if (area > 0.0) s.reactions.base_centre = s.reactions.base_centre / area;
}

extern const Action kGround{.names =
                                [](const Stage& stage, const VisitName& visit) {
                                  if (!stage.ground) return;
                                  for (const GroundMotion& support : stage.ground->supports)
                                    std::for_each(support.blocks.begin(), support.blocks.end(), visit);
                                },
                            .bind = bind_ground,
                            .apply = follow_ground,
                            .saved = kSaved<&Actions::ground_left>,
                            .on_lattice = true};

}  // namespace quoin
