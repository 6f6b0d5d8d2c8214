#pragma once

#include <cstddef>

#include "coulomb_slip/parameters.h"
#include "shim/columns.h"

namespace quoin::coulomb_slip {

// Order of the states in the metadata and in Columns.
enum StateColumn : int { kFailed, kSlip, kStateCount };
// Order of the per-point properties in Columns; friction in degrees, as users give it.
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

// On the best instruction set of this machine. count points; columns are padded to whole vectors.
void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary);
// The same bits for one point, in the caller's own memory; nothing but traction and states.
void evaluate_one(const Parameters& material, const shim::Columns& columns, shim::Summary& summary);

}  // namespace quoin::coulomb_slip
