// Results of laws at contact points in a step without motion: flags, damage, conditions.
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
// Evaluates the laws with this capability in a step without motion. All results but `outputs` go to scratch.
void evaluate_points_at_rest(const Simulation::Impl& s, std::uint64_t capability, const PointRange& range,
                             const PointOutputs& outputs);
std::vector<std::uint32_t> current_flags(const Simulation::Impl& s, const PointRange& range);
// Number of contact points in each condition: of all points, which this process must hold; as a sum over all ranks.
std::array<long, kConditionCount> conditions_here(const Simulation::Impl& s);
std::array<long, kConditionCount> conditions_of_all(Simulation::Impl& s);

}  // namespace quoin
