// The body or blocks whose displacement and force a row of the history shows. A stage finds them when it begins; start,
// and the blocks in large motion, are saved.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/assembly.h"

namespace quoin {

struct StageMonitor {
  struct Point {
    std::int32_t point;
    double sign;  // 1: side a
  };

  Vec3 start{};               // displacement when the stage began, m
  std::vector<int> bodies;    // bodies on the lattice
  std::vector<int> loaded;    // deformable blocks on the lattice, indices into Controls::loaded_blocks
  std::vector<Point> points;  // points of these blocks, in order
  std::vector<int> blocks;    // blocks in large motion
  bool stands_below = false;  // whether these blocks lie below what they touch, at the start of the stage
};

}  // namespace quoin
