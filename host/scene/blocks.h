// Blocks of any convex shape with their materials and joint families: input of the general model. SI units (m, kg, s,
// Pa).
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/polyhedron.h"
#include "geometry/zoning.h"
#include "scene/scene.h"

namespace quoin::blocks {

using geometry::Matrix;
using geometry::Quaternion;
using geometry::Vector;

// A mass without extent, rigidly attached to a block, within it or not.
struct PointMass {
  Vector at;    // place at the start, m
  double mass;  // kg
};

struct Block {
  std::string name;
  std::string body{};      // name in controls of stages that blocks share on the lattice; empty: none
  int shape = 0;           // index into Assembly::shapes; many blocks may share one
  Vector position;         // place of the origin of the shape's coordinates, m
  Quaternion orientation;  // orientation of its axes
  int material = 0;        // index into Assembly::materials
  bool rigid = true;
  double zone_edge = 0.0;  // deformable: target edge length of the zones, m
  std::array<int, 3> divisions{0, 0,
                               0};  // deformable bricks: hexahedra of 5 zones along each axis, instead of zone_edge
  int parity = 0;                   // parity of divisions: hexahedron (i, j, k) has pattern (i + j + k + parity) % 2
  std::shared_ptr<const geometry::Zoning> zoning;  // deformable: zones of a mesh file, in place of own ones; null: none
  bool fixed = false;  // held in all six degrees of freedom (prescribe() may drive it later)
  bool freed = false;  // fixed, and some stage leaves components of it free
  bool is_support() const { return fixed && !freed; }
  int unit = -1, course = -1;  // place in the masonry, for pictures
  bool beam = false;           // a rigid beam or lintel, which is not masonry
  double spread_mass = 0.0;    // kg, additional to that of its volume, with the same distribution
  std::vector<PointMass> masses;
  std::optional<Vector> centre;  // rigid: centre of its mass without `masses`, m; none: that of its volume

  const std::string& name_in_stages() const { return body.empty() ? name : body; }
};

// A new contact of two blocks, on which the choice of its joint family may depend.
struct Meeting {
  int block_a, block_b;
  Vector normal;  // direction from a to b
};

struct ContactSettings {
  double skin = 0.0;  // m; largest gap of pairs that the broad phase keeps; 0: 5 % of the smallest block's least extent
  double joint_tolerance =
      0.0;  // m; parallel faces closer than this at the start are a joint; 0: 1e-4 of the least extent
  double point_spacing =
      0.0;  // m; contact points inside a joint of rigid blocks no further apart; 0: as the family has it
  // Relative motion of two neighbours up to which contact geometry is frozen, over the smaller one's least extent.
  // Beyond it, contacts are detected again whenever the pair has moved by as much again. 0: large displacement from the
  // start.
  double small_displacement = 0.005;
  // Relative motion at which a joint of the start is detected again, over the smaller block's least extent. Up to it,
  // its contact points move with their blocks. New points then inherit the state of their nearest predecessors. That
  // serves friction and blurs cracks. 0: as other contacts.
  double joint_motion = 0.0;
};

struct Assembly {
  std::vector<BlockMaterial> materials;
  std::vector<JointFamily> families;
  std::vector<geometry::ConvexPolyhedron> shapes;
  std::vector<Block> blocks;
  std::function<int(const Meeting&)> family_of;  // index into families; empty: family 0 for all
  ContactSettings contact;
  bool shared_names = false;       // several blocks of one name move and are loaded together
  std::vector<std::string> notes;  // notes of the reader: how shapes differ from those of mesh files
  bool symmetry_plane_z0 = false;  // what touches z = 0 at the start stays there: u_z = 0, no rotation out of it

  // Adds a block with its shape. Returns its index.
  int add(geometry::ConvexPolyhedron shape, Block block);
};

// Largest gap or overlap of joints of the start, and distance of corners from a plane within which they are one face,
// m.
double joint_tolerance_of(const Assembly& assembly);

// "#3 'lintel'", the name of a block in messages.
std::string label(const Assembly& assembly, int block);

}  // namespace quoin::blocks
