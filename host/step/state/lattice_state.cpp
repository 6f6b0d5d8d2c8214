#include "step/state/lattice_state.h"

namespace quoin {

Vec3 LatticeState::of_body(int body, BodyLanes::Quantity BodyLanes::*quantity) const {
  const auto [index, lane] = place[static_cast<std::size_t>(body)];
  const BodyLanes::Quantity& value = bodies[static_cast<std::size_t>(index)].*quantity;
  return {value[0][lane], value[1][lane], value[2][lane]};
}

Vec3 LatticeState::mean_of(const std::vector<int>& some, BodyLanes::Quantity BodyLanes::*quantity) const {
  Vec3 mean{};
  for (const int b : some) {
    const Vec3 value = of_body(b, quantity);
    for (std::size_t c = 0; c < 3; ++c) mean[c] += value[c] / static_cast<double>(some.size());
  }
  return mean;
}

}  // namespace quoin
