// A block as in its file, before any check.
#pragma once

#include <string>
#include <vector>

#include "geometry/vector.h"

namespace quoin::geometry {

struct RawShape {
  std::string name;
  std::vector<Vector> vertices;
  std::vector<std::vector<int>> faces;  // counter-clockwise seen from outside
  bool support = false;
  std::string number{};  // number in the file, for blocks that share a name; empty: its place in the file
};

}  // namespace quoin::geometry
