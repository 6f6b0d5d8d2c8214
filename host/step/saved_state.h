// Contents of a checkpoint beside the arrays of blocks in large motion: the fields of the lattice, then single numbers
// in order. Saving and restoring both use these functions.
#pragma once

#include "base/archive.h"
#include "step/actions/actions.h"
#include "step/lattice_fields.h"
#include "step/state.h"

namespace quoin {

inline constexpr char kCheckpointMark[8] = {'Q', 'U', 'O', 'I', 'N', 'C', '2', '3'};

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
                 s.small_motion.next_check, s.watch);
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

}  // namespace quoin
