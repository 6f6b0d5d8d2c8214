#pragma once

#include "elastic/parameters.h"
#include "shim/columns.h"

namespace quoin::elastic {

// On the best instruction set of this machine. count points; columns are padded to whole vectors.
void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary);

}  // namespace quoin::elastic
