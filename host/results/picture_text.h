// What pictures say of a run in words, in gnuplot's grammar.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"
#include "step/simulation.h"

namespace quoin {

// The title of a scene, or the name of its file.
std::string title_of(const Scene& scene);

// "stage 2 shake, 1.25 s" of the last row; empty without rows.
std::string moment_of(const std::vector<HistoryRow>& rows, const Scene& scene);

// A gnuplot string of a text that is not wider than so many pixels of a PNG in so many points of DejaVu Sans. A longer
// one is cut, and ends in "...".
std::string fitting_text(const std::string& text, double pixels, double points);

}  // namespace quoin
