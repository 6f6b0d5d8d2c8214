#include "step/state/lattice_state.h"

namespace quoin {

Vec3 LatticeState::of_body(int body, BodyLanes::Quantity BodyLanes::*quantity) const {
  const auto [index, lane] = place[static_cast<std::size_t>(body)];
  const BodyLanes::Quantity& value = bodies[static_cast<std::size_t>(index)].*quantity;
  return {value[0][lane], value[1][lane], value[2][lane]};
}

}  // namespace quoin
