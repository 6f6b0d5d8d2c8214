#include "model/alike_blocks.h"

namespace quoin::blocks {

using namespace geometry;

AlikeBlocks make_alike_blocks(std::span<const Vector> node, std::span<const double> mass,
                              std::span<const quoin::Zone> zones, double lambda, double shear_modulus) {
  AlikeBlocks alike;
  alike.stiffness = assemble_stiffness(zones, static_cast<int>(node.size()), lambda, shear_modulus);
  Vector centre;
  double sum = 0.0;
  for (std::size_t i = 0; i < node.size(); ++i) centre += mass[i] * node[i], sum += mass[i];
  centre = centre / sum;
  Matrix second = Matrix::zero();
  for (std::size_t i = 0; i < node.size(); ++i) {
    alike.place.push_back(node[i] - centre);
    second += outer(mass[i] * alike.place[i], alike.place[i]);
  }
  const Matrix inverse_second = inverse(second);
  for (std::size_t i = 0; i < node.size(); ++i) alike.anchor.push_back(mass[i] * (inverse_second * alike.place[i]));
  return alike;
}

}  // namespace quoin::blocks
