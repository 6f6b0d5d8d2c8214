// Colours of all drawings of a run: pictures, page and Python.
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
// From the least to the worst, the order of the legend and of drawing. Any two have a CIEDE2000 distance of at least
// 15, with normal sight and without red, green or blue cones; 7 in grey (tests/python/colours_test.py).
inline constexpr std::array<CrackStyle, kCrackCount> kCrackStyles{
    {{Crack::intact, "intact joint", "#958877", 1.2},
     {Crack::sliding_begun, "sliding begun", "#74aee4", 4.0},
     {Crack::opening_begun, "opening begun", "#fdc13c", 4.0},
     {Crack::slipped, "slipped", "#0d47a1", 5.0},
     {Crack::open, "open crack", "#ca1a1f", 5.0},
     {Crack::crushed, "crushed", "#330a40", 5.0}}};

// Colours of faces and edges of blocks, of joints inside a unit, of beams.
struct BlockColours {
  const char *face, *edge, *joint_in_unit, *beam, *beam_edge;
};
inline constexpr BlockColours kBlockColours{"#f1ece0", "#b5aa98", "#dccfb8", "#b9c0c8", "#808890"};

// Colours of quantities: zero, largest, most negative. Both scales grow darker, so that grey shows the magnitude.
struct QuantityColours {
  const char *middle, *warm, *cold;
};
inline constexpr QuantityColours kQuantityColours{"#e9e2d0", "#a50f15", "#2c4fa3"};

// Colours of curves in their order; they differ in lightness, too.
inline constexpr std::array kPens{"#b3321e", "#1d3557", "#5aa9e6", "#e8a33d", "#2a9d8f",
                                  "#8d6a9f", "#777777", "#b08968", "#000000"};

}  // namespace quoin
