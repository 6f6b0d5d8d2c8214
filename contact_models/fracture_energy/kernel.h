#pragma once

#include <cstddef>

#include "fracture_energy/parameters.h"
#include "shim/columns.h"

namespace quoin::fracture_energy {

// Order of the states in the metadata and in Columns.
enum StateColumn : int { kXiT, kXiS, kW, kV, kSlip, kStateCount };
// Order of the per-point properties in Columns; friction and dilation angles in degrees.
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

// A material and its kernels for the best instruction set of the processor.
struct Material {
  Parameters parameters;
  // lean and one omit the branches that the parameters switch off.
  Kernel lean = nullptr;  // tractions and states only
  Kernel one = nullptr;   // tractions and states of a batch of one point
  Kernel full = nullptr;  // all outputs; every branch
  // Storage of Lanes (equations.h), whose size depends on the instruction set. Filled in once.
  static constexpr std::size_t kLaneVectors = 30;
  alignas(sizeof(double) * shim::kMaxLanes) std::byte lanes[kLaneVectors * sizeof(double) * shim::kMaxLanes];
};

// Fills in all members but the parameters.
void choose_kernels(Material& material);

}  // namespace quoin::fracture_energy
