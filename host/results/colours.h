// Colours of everything that is drawn of a run: pictures, page and Python have them from here.
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

// Of quantities: nothing, the most, and the most below nothing. Both ways it grows darker, so that grey shows how much.
struct QuantityColours {
  const char *middle, *warm, *cold;
};
inline constexpr QuantityColours kQuantityColours{"#e9e2d0", "#a50f15", "#2c4fa3"};

// Of curves, one after the other; they differ in lightness, too.
inline constexpr std::array kPens{"#b3321e", "#1d3557", "#5aa9e6", "#e8a33d", "#2a9d8f",
                                  "#8d6a9f", "#777777", "#b08968", "#000000"};

}  // namespace quoin
