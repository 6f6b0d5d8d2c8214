#include "sparse/stiffness_entries.h"

#include <Eigen/Eigenvalues>
#include <cstddef>

namespace quoin {

using geometry::Vector;

void add_spring(const std::vector<UnknownShare>& shares, const Vector& n, double normal, double across,
                StiffnessEntries* entries) {
  for (const UnknownShare& row : shares) {
    const Vector force = across * row.moves + (normal - across) * dot(n, row.moves) * n;
    for (const UnknownShare& column : shares) {
      if (column.unknown <= row.unknown) entries->emplace_back(row.unknown, column.unknown, dot(force, column.moves));
    }
  }
}

// With gradients g, nodes i and j have the stiffness V (lambda g_i g_j^T + mu g_j g_i^T + mu (g_i . g_j) I).
void add_zone(double volume, double lambda, double mu, std::span<const Vector, 4> gradient,
              const std::array<std::array<int, 3>, 4>& unknown, StiffnessEntries* entries) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      const Vector &gi = gradient[i], &gj = gradient[j];
      const double along = mu * dot(gi, gj);
      for (int c = 0; c < 3; ++c) {
        const int row = unknown[i][static_cast<std::size_t>(c)];
        for (int d = 0; row >= 0 && d < 3; ++d) {
          const int column = unknown[j][static_cast<std::size_t>(d)];
          if (column < 0 || column > row) continue;
          const double k = lambda * gi[c] * gj[d] + mu * gj[c] * gi[d] + (c == d ? along : 0.0);
          entries->emplace_back(row, column, volume * k);
        }
      }
    }
  }
}

std::vector<FreeRotation> free_rotations(const std::vector<int>& free_axes, const geometry::Matrix& inertia) {
  const auto count = static_cast<Eigen::Index>(free_axes.size());
  if (count == 0) return {};
  const auto axis = [&](Eigen::Index i) { return free_axes[static_cast<std::size_t>(i)]; };
  Eigen::MatrixXd of_free(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) of_free(i, j) = inertia.row[axis(i)][axis(j)];
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(of_free);
  std::vector<FreeRotation> rotations;
  for (Eigen::Index k = 0; k < count; ++k) {
    rotations.push_back({{}, eigen.eigenvalues()(k)});
    for (Eigen::Index i = 0; i < count; ++i) rotations.back().spin[axis(i)] = eigen.eigenvectors()(i, k);
  }
  return rotations;
}

}  // namespace quoin
