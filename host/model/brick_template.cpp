#include "model/brick_template.h"

#include <algorithm>

namespace quoin {
namespace {

// The corners of a hexahedron are numbered by bits x + 2 y + 4 z. Pattern 0 has the corners with an even number of bits
// in the middle tetrahedron, pattern 1 the others. The remaining four corners are cut off, one tetrahedron each.
// Neighbouring hexahedra have different patterns, so that the diagonals of a shared face agree.
constexpr int kEvenCorner[4] = {0, 3, 5, 6};
constexpr int kOddCorner[4] = {1, 2, 4, 7};

Zone make_zone(std::array<int, 4> node, const std::vector<Vec3>& position) {
  const auto at = [&](int i) { return position[static_cast<std::size_t>(node[static_cast<std::size_t>(i)])]; };
  if (dot(cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)) < 0.0) std::swap(node[2], node[3]);
  Zone zone;
  zone.node = node;
  zone.volume = dot(cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)) / 6.0;
  // The gradient of a shape function is the inward area vector of the opposite face over three times the volume.
  for (int i = 0; i < 4; ++i) {
    const Vec3 p = at((i + 1) % 4), q = at((i + 2) % 4), r = at((i + 3) % 4);
    const Vec3 normal = cross(q - p, r - p);
    zone.shape_gradient[static_cast<std::size_t>(i)] = normal / dot(normal, at(i) - p);  // the product is +- 6 V
  }
  return zone;
}

}  // namespace

BrickTemplate make_brick_template(const Brick& source, const BlockMaterial& material) {
  BrickTemplate brick;
  brick.size = source.size;
  brick.zones = source.zones;
  brick.parity = source.parity;
  brick.material = source.material;

  const int nx = source.zones[0], ny = source.zones[1], nz = source.zones[2];
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i)
        brick.node.push_back({i * source.size[0] / nx, j * source.size[1] / ny, k * source.size[2] / nz});
    }
  }
  brick.node_count = static_cast<int>(brick.node.size());

  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        const bool odd = (i + j + k + source.parity) % 2 != 0;
        const int* middle = odd ? kOddCorner : kEvenCorner;
        const int* cut = odd ? kEvenCorner : kOddCorner;
        const auto corner = [&](int bits) {
          return brick.node_index(i + (bits & 1), j + (bits >> 1 & 1), k + (bits >> 2));
        };
        brick.zone.push_back(
            make_zone({corner(middle[0]), corner(middle[1]), corner(middle[2]), corner(middle[3])}, brick.node));
        for (int c = 0; c < 4; ++c) {
          const int tip = cut[c];
          brick.zone.push_back(make_zone({corner(tip), corner(tip ^ 1), corner(tip ^ 2), corner(tip ^ 4)}, brick.node));
        }
      }
    }
  }

  brick.node_mass.assign(brick.node.size(), 0.0);
  for (const Zone& zone : brick.zone) {
    for (int n : zone.node) brick.node_mass[static_cast<std::size_t>(n)] += 0.25 * material.density * zone.volume;
  }

  for (const Zone& zone : brick.zone) {
    for (std::size_t skip = 0; skip < 4; ++skip) {
      const std::array<int, 3> triangle{zone.node[(skip + 1) % 4], zone.node[(skip + 2) % 4],
                                        zone.node[(skip + 3) % 4]};
      for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, layer = face % 2 == 0 ? 0 : source.zones[static_cast<std::size_t>(axis)];
        const auto on_face = [&](int n) {
          const int index[3] = {n % (nx + 1), n / (nx + 1) % (ny + 1), n / ((nx + 1) * (ny + 1))};
          return index[axis] == layer;
        };
        if (std::all_of(triangle.begin(), triangle.end(), on_face)) brick.face_triangle.push_back({face, triangle});
      }
    }
  }

  const double e = material.young_modulus, nu = material.poisson_ratio;
  brick.lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  brick.shear_modulus = e / (2.0 * (1.0 + nu));
  brick.stiffness = assemble_stiffness(brick.zone, brick.node_count, brick.lambda, brick.shear_modulus);
  return brick;
}

std::array<double, 6> zone_stress(const Zone& zone, const std::array<Vec3, 4>& u, double lambda, double mu) {
  double gradient[3][3] = {};  // d u_c / d x_d
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t d = 0; d < 3; ++d) gradient[c][d] += u[a][c] * zone.shape_gradient[a][d];
    }
  }
  const double trace = gradient[0][0] + gradient[1][1] + gradient[2][2];
  return {lambda * trace + 2.0 * mu * gradient[0][0], lambda * trace + 2.0 * mu * gradient[1][1],
          lambda * trace + 2.0 * mu * gradient[2][2], mu * (gradient[0][1] + gradient[1][0]),
          mu * (gradient[1][2] + gradient[2][1]),     mu * (gradient[2][0] + gradient[0][2])};
}

}  // namespace quoin
