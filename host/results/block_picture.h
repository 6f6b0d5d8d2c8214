// Pictures of blocks of any shape where they stand: mechanism.png by displacement, cracks.png by the state of joints.
// Plane assemblies from the front, others in axonometric projection.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

inline constexpr int kMostBlocks = 3000;  // each further thousand polygons takes gnuplot seconds

// Of fewer blocks, all of which this process must have, at the moment of the last of the rows. Return a one-line notice
// when there is no picture, otherwise nothing. label: of warnings.h, or nothing.
std::string plot_mechanism(const std::filesystem::path& folder, const Simulation& simulation,
                           const std::vector<HistoryRow>& rows, const std::string& label);
std::string plot_block_cracks(const std::filesystem::path& folder, const Simulation& simulation,
                              const Surfaces& surfaces, const std::vector<HistoryRow>& rows, const std::string& label);

}  // namespace quoin
