// The monitor: body or blocks whose displacement and force are in rows of the history. A stage finds them when it
// begins. `start`, and the blocks in large motion, are saved.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/assembly.h"

namespace quoin {

struct StageMonitor {
  struct Point {
    std::int32_t point;
    double sign;  // of the force on the monitor: 1: the monitor is side a; -1: side b
  };

  Vec3 start{};               // displacement at the beginning of the stage, m
  std::vector<int> blocks;    // that it is: rigid ones, or deformable ones
  std::vector<Point> points;  // contact points of its deformable blocks on the lattice, in ascending order
  bool stands_below = false;  // whether blocks lie below their neighbours at the beginning of the stage
};

}  // namespace quoin
