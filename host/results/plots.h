// Pictures through gnuplot: curve.png, histories.png and cracks.png. Scripts and data stay in DIR/plots, to be changed
// and run again.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

// The highest resistance of a history, as absolute values. Along the wall; upright, in vertical stages, where the last
// one is such (history.h). row: -1 when there is none.
struct Peak {
  int row = -1;
  double force = 0.0, displacement = 0.0, vertical_force = 0.0;
};
Peak find_peak(const std::vector<HistoryRow>& rows, const Scene& scene);

// Whose displacement the history of a stage shows: "top beam", "top course", "roof".
std::string moved_part(const Scene& scene, const Stage& stage);

// Returns a one-line notice when there is no picture (no gnuplot), otherwise nothing. label: of warnings.h, or nothing.
std::string plot_curve(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                       const std::string& law, const std::string& label);
// Displacements, forces, multiplier and energies over time, a panel each; what stays at 0 is left out.
std::string plot_histories(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                           const std::string& label);
// Cracks on the lattice. Other ranks call collect_cracks at the same moment.
std::string plot_cracks(const std::filesystem::path& folder, const Simulation& simulation, const Surfaces& surfaces,
                        const std::vector<HistoryRow>& rows, const std::string& law, const std::string& label);
void collect_cracks(const Simulation& simulation, const Surfaces& surfaces);

}  // namespace quoin
