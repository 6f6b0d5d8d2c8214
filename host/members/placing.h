// Nodes of members on blocks, while members are made from a scene.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "members/node.h"
#include "scene/blocks.h"
#include "scene/members.h"

namespace quoin::members {

struct Placing {
  const blocks::Assembly& assembly;
  std::vector<Node>& nodes;

  // Adds a node of a block at a point, m. Returns its index.
  int add(int block, const Vector& at, bool turns = false);
  // The block of a member's end. Throws Error(bad_input) for an end in no block, with its place and the nearest block,
  // or where two blocks meet.
  int block_of(const MemberEnd& end) const;
  // The block at a point, or -1; off: distance of the nearest block, m.
  int block_at(const Vector& point, double* off) const;
  const geometry::ConvexPolyhedron& shape_of(int block) const;
  // Tolerance of the distance of a member's end from this block, m.
  double allowed_off(int block) const;
};

// Visits quadrature points of a triangle, exact for quadratics: visit(point, area in m2). They are the midpoints of the
// edges of divisions^2 congruent triangles.
void each_point(const std::array<Vector, 3>& triangle, int divisions,
                const std::function<void(const Vector&, double)>& visit);
// Visits the triangles of a face of a block: visit(triangle).
void each_triangle(const blocks::Assembly& assembly, int block, std::size_t face,
                   const std::function<void(const std::array<Vector, 3>&)>& visit);

}  // namespace quoin::members
