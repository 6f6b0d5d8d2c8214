#pragma once

#include <cstddef>

#include "fracture_energy/parameters.h"
#include "shim/columns.h"

namespace quoin::fracture_energy {

// Order of the states in the metadata and in Columns.
enum StateColumn : int { kXiT, kXiS, kW, kV, kSlip, kStateCount };
// Order of the per-point properties in Columns; friction and dilation in degrees, as users give them.
enum PropertyColumn : int {
  kColumnKn,
  kColumnKs,
  kColumnFt,
  kColumnC0,
  kColumnCr,
  kColumnPhi0,
  kColumnPhir,
  kColumnPsi0,
  kColumnFc,
  kColumnFcr,
  kColumnG1,
  kColumnG2,
  kColumnGc,
  kPropertyColumnCount
};

using Kernel = void (*)(const Parameters&, const shim::Columns&, std::size_t count, shim::Summary&);

// The kernels that a material needs, with the branches that its parameters switch off left out.
struct Kernels {
  Kernel lean;     // tractions and states only
  Kernel full;     // whatever outputs are asked for
  Kernel columns;  // per-point properties: every branch, whatever outputs are asked for
};

// For the best instruction set of this machine.
Kernels select_kernels(const Parameters& material);

}  // namespace quoin::fracture_energy
