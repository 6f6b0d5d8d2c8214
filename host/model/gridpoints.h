// Gridpoints of deformable blocks.
#pragma once

#include <cstdint>
#include <span>

#include "geometry/vector.h"
#include "model/lanes.h"
#include "model/model_block.h"

namespace quoin::blocks {

using geometry::Vector;

// Gridpoints of one block.
struct BlockGridpoints {
  std::span<const Vector> x, v;  // m, m/s
  std::span<const double> mass;  // kg
  std::span<const uint8_t> held;
};

// Gridpoints of all blocks, block after block. Steps change x and v, stages change supports; the rest is constant.
struct Gridpoints {
  LaneVector<Vector> x, reference, v;    // position, position at the start, m; velocity at half steps, m/s
  LaneVector<double> mass, weight_mass;  // mass for inertia (mass scaling included) and for weight, kg
  LaneVector<uint8_t> held, support;     // held axes, bits 0..2; those of `held` that a symmetry plane holds for good
  LaneVector<Vector> held_v;             // prescribed velocity, m/s
  LaneVector<Vector> anchor;             // b of blocks in frames that do not share it, 1/m; empty: there are none

  BlockGridpoints of(const ModelBlock& b) const {
    const auto part = [&](const auto& field) {
      return std::span(field).subspan(size_t(b.first_node), size_t(b.node_count));
    };
    return {part(x), part(v), part(mass), part(held)};
  }
};

}  // namespace quoin::blocks
