// Sides of contact points, listed by the block on which they act.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "model/chunks.h"

namespace quoin::blocks {

struct World;

// One side of a point of Chunk::others.
struct Touch {
  const OtherPoint* point;
  int32_t family;
  bool side_a;
};

// Sides of a point of two deformable blocks. An owner has the plane, a carrier has the point on a triangle. The third
// kind has the point on a gridpoint.
struct OwnerTouch {
  uint32_t row;
  int32_t node[3];
};

struct CarrierTouch {
  uint32_t row;
  int32_t node[3];
  double weight[3];
};

struct GridpointTouch {
  uint32_t row;
  int32_t node;
};

// Sides of points, block after block.
template <class Touch>
struct ByBlock {
  std::vector<Touch> touch;
  std::vector<uint32_t> end;  // by block
  std::span<const Touch> of(int block) const {
    const uint32_t first = block > 0 ? end[size_t(block) - 1] : 0;
    return std::span(touch).subspan(first, end[size_t(block)] - first);
  }
};

// Lists sides by block: counts them first, then fills them in. for_each(visit) calls visit(block, side) for each side,
// in the same order both times.
template <class Side, class ForEach>
void list_by_block(size_t blocks, ByBlock<Side>& sides, const ForEach& for_each) {
  std::vector<uint32_t>& end = sides.end;
  end.assign(blocks, 0);
  for_each([&](int block, const Side&) { ++end[size_t(block)]; });
  uint32_t sum = 0;
  for (uint32_t& of_block : end) of_block = std::exchange(sum, sum + of_block);  // its first side
  sides.touch.resize(sum);
  for_each([&](int block, const Side& side) { sides.touch[end[size_t(block)]++] = side; });
}

// Row of a pair on gridpoints: of the moment on the frame of its block a, or of the force on its rigid block b. The row
// of the moment on b follows.
using RowTouch = uint32_t;

// One side of a pair of rigid blocks.
struct PairTouch {
  const RigidPair* pair;
  bool side_a;
};

// Sides are listed with the chunks; those of a block are in the order of families and points.
struct Sides {
  std::vector<double> cost;   // by block: number of its pairs of rigid blocks and of its other contact points
  ByBlock<Touch> single;      // points of Chunk::others
  ByBlock<PairTouch> pair;    // pairs of rigid blocks
  ByBlock<OwnerTouch> owner;  // points between gridpoints
  ByBlock<CarrierTouch> carrier;
  ByBlock<GridpointTouch> gridpoint;        // gridpoints of block b
  ByBlock<GridpointTouch> owner_gridpoint;  // gridpoints of block a, for points on gridpoints of both
  ByBlock<RowTouch> moment, wrench;
};

void count_sides(World& w);
void divide_sides(World& w);

}  // namespace quoin::blocks
