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
    a.value(load.block);
    a.value(load.point);
    a.value(load.force);
    a.list(load.share, [](auto& inner, auto& share) {
      inner.value(share.first);
      inner.value(share.second);
    });
    a.value(load.arm);
    a.value(load.scale);
  });
  archive.list(m.actions.pressures, [](auto& a, auto& pressure) {
    a.value(pressure.block);
    a.value(pressure.face);
    a.value(pressure.value);
    a.array(pressure.triangles);
    a.value(pressure.arm);
    a.value(pressure.push);
    a.value(pressure.scale);
  });
  archive.array(m.actions.loaded);
  archive.array(m.actions.applied);
  archive.value(m.actions.gravity);
  archive.value(m.actions.of_collapse);

  archive.value(m.is_small);
  archive.value(m.is_settling);
  archive.value(m.stepping.time);
  archive.value(m.stepping.dt);
  archive.value(m.stepping.critical_dt);
  archive.value(m.stepping.omega);
  archive.value(m.stepping.springs);
  archive.array(m.impacts.landing);
  archive.value(m.impacts.zone_beta);
  archive.value(m.impacts.stable_dt);
  archive.value(m.impacts.share);
  archive.value(m.impacts.maxwell);
  archive.value(m.stepping.stiffness_bound);
  archive.value(m.stepping.count);
  archive.value(m.checks.next);
  archive.value(m.checks.dt);
  archive.value(m.detection.count);
  archive.value(m.detection.narrow_calls);
  archive.value(m.step_sums.unbalanced);
  archive.value(m.step_sums.net);
  archive.value(m.step_sums.energies);
  archive.value(m.step_sums.later);
  archive.value(m.held_by.work);
  if (m.held_by.members) members::Members::transfer(archive, *m.held_by.members);
}

}  // namespace quoin::blocks
