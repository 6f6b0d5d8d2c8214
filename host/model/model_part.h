// What one of several processes has of a model that they share.
#pragma once

#include <functional>
#include <vector>

#include "base/ranks.h"
#include "geometry/vector.h"
#include "model/halo.h"

namespace quoin::blocks {

using geometry::Vector;

// One process alone has everything, and no ranks.
struct ModelPart {
  Ranks* ranks = nullptr;
  std::vector<int> rank_of_block;   // with ranks
  std::vector<bool> laid_out;       // by block
  std::vector<Vector> rough_place;  // by block, known to all, m
  Halo neighbours;                  // motion of whole blocks that are close to those of other ranks
  std::vector<double> deviating;    // by block, as received from neighbours: 1 or 0
  // Called before contacts are detected or blocks go with others: where other processes have advanced some of them,
  // what they know is to be fetched.
  std::function<void()> fetch = [] {};

  bool owns(int block) const { return !ranks || rank_of_block[size_t(block)] == ranks->rank(); }
};

}  // namespace quoin::blocks
