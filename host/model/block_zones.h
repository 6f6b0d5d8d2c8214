// Zones of deformable blocks: tetrahedra of constant strain.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vector.h"
#include "model/lanes.h"
#include "model/model_block.h"
#include "model/stiffness.h"
#include "scene/blocks.h"

namespace quoin::blocks {

using geometry::Matrix;
using geometry::Vector;

struct Zone {
  int32_t node[4];     // gridpoints, numbered within the block
  Vector gradient[4];  // gradients of the shape functions in the reference configuration, 1/m
  double volume;       // reference, m3
  double lambda, mu;   // Pa

  double energy(const Matrix& strain) const;  // stored under a uniform strain, symmetric, J
};

// Zones of a block in lanes, in the layout of the kernel. Lanes from `count` on have no volume, and the node numbers of
// the first zone.
struct ZoneLanes {
  static constexpr int kCount = 8;
  alignas(64) double gradient[3][3][kCount];                // gradients of the shape functions of corners 1 to 3, 1/m
  double volume[kCount], lambda[kCount], twice_mu[kCount];  // m3, Pa
  int32_t node[4][kCount];                                  // gridpoints, numbered within the block
  int count;
  Zone zone(int lane) const;
};

// Data that deformable blocks of one shape, zoning and material share, in the frame of their shape.
struct CongruentBlocks {
  Stiffness stiffness;         // K of the undeformed shape
  std::vector<Vector> place;   // X of gridpoints about the mass centre, m
  std::vector<Vector> anchor;  // b = m S^-1 X, S = sum m X X^T, 1/m, of corners: sum X b^T = 1, sum b = 0
};

// b of corners, from their positions and masses.
std::vector<Vector> anchors_of(std::span<const Vector> node, std::span<const double> mass);

// node, mass: positions and masses of gridpoints, m and kg, the corners first. zones: those of one block, with node
// indices from 0.
CongruentBlocks make_congruent_blocks(std::span<const Vector> node, std::span<const double> mass, size_t corner_count,
                                      std::span<const quoin::Zone> zones, double lambda, double shear_modulus);

// Zones of all blocks in their orientation at the start. Blocks of one shape, material, zoning and orientation share
// their zones.
struct Zones {
  LaneVector<ZoneLanes> lanes;             // stored with the first block that has them
  std::vector<CongruentBlocks> congruent;  // data that blocks of one shape share in any orientation

  std::span<const ZoneLanes> lanes_of(const ModelBlock& b) const {
    return std::span(lanes).subspan(size_t(b.first_lanes), size_t(b.lanes_count));
  }
  Zone zone(const ModelBlock& b, int index) const {
    return lanes[size_t(b.first_lanes + index / ZoneLanes::kCount)].zone(index % ZoneLanes::kCount);
  }
};

// Zones of a block in the orientation that `turned` gives to its shape. lanes: as many as the zones need, empty.
void lay_out(const geometry::Zoning& zoning, const Matrix& turned, const BlockMaterial& material,
             std::span<ZoneLanes> lanes);

}  // namespace quoin::blocks
