// Texts of pictures, in gnuplot's syntax.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"
#include "step/simulation.h"

namespace quoin {

// Title of a scene, or the name of its file.
std::string title_of(const Scene& scene);

// Time of the last row: "stage 2 shake, 1.25 s"; empty without rows.
std::string moment_of(const std::vector<HistoryRow>& rows, const Scene& scene);

// A gnuplot string of a text, cut with "..." to at most `pixels` of width in a PNG. points: size of the font, DejaVu
// Sans.
std::string fitting_text(const std::string& text, double pixels, double points);

}  // namespace quoin
