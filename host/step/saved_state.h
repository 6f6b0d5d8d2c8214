// Contents of a checkpoint beside the arrays of blocks in large motion: the fields of the lattice, then single numbers
// in order. Saving and restoring both use these functions.
#pragma once

#include "base/archive.h"
#include "step/actions/actions.h"
#include "step/lattice_fields.h"
#include "step/state.h"

namespace quoin {

inline constexpr char kCheckpointMark[8] = {'Q', 'U', 'O', 'I', 'N', 'C', '2', '4'};

template <class Archive, class Impl>
void transfer_state(Archive& archive, Impl& s) {
  each_lattice_field(s.lattice, [&](const Field& field, auto& array, int family) {
    if (!field.saved) return;
    if constexpr (requires { archive.part_of(field, array, family); })
      archive.part_of(field, array, family);
    else
      archive.array(array);
  });
  archive.value(s.controls.gravity_from);
  archive.value(s.controls.gravity_to);
  archive.value(s.controls.jack);
  archive.value(s.data.gravity);
  archive.value(s.progress.step);
  archive.value(s.progress.clock_start);
  archive.value(s.progress.clock_start_step);
  archive.value(s.progress.stage_step);
  archive.value(s.progress.stage_start);
  archive.value(s.monitor.start);
  archive.value(s.energy.dissipated);
  archive.value(s.energy.damping);
  archive.value(s.energy.external);
  archive.value(s.energy.lost_at_changes);
  archive.value(s.progress.unbalanced_ratio);
  archive.value(s.energy.kinetic);
  archive.value(s.progress.calm_checks);
  archive.value(s.progress.next_frame);
  archive.value(s.progress.next_row);
  archive.value(s.progress.row_interval);
  archive.value(s.progress.in_stage);
  archive.value(s.small_motion.seen);
  archive.value(s.small_motion.next_check);
  archive.value(s.watch);
  archive.value(s.damage);
  archive.list(s.outcome.warnings, [](auto& a, auto& warning) {
    a.array(warning.about);
    a.array(warning.text);
    a.value(warning.stage);
    a.value(warning.step);
    a.value(warning.time);
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
  archive.value(p.stage);
  archive.value(p.step);
  archive.value(p.time);
  archive.value(p.strain_energy);
  archive.value(p.energy_jump);
}

}  // namespace quoin
