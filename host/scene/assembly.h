// An assembly: blocks and the joints between them, as generators make them, before their discretisation (host/model).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

// Axis-aligned brick, divided into zones[0] x zones[1] x zones[2] hexahedra of 5 constant-strain tetrahedra each.
// Rigid bricks are not zoned; their gridpoints exist only where contact points need them.
struct Brick {
  Vec3 origin;  // lowest corner, m
  Vec3 size;    // m
  std::array<int, 3> zones{1, 1, 1};
  int parity = 0;    // hexahedron (i, j, k) has 5-tetrahedron pattern (i + j + k + parity) % 2
  int material = 0;  // index into Assembly::materials
  bool rigid = false;
  bool beam = false;                    // a rigid beam or lintel, which is not masonry
  std::optional<double> load_height{};  // rigid: y of its centre of mass, where loads act too; none: the middle, m
  bool fixed = false;                   // a support that follows the ground: from a fixed block, or the base of a wall
  bool freed = false;                   // fixed, and some stage leaves components of it free
  bool is_support() const { return fixed && !freed; }
  std::string body;    // name for BodyControl, histories and supports, shared by a row; empty for ordinary blocks. A
                       // deformable brick of this name can be loaded and monitored, but not held
  std::string name{};  // name of the block in the scene, for messages; empty: none
  int unit = -1;       // masonry unit this block belongs to (pictures), -1: none
  int course = -1;
};

// Faces of bricks in order -x, +x, -y, +y, -z, +z.
// A conforming joint: face `face_a` of block a lies on the opposite face of block b. If one side is a rigid brick, the
// joint takes the gridpoints of the deformable side. The faces may overlap only partly (a whole unit lies on two): the
// joint is their overlap. Its contact points are the gridpoints that coincide, matched by coordinates. Their areas come
// from the face triangles inside the overlap alone. The normal points from a to b.
struct Joint {
  int block_a, block_b;
  int face_a;  // face of block_a
  int family;  // index into Assembly::families
};

inline constexpr int kNoFamily = -1;  // family of pairs without contact, which pass through each other

struct Assembly {
  std::vector<BlockMaterial> materials;
  std::vector<JointFamily> families;
  std::vector<Brick> bricks;
  std::vector<Joint> joints;
  std::vector<std::array<int, 2>> apart{};  // pairs that touch without a joint: mortar is missing, or a beam is cut
  double symmetry_factor = 1.0;    // 2 when only half of the thickness is modelled: forces are multiplied by it
  bool symmetry_plane_z0 = false;  // u_z = 0 for gridpoints at z = 0
};

}  // namespace quoin
