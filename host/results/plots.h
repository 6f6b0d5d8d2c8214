// Pictures by gnuplot: curve.png, histories.png, base_shear.png, drifts.png and cracks.png. Scripts and data remain in
// DIR/plots, to be edited and run again.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "results/monitors.h"
#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

// Part whose displacement the history of a stage has: "top beam", "top course", "roof".
std::string moved_part(const Scene& scene, const Stage& stage);

// Whether two stages watch the same part along the same axis. Rows of others belong to another curve.
bool same_curve(const Scene& scene, const Stage& a, const Stage& b);
// Stage whose part and axis the curve and the peak of a run have: the last that watches a part and does more than rest.
const Stage& stage_of_curve(const Scene& scene);
// Whether a stage watches the part of the curve, along any axis.
bool watches_part_of_curve(const Scene& scene, const Stage& stage);
// By stage: whether its rows are on the curve.
std::vector<bool> stages_on_curve(const Scene& scene);
// Whether stages of a run watch different parts, so that texts name the part.
bool watches_several(const Scene& scene);

// Highest resistance on the curve, as absolute values: along the wall, or vertical if the stage of the curve is.
// row: -1: there is none.
struct Peak {
  int row = -1;
  double force = 0.0, displacement = 0.0, vertical_force = 0.0;
};
Peak find_peak(const std::vector<HistoryRow>& rows, const Scene& scene);
// Displacement at which the resistance has fallen to `kept` times the peak, on the side of the peak; empty: never. Rows
// count that go farther to this side than all before. When the wall is unloaded or pushed back, a smaller force is no
// loss.
std::optional<double> displacement_at_loss(const std::vector<HistoryRow>& rows, const Scene& scene, const Peak& peak,
                                           double kept);

// -1 if displacements between these two are those of a push in the negative direction alone, which is drawn to the
// right with positive forces; else 1.
double sense_of_push(double lowest, double highest);

// Draw a picture. Return a one-line notice without one (no gnuplot), otherwise an empty text. label: of warnings.h, or
// empty.
std::string plot_curve(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                       const std::string& law, const std::string& label);
// Displacements, forces, multiplier and energies over time, a panel each, without lines that stay at 0.
std::string plot_histories(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                           const std::string& label);
// Hysteresis of an earthquake: base shear against displacement relative to the ground. Empty text without one.
std::string plot_base_shear(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows,
                            const Scene& scene, const std::string& label);
// Envelope of drifts over height, in both senses of x and z. Empty text without storeys.
std::string plot_drifts(const std::filesystem::path& folder, const std::vector<StoreyDrift>& storeys,
                        const Scene& scene, const std::string& label);
// Cracks on the lattice. Other ranks call collect_cracks at the same time.
std::string plot_cracks(const std::filesystem::path& folder, const Simulation& simulation, const Surfaces& surfaces,
                        const std::vector<HistoryRow>& rows, const std::string& law, const std::string& label);
void collect_cracks(const Simulation& simulation, const Surfaces& surfaces);

}  // namespace quoin
