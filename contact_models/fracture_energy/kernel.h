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

struct Material;
using Kernel = void (*)(const Material&, const shim::Columns&, std::size_t count, shim::Summary&);

// A material as the kernels of the best instruction set of this machine read it.
struct Material {
  Parameters parameters;
  // The kernels that it needs, with the branches that its parameters switch off left out.
  Kernel lean = nullptr;  // tractions and states only
  Kernel one = nullptr;   // the same for a call of one point
  Kernel full = nullptr;  // every branch, whatever outputs are requested
  // Lanes of equations.h, whose size depends on the instruction set: made once, read by every call.
  static constexpr std::size_t kLaneVectors = 30;
  alignas(sizeof(double) * shim::kMaxLanes) std::byte lanes[kLaneVectors * sizeof(double) * shim::kMaxLanes];
};

// Fills in all but the parameters.
void choose_kernels(Material& material);

}  // namespace quoin::fracture_energy
