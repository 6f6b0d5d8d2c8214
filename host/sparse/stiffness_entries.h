// Entries of the lower triangle of stiffness matrices of masonry.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <span>
#include <vector>

#include "geometry/vector.h"

namespace quoin {

using StiffnessEntries = std::vector<Eigen::Triplet<double>>;

// An unknown of a contact point, and the point's relative motion, side b less side a, by a unit of it.
struct UnknownShare {
  int unknown;
  geometry::Vector moves;
};

// Adds a spring. normal: stiffness along n; across: stiffness perpendicular to it, N/m.
void add_spring(const std::vector<UnknownShare>& shares, const geometry::Vector& n, double normal, double across,
                StiffnessEntries* entries);

// Adds a zone of linear elasticity at constant strain. Given: m3, Pa, Pa; by node the gradient of its shape function,
// 1/m, and its unknowns, -1: held.
void add_zone(double volume, double lambda, double mu, std::span<const geometry::Vector, 4> gradient,
              const std::array<std::array<int, 3>, 4>& unknown, StiffnessEntries* entries);

// Rotations of a rigid body about those global axes that are free. They are about the principal axes of their inertia,
// so the mass matrix is diagonal.
struct FreeRotation {
  geometry::Vector spin;
  double inertia;  // kg m2
};
std::vector<FreeRotation> free_rotations(const std::vector<int>& free_axes, const geometry::Matrix& inertia);

}  // namespace quoin
