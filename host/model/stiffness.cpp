#include "model/stiffness.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "model/lanes.h"

namespace quoin {
namespace {

using NodeBlock = std::array<double, 9>;  // coupling of gridpoints i and j: rows of i, columns of j

std::vector<std::map<int, NodeBlock>> blocks_of(std::span<const Zone> zones, int node_count, double lambda, double mu) {
  std::vector<std::map<int, NodeBlock>> rows(static_cast<std::size_t>(node_count));
  for (const Zone& zone : zones) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        const Vec3& g = zone.shape_gradient[a];
        const Vec3& h = zone.shape_gradient[b];
        NodeBlock& block =
            rows[static_cast<std::size_t>(zone.node[a])].try_emplace(zone.node[b], NodeBlock{}).first->second;
        for (std::size_t c = 0; c < 3; ++c) {
          for (std::size_t d = 0; d < 3; ++d) {
            // K = V (lambda g h^T + mu h g^T + mu (g.h) I); g, h: gradients of the nodes a and b
            double k = lambda * g[c] * h[d] + mu * h[c] * g[d];
            if (c == d) k += mu * dot(g, h);
            block[3 * c + d] += zone.volume * k;
          }
        }
      }
    }
  }
  return rows;
}

}  // namespace

Stiffness assemble_stiffness(std::span<const Zone> zones, int node_count, double lambda, double shear_modulus) {
  const auto rows = blocks_of(zones, node_count, lambda, shear_modulus);
  Stiffness stiffness;
  double largest = 0.0;
  for (const auto& row : rows) {
    for (const auto& [j, block] : row) {
      for (double k : block) largest = std::max(largest, std::abs(k));
    }
  }
  for (const auto& row : rows) {
    for (const auto& [j, block] : row) {
      for (unsigned d = 0; d < 3; ++d) {
        const auto present = [&, &k = block](unsigned c) { return std::abs(k[3 * c + d]) > 1e-14 * largest; };
        if (!present(0) && !present(1) && !present(2)) continue;
        stiffness.column.push_back(j * kLine + static_cast<int>(d) * kLanes);
        for (unsigned c = 0; c < 3; ++c) stiffness.coefficient.push_back(present(c) ? block[3 * c + d] : 0.0);
      }
    }
    if (stiffness.column.size() % 2 != 0) {  // the kernel reads columns in pairs
      stiffness.column.push_back(0);
      stiffness.coefficient.insert(stiffness.coefficient.end(), 3, 0.0);
    }
    stiffness.column_end.push_back(static_cast<std::int32_t>(stiffness.column.size()));
  }
  return stiffness;
}

std::vector<std::pair<int, double>> Stiffness::row(int i) const {
  const auto node = static_cast<std::size_t>(i / 3);
  std::vector<std::pair<int, double>> result;
  for (auto entry = static_cast<std::size_t>(node == 0 ? 0 : column_end[node - 1]);
       entry < static_cast<std::size_t>(column_end[node]); ++entry) {
    const double k = coefficient[3 * entry + static_cast<std::size_t>(i % 3)];
    const int offset = column[entry];
    if (k != 0.0) result.emplace_back(offset / kLine * 3 + offset % kLine / kLanes, k);
  }
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace quoin
