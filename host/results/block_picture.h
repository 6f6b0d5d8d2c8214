// Pictures of blocks of any shape in their current places: mechanism.png by displacement, cracks.png by the state of
// joints. Plane assemblies are seen from the front, others in axonometric projection.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

inline constexpr int kMostBlocks = 3000;  // more would take gnuplot seconds per thousand polygons

// Draw fewer than kMostBlocks blocks, all of which this rank must have, at the time of the last row. Return a one-line
// notice when there is no picture, otherwise an empty text. label: of warnings.h, or empty.
std::string plot_mechanism(const std::filesystem::path& folder, const Simulation& simulation,
                           const std::vector<HistoryRow>& rows, const std::string& label);
std::string plot_block_cracks(const std::filesystem::path& folder, const Simulation& simulation,
                              const Surfaces& surfaces, const std::vector<HistoryRow>& rows, const std::string& label);

}  // namespace quoin
