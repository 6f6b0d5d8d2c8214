// Stiffness of the zones of a block, assembled once for all congruent blocks, in the layout of the SIMD kernels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "scene/assembly.h"

namespace quoin {

// Constant-strain tetrahedron of a template.
struct Zone {
  std::array<int, 4> node;             // positive orientation
  double volume;                       // m3
  std::array<Vec3, 4> shape_gradient;  // grad N of each corner, 1/m
};

// K, with the three rows of a gridpoint together. Gridpoint i has the columns [column_end[i - 1], column_end[i]), an
// even number, each with its coefficients in the rows x, y, z. Coefficients that cancel are kept as zeros. Loops of
// irregular length would cost more in mispredicted branches than these multiply-adds.
struct Stiffness {
  std::vector<std::int32_t> column;      // offset in doubles from the first line of the group: 24 j + 8 d (lanes.h)
  std::vector<std::int32_t> column_end;  // by gridpoint
  std::vector<double> coefficient;       // N/m, three a column

  // Row i (3 node + component) as (column, value) pairs, columns ascending; for the time step and for tests.
  std::vector<std::pair<int, double>> row(int i) const;
};

// lambda, shear_modulus: Lame constants, Pa.
Stiffness assemble_stiffness(std::span<const Zone> zones, int node_count, double lambda, double shear_modulus);

}  // namespace quoin
