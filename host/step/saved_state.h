// Contents of a checkpoint: the fields of the lattice, single numbers in order, then all of blocks in large motion.
// Data that follow from the scene are built again. Saving and restoring both use these functions.
#pragma once

#include "base/archive.h"
#include "members/members.h"
#include "model/fields.h"
#include "step/actions/actions.h"
#include "step/lattice_fields.h"
#include "step/state.h"

namespace quoin {

inline constexpr char kCheckpointMark[8] = {'Q', 'U', 'O', 'I', 'N', 'C', '2', '6'};

template <class Archive, class Impl>
void transfer_state(Archive& archive, Impl& s) {
  each_lattice_field(s.lattice, [&](const Field& field, auto& array, int family) {
    if (!field.saved) return;
    if constexpr (requires { archive.part_of(field, array, family); })
      archive.part_of(field, array, family);
    else
      archive.array(array);
  });
  archive.values(s.controls.gravity_from, s.controls.gravity_to, s.controls.jack, s.data.gravity, s.progress.step,
                 s.progress.clock_start, s.progress.clock_start_step, s.progress.stage_step, s.progress.stage_start,
                 s.monitor.start, s.energy.dissipated, s.energy.damping, s.energy.external, s.energy.lost_at_changes,
                 s.progress.unbalanced_ratio, s.energy.kinetic, s.progress.calm_checks, s.progress.next_frame,
                 s.progress.next_row, s.progress.row_interval, s.progress.in_stage, s.small_motion.seen,
                 s.small_motion.next_check, s.watch, s.damage);
  archive.list(s.outcome.warnings, [](auto& a, auto& warning) {
    a.array(warning.about);
    a.array(warning.text);
    a.values(warning.stage, warning.step, warning.time);
  });
  archive.value(s.progress.force_loss);
  archive.array(s.outcome.force_losses);
  if constexpr (std::is_base_of_v<ArchiveWriter, Archive>)
    save_actions(archive, s);
  else
    restore_actions(archive, s);
  if (!s.large_motion) return;
  archive.array(s.monitor.blocks);
  archive.value(s.monitor.stands_below);
  archive.optional(s.outcome.collapse_multiplier);
  archive.optional(s.outcome.base_slip_at_uplift);
}

template <class Archive, class Promotion>
void transfer_promotion(Archive& archive, Promotion& p) {
  archive.array(p.why);
  archive.values(p.stage, p.step, p.time, p.strain_energy, p.energy_jump);
}

namespace blocks {

template <class Archive, class Self>
void transfer_blocks(Archive& archive, Self& m) {
  archive.array(m.contacts.list);
  WorldFields::each(m, [&](const Field&, auto& array) { archive.array(array); });
  archive.value(m.units.count);
  archive.array(m.start_joints.kept);

  archive.list(m.actions.loads, [](auto& a, auto& load) {
    a.values(load.block, load.point, load.force);
    a.list(load.share, [](auto& inner, auto& share) { inner.values(share.first, share.second); });
    a.values(load.arm, load.scale);
  });
  archive.list(m.actions.pressures, [](auto& a, auto& pressure) {
    a.values(pressure.block, pressure.face, pressure.value);
    a.array(pressure.triangles);
    a.values(pressure.arm, pressure.push, pressure.scale);
  });
  archive.array(m.actions.loaded);
  archive.array(m.actions.applied);
  archive.values(m.actions.gravity, m.actions.of_collapse);

  archive.values(m.is_small, m.is_settling, m.stepping.time, m.stepping.dt, m.stepping.critical_dt, m.stepping.omega,
                 m.stepping.springs);
  archive.array(m.impacts.landing);
  archive.values(m.impacts.zone_beta, m.impacts.stable_dt, m.impacts.share, m.impacts.maxwell,
                 m.stepping.stiffness_bound, m.stepping.count, m.checks.next, m.checks.dt, m.detection.count,
                 m.detection.narrow_calls, m.step_sums.unbalanced, m.step_sums.net, m.step_sums.energies,
                 m.step_sums.later, m.held_by.work);
  if (m.held_by.members) members::Members::transfer(archive, *m.held_by.members);
}

}  // namespace blocks

}  // namespace quoin
