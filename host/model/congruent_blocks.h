// Data that deformable blocks of one shape, zoning and material share, in the frame of their shape.
#pragma once

#include <vector>

#include "geometry/vector.h"
#include "model/stiffness.h"

namespace quoin::blocks {

struct CongruentBlocks {
  Stiffness stiffness;                   // K of the undeformed shape
  std::vector<geometry::Vector> place;   // X of gridpoints about the mass centre, m
  std::vector<geometry::Vector> anchor;  // b = m S^-1 X, S = sum m X X^T, 1/m, of corners: sum X b^T = 1, sum b = 0
};

// b of corners, from their positions and masses.
std::vector<geometry::Vector> anchors_of(std::span<const geometry::Vector> node, std::span<const double> mass);

// node, mass: positions and masses of gridpoints, m and kg, the corners first. zones: those of one block, with node
// indices from 0.
CongruentBlocks make_congruent_blocks(std::span<const geometry::Vector> node, std::span<const double> mass,
                                      size_t corner_count, std::span<const quoin::Zone> zones, double lambda,
                                      double shear_modulus);

}  // namespace quoin::blocks
