// Checkpoint of blocks in large motion: all data that change in a run. Data that follow from the scene are built again.
// Saving and restoring both use this list.
#pragma once

#include "base/archive.h"
#include "members/members.h"
#include "model/fields.h"
#include "step/large_motion.h"

namespace quoin::blocks {

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

}  // namespace quoin::blocks
