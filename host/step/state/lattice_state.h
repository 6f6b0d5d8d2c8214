// State of bricks on the lattice, which steps change: the arrays of step/lattice_fields.h, by which they are saved. In
// large motion they are empty.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/index.h"
#include "model/model.h"
#include "step/rigid_bodies.h"

namespace quoin {

struct LatticeState {
  LaneVector<double> displacement, velocity;  // by gridpoint: m at t, m/s at t - dt/2
  LaneVector<double> traction[3];             // by contact point, Pa
  std::vector<LaneVector<double>> law_state;  // per family: one column a state, column after column
  LaneVector<double> normal_shift;            // by contact point, m: added to the opening after law swaps; else empty
  // With impact damping, else empty: tractions of damping, Pa; opening of the last step, m, NaN where there was none.
  LaneVector<double> viscous[3], old_jump;
  std::vector<BodyLanes> bodies;           // body groups, then lone bodies
  std::vector<std::pair<int, int>> place;  // by body: index into bodies, lane; from the model
  LaneVector<std::uint32_t> flags;         // by contact point; not saved
  long flags_step = -1;                    // step of `flags`; -1: none

  bool damps_joints() const { return !old_jump.empty(); }
  Vec3 of_body(int body, BodyLanes::Quantity BodyLanes::*quantity) const {
    const auto [index, lane] = place[at(body)];
    const BodyLanes::Quantity& value = bodies[at(index)].*quantity;
    return {value[0][lane], value[1][lane], value[2][lane]};
  }
};

}  // namespace quoin
