// How pictures show what a place in a joint has come to.
#pragma once

#include <array>

#include "results/surface.h"

namespace quoin {

struct CrackStyle {
  Crack crack;
  const char* label;
  const char* colour;
  double width;
};
// From the least to the worst, the order of the legend and of drawing. Colours that stay apart for the colour-blind.
inline constexpr std::array<CrackStyle, kCrackCount> kCrackStyles{
    {{Crack::intact, "intact joint", "#8a7a68", 1.2},
     {Crack::sliding_begun, "sliding begun", "#6baed6", 4.0},
     {Crack::opening_begun, "opening begun", "#fdae2b", 4.0},
     {Crack::slipped, "slipped", "#08519c", 5.0},
     {Crack::open, "open crack", "#d7191c", 5.0},
     {Crack::crushed, "crushed", "#7b1fa2", 5.0}}};

}  // namespace quoin
