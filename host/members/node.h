// A point of a block that members pull at.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/vector.h"

namespace quoin::members {

using geometry::Vector;

struct Node {
  int block = -1;
  Vector start;  // m
  // How it rides on its block: of a rigid one in the body frame, m; of a deformable one gridpoints and weights.
  Vector arm;
  std::vector<std::pair<std::int32_t, double>> share;
  bool turns = false;  // has `turn`
  // Of the step:
  Vector x;               // m
  geometry::Matrix turn;  // of the block since the start
  Vector force;           // on the block, N
};

}  // namespace quoin::members
