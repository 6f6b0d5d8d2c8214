// Motions that no run has made, for ParaView: shapes of modes, mechanisms.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/vector.h"

namespace quoin {

// Where a block is drawn: its zones, or else its faces.
struct StillBlock {
  std::vector<geometry::Vector> point;  // m
  std::vector<std::array<int, 4>> zone;
  std::vector<std::vector<int>> face;
};

// An array of the file: displacement by block and point.
struct VirtualMotion {
  std::string name;
  std::vector<std::vector<geometry::Vector>> displacement;
};

// One grid with an array a motion: ParaView's filter Warp By Vector moves it. Throws Error(bad_input).
void write_motions(const std::filesystem::path& file, const std::vector<StillBlock>& blocks,
                   const std::vector<VirtualMotion>& motions);

}  // namespace quoin
