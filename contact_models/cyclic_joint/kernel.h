#pragma once

#include <cstddef>

#include "cyclic_joint/parameters.h"
#include "shim/columns.h"

namespace quoin::cyclic_joint {

// Order of the states in the metadata and in Columns.
enum StateColumn : int { kXi, kKappa, kQ, kL, kW, kGs, kGt, kRm, kVm, kSlip, kStateCount };
// Order of the per-point properties in Columns; angles in degrees.
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
  kColumnBeta,
  kColumnSd,
  kColumnPd,
  kColumnFy,
  kColumnWp,
  kColumnChi,
  kColumnCs,
  kPropertyColumnCount
};

struct Material;
using Kernel = void (*)(const Material&, const shim::Columns&, std::size_t count, shim::Summary&);

// A material and its kernels for the best instruction set of the processor.
struct Material {
  Parameters parameters;
  Kernel lean = nullptr;  // tractions and states only
  Kernel one = nullptr;   // tractions and states of a batch of one point
  Kernel full = nullptr;  // all outputs, and per-point properties
  // Storage of Lanes (equations.h), whose size depends on the instruction set. Filled in once.
  static constexpr std::size_t kLaneVectors = 48;
  alignas(sizeof(double) * shim::kMaxLanes) std::byte lanes[kLaneVectors * sizeof(double) * shim::kMaxLanes];
};

// Fills in all members but the parameters.
void choose_kernels(Material& material);

}  // namespace quoin::cyclic_joint
