// What laws say of their contact points when nothing moves: flags, damage, conditions.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "step/results.h"
#include "step/state.h"

namespace quoin {

// Fills the optional outputs of a batch with columns that begin at this contact point.
using PointOutputs = std::function<void(quoin_batch&, std::size_t first_point)>;

std::size_t contact_point_count(const Simulation::Impl& s);
inline PointRange whole_range(const Simulation::Impl& s) {
  return {0, static_cast<std::int32_t>(contact_point_count(s))};
}
// A step that moves nothing, into scratch but for these outputs: of the points whose law has the capability.
void ask_at_rest(const Simulation::Impl& s, std::uint64_t capability, const PointRange& range,
                 const PointOutputs& outputs);
std::vector<std::uint32_t> current_flags(const Simulation::Impl& s, const PointRange& range);
// How many contact points are in which state: of all, who has them; of chunks of this rank; of those of all ranks.
std::array<long, kConditionCount> conditions_here(const Simulation::Impl& s);
std::array<long, kConditionCount> conditions_of_all(Simulation::Impl& s);

}  // namespace quoin
