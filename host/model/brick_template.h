// Data that blocks of one size, zoning, pattern and material share: zones, masses and the assembled stiffness.
#pragma once

#include <array>
#include <vector>

#include "model/stiffness.h"
#include "scene/assembly.h"

namespace quoin {

// One outer triangle of a brick, for the areas of its contact points.
struct FaceTriangle {
  int face;  // -x, +x, -y, +y, -z, +z
  std::array<int, 3> node;
};

struct BrickTemplate {
  Vec3 size{};
  std::array<int, 3> zones{};
  int parity = 0;
  int material = 0;

  int node_count = 0;
  std::vector<Vec3> node;  // reference position from the lowest corner, m; x fastest, then y, then z
  std::vector<Zone> zone;
  std::vector<FaceTriangle> face_triangle;
  double lambda = 0.0, shear_modulus = 0.0;  // Lame constants, Pa
  std::vector<double> node_mass;             // kg, a quarter of each zone, without any scaling

  Stiffness stiffness;

  int node_index(int i, int j, int k) const { return i + (zones[0] + 1) * (j + (zones[1] + 1) * k); }
};

// Zones, masses and stiffness of a brick; not for inner loops.
BrickTemplate make_brick_template(const Brick& brick, const BlockMaterial& material);

// Stress of a zone from the displacements of its corners: xx, yy, zz, xy, yz, zx; Pa, tension positive.
std::array<double, 6> zone_stress(const Zone& zone, const std::array<Vec3, 4>& displacement, double lambda, double mu);

}  // namespace quoin
