// Pictures by gnuplot: curve.png, histories.png and cracks.png. Scripts and data remain in DIR/plots, to be edited and
// run again.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

// Highest resistance of a history, as absolute values: along the wall, or vertical if the last stage is (history.h).
// Then only vertical stages count. row: -1: there is none.
struct Peak {
  int row = -1;
  double force = 0.0, displacement = 0.0, vertical_force = 0.0;
};
Peak find_peak(const std::vector<HistoryRow>& rows, const Scene& scene);

// Part whose displacement the history of a stage has: "top beam", "top course", "roof".
std::string moved_part(const Scene& scene, const Stage& stage);

// Draw a picture. Return a one-line notice without one (no gnuplot), otherwise an empty text. label: of warnings.h, or
// empty.
std::string plot_curve(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                       const std::string& law, const std::string& label);
// Displacements, forces, multiplier and energies over time, a panel each, without lines that stay at 0.
std::string plot_histories(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                           const std::string& label);
// Cracks on the lattice. Other ranks call collect_cracks at the same time.
std::string plot_cracks(const std::filesystem::path& folder, const Simulation& simulation, const Surfaces& surfaces,
                        const std::vector<HistoryRow>& rows, const std::string& law, const std::string& label);
void collect_cracks(const Simulation& simulation, const Surfaces& surfaces);

}  // namespace quoin
