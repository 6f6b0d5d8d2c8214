#include "model/congruent_blocks.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Positions from the mass centre, m.
std::vector<Vector> places_of(std::span<const Vector> node, std::span<const double> mass) {
  Vector centre;
  double sum = 0.0;
  for (size_t i = 0; i < node.size(); ++i) centre += mass[i] * node[i], sum += mass[i];
  centre = centre / sum;
  std::vector<Vector> place;
  for (const Vector& x : node) place.push_back(x - centre);
  return place;
}

}  // namespace

std::vector<Vector> anchors_of(std::span<const Vector> node, std::span<const double> mass) {
  std::vector<Vector> anchor = places_of(node, mass);
  Matrix second = Matrix::zero();
  for (size_t i = 0; i < node.size(); ++i) second += outer(mass[i] * anchor[i], anchor[i]);
  const Matrix inverse_second = inverse(second);
  for (size_t i = 0; i < node.size(); ++i) anchor[i] = mass[i] * (inverse_second * anchor[i]);
  return anchor;
}

CongruentBlocks make_congruent_blocks(std::span<const Vector> node, std::span<const double> mass, size_t corner_count,
                                      std::span<const quoin::Zone> zones, double lambda, double shear_modulus) {
  return {assemble_stiffness(zones, static_cast<int>(node.size()), lambda, shear_modulus), places_of(node, mass),
          anchors_of(node.first(corner_count), mass.first(corner_count))};
}

}  // namespace quoin::blocks
