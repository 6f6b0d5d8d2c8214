#pragma once

#include <cstddef>

#include "bond_slip/parameters.h"
#include "shim/columns.h"

namespace quoin::bond_slip {

// Order of the states in the metadata and in Columns.
enum StateColumn : int { kSlipS, kSlipT, kLambda, kStateCount };
// Order of the per-point properties in Columns.
enum PropertyColumn : int { kColumnKn, kColumnKs, kColumnTauM, kColumnFp, kColumnGf, kPropertyColumnCount };

// On the best instruction set of this machine. count points; columns are padded to whole vectors.
void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary);
// The same bits for one point, in the caller's own memory; nothing but traction and states.
void evaluate_one(const Parameters& material, const shim::Columns& columns, shim::Summary& summary);

}  // namespace quoin::bond_slip
