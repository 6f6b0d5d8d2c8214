#pragma once

#include <cstddef>

#include "bond_slip/parameters.h"
#include "shim/columns.h"

namespace quoin::bond_slip {

// Order of the states in the metadata and in Columns.
enum StateColumn : int { kSlipS, kSlipT, kLambda, kStateCount };
// Order of the per-point properties in Columns.
enum PropertyColumn : int { kColumnKn, kColumnKs, kColumnTauM, kColumnFp, kColumnGf, kPropertyColumnCount };

// Evaluates count points with the best instruction set of the processor; columns are padded to whole vectors.
void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary);
// Evaluates one point, only traction and states, in the caller's memory; bitwise identical to evaluate.
void evaluate_one(const Parameters& material, const shim::Columns& columns, shim::Summary& summary);

}  // namespace quoin::bond_slip
