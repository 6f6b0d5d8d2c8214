#pragma once

#include <cstddef>

#include "coulomb_slip/parameters.h"
#include "shim/columns.h"

namespace quoin::coulomb_slip {

// Order of the states in the metadata and in Columns.
enum StateColumn : int { kFailed, kSlip, kStateCount };
// Order of the per-point properties in Columns; friction angles in degrees.
enum PropertyColumn : int {
  kColumnKn,
  kColumnKs,
  kColumnFt,
  kColumnFtr,
  kColumnC0,
  kColumnCr,
  kColumnPhi0,
  kColumnPhir,
  kPropertyColumnCount
};

// Evaluates count points with the best instruction set of the processor; columns are padded to whole vectors.
void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary);
// Evaluates one point, only traction and states, in the caller's memory; bitwise identical to evaluate.
void evaluate_one(const Parameters& material, const shim::Columns& columns, shim::Summary& summary);

}  // namespace quoin::coulomb_slip
