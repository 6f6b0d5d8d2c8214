#include "model/block_zones.h"

#include <algorithm>

namespace quoin::blocks {

using namespace geometry;

double Zone::energy(const Matrix& strain) const {
  double squares = 0.0;
  for (const Vector& row : strain.row) squares += dot(row, row);
  return volume * (0.5 * lambda * trace(strain) * trace(strain) + mu * squares);
}

Zone ZoneLanes::zone(int lane) const {
  Zone zone;
  for (int k = 0; k < 4; ++k) zone.node[k] = node[k][lane];
  for (int k = 0; k < 3; ++k) zone.gradient[k + 1] = {gradient[k][0][lane], gradient[k][1][lane], gradient[k][2][lane]};
  zone.gradient[0] = -(zone.gradient[1] + zone.gradient[2] + zone.gradient[3]);
  zone.volume = volume[lane], zone.lambda = lambda[lane], zone.mu = 0.5 * twice_mu[lane];
  return zone;
}

void lay_out(const Zoning& zoning, const Matrix& turned, const BlockMaterial& material, std::span<ZoneLanes> lanes) {
  const double e = material.young_modulus, nu = material.poisson_ratio;
  for (size_t k = 0; k < lanes.size() * ZoneLanes::kCount; ++k) {
    ZoneLanes& to = lanes[k / ZoneLanes::kCount];
    const size_t lane = k % ZoneLanes::kCount;
    const bool is_one = k < zoning.zones.size();
    to.count += is_one;
    const auto& corners = zoning.zones[is_one ? k : k - lane];
    // Edges come from the shape, not from positions in space: zones of congruent blocks have the same bits.
    Vector edge[3];
    for (size_t c = 0; c < 3; ++c)
      edge[c] = turned * (zoning.nodes[size_t(corners[c + 1])] - zoning.nodes[size_t(corners[0])]);
    const double six = dot(edge[0], cross(edge[1], edge[2]));
    for (size_t c = 0; c < 3; ++c) {
      const Vector gradient = cross(edge[(c + 1) % 3], edge[(c + 2) % 3]) / six;
      for (size_t axis = 0; axis < 3; ++axis) to.gradient[c][axis][lane] = gradient[int(axis)];
    }
    for (size_t c = 0; c < 4; ++c) to.node[c][lane] = corners[c];
    to.volume[lane] = is_one ? six / 6 : 0.0;
    to.lambda[lane] = e * nu / ((1 + nu) * (1 - 2 * nu));
    to.twice_mu[lane] = 2 * (e / (2 * (1 + nu)));
  }
}

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
