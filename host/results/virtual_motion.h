// Motions that are not of a run, for ParaView: shapes of modes, mechanisms.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/vector.h"

namespace quoin {

// A block's zones, or else its faces, at rest.
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

// Writes one grid with an array per motion: ParaView's filter Warp By Vector shows it. Throws Error(bad_input).
void write_motions(const std::filesystem::path& file, const std::vector<StillBlock>& blocks,
                   const std::vector<VirtualMotion>& motions);

}  // namespace quoin
