#include "model/placed_blocks.h"

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

Placed placed(const World& w, int block) {
  const ModelBlock& b = w.blocks[block];
  const Vector* v = w.shapes.placed_corner.data() + b.first_corner;
  Vector centre;
  const size_t n = b.shape->vertices.size();
  for (size_t i = 0; i < n; ++i) centre += v[i];
  return {b.shape, v, w.shapes.placed_normal.data() + b.first_normal, centre / double(n), b.body < 0};
}

namespace {

constexpr size_t kBlocksAPart = 64;  // of the work of one thread at a time

void place_block(World& w, size_t i) {
  const ModelBlock& b = w.blocks[i];
  Vector* corner = w.shapes.placed_corner.data() + b.first_corner;
  Vector* normal = w.shapes.placed_normal.data() + b.first_normal;
  const size_t corners = b.shape->vertices.size(), faces = b.shape->faces.size();
  if (b.body >= 0) {
    const Body& body = w.bodies[b.body];
    for (size_t k = 0; k < corners; ++k) corner[k] = body.x + body.r * w.shapes.corner[b.first_corner + k];
    for (size_t f = 0; f < faces; ++f) normal[f] = body.r * w.shapes.normal[b.first_normal + f];
    return;
  }
  for (size_t k = 0; k < corners; ++k) corner[k] = w.nodes.x[size_t(b.first_node) + k];
  for (size_t f = 0; f < faces; ++f) {
    const auto& face = b.shape->faces[f];
    Vector m;
    for (size_t k = 1; k + 1 < face.size(); ++k) {
      m += cross(corner[face[k]] - corner[face[0]], corner[face[k + 1]] - corner[face[0]]);
    }
    normal[f] = normalized(m);
  }
}

}  // namespace

void place_blocks(World& w) {
  each_part(w.pool, w.blocks.size(), kBlocksAPart, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (w.part.laid_out[i]) place_block(w, i);
    }
  });
}

}  // namespace quoin::blocks
