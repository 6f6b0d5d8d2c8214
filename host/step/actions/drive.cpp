#include <algorithm>
#include <cmath>

#include "step/actions/action.h"
#include "step/actions/actions.h"
#include "step/actions/ground.h"
#include "step/block_motion.h"
#include "step/controls.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

using geometry::Vector;

namespace {

// Binds the drives of the stage, and those of blocks that it releases. Velocities and forces change from the current
// ones, forces of released components from the reactions of their supports. previous: the stage before; null: there is
// none.
void bind_drives(Simulation::Impl& s, const Stage& settings, const Stage* previous) {
  std::vector<Drive> before = std::move(s.actions.drives);
  s.actions.drives.clear();
  // let_turn: whether the drive leaves its rotation free.
  const auto start = [&](int block, bool let_turn) {
    Drive drive{block};
    drive.velocity_from = velocity_of(s, block);
    drive.omega_from = spin_of(s, block);
    const auto found = std::ranges::find(before, block, &Drive::block);
    Drive old;
    if (is_fixed(s, block)) old.held = kAllPrescribed;
    if (found != before.end()) old = *found;
    const Vector record = record_since_half_step(s, previous, old.motion);
    for (int c = 0; c < 3; ++c) {
      if (old.of_ground >> c & 1) drive.velocity_from[c] += record[c];
      if (std::abs(drive.velocity_from[c]) <= kGroundAtRest && old.of_ground) drive.velocity_from[c] = 0.0;
    }
    const Vector carried = (old.held & 7) != 0 ? -1.0 * net_force(s, block) : Vector{};
    for (int c = 0; c < 3; ++c) drive.force_from[c] = old.held >> c & 1 ? carried[c] : old.force_now[c];
    if (!let_turn) return drive;
    // Gridpoints that are held along any axis hold the rotation of a deformable block.
    const unsigned held_turns = is_rigid(s, block) ? old.held >> 3 : old.held & 7u ? 7u : 0u;
    const Vector clamped = held_turns != 0 ? -1.0 * net_moment(s, block) : Vector{};
    for (int c = 0; c < 3; ++c) drive.moment_from[c] = held_turns >> c & 1 ? clamped[c] : old.moment_now[c];
    return drive;
  };
  for (const BodyControl& control : settings.controls) {
    for (const int block : blocks_named(s, control.body, settings.source.text)) {
      Drive drive = start(block, control.may_turn);
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
      s.actions.drives.push_back(drive);
    }
  }
  for (const Drive& old : before) {
    if (s.actions.drive_of(old.block)) continue;
    const bool stays = is_fixed(s, old.block);
    Drive released = start(old.block, !stays);
    if (stays) {
      released.held = kAllPrescribed;
      released.force_from = {};
      released.of_ground = old.of_ground, released.motion = old.motion;
    }
    s.actions.drives.push_back(released);
  }
}

void drive_blocks(Simulation::Impl& s, const Stage& settings, double ramp) {
  const auto between = [ramp](const Vector& from, const Vector& to) {
    return ramp >= 1.0 ? to : from + ramp * (to - from);
  };
  std::vector<Vector> records;  // by motion
  for (std::size_t i = 0; settings.ground && i <= settings.ground->supports.size(); ++i)
    records.push_back(record_velocity(s, settings, time_now(s) + 0.5 * s.data.time_step, static_cast<std::int32_t>(i)));
  for (Drive& d : s.actions.drives) {
    const auto motion = static_cast<std::size_t>(d.motion);
    const Vector record = motion < records.size() ? records[motion] : Vector{};
    Vector driven = between(d.velocity_from, d.velocity_to);
    for (int c = 0; c < 3; ++c) {
      if (d.in_cycles >> c & 1) driven[c] = velocity_in_cycles(s, d.velocity_from[c]);
      if (d.of_ground >> c & 1) driven[c] += record[c];
    }
    prescribe(s, d.block, driven, between(d.omega_from, d.omega_to), d.held);
    d.force_now = between(d.force_from, d.force_to), d.moment_now = between(d.moment_from, {});
    if (norm(d.force_now) + norm(d.force_from) + norm(d.moment_from) > 0.0)
      apply_force(s, d.block, d.force_now, d.moment_now);
  }
}

}  // namespace

// The force stays in the drive, from which the next stage takes it over its ramp.
void pull_block(Simulation::Impl& s, int block, double pull) {
  Drive* const known = s.actions.drive_of(block);
  Drive& drive = known ? *known : s.actions.drives.emplace_back(Drive{block});
  drive.force_now.x = pull;
  apply_force(s, block, drive.force_now);
}

extern const Action kDrive{.names =
                               [](const Stage& stage, const VisitName& visit) {
                                 for (const BodyControl& control : stage.controls) visit(control.body);
                               },
                           .bind = bind_drives,
                           .apply = drive_blocks,
                           .saved = kSaved<&Actions::drives>,
                           .on_lattice = true};

}  // namespace quoin
