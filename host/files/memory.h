// Memory of the machine, for what would not fit into it.
#pragma once

#include <string>

namespace quoin {

// Bytes that this process may use: of the machine, of its control group (a container's), or of ulimit -v.
double memory_here();

// Throws Error(bad_input): what takes so many bytes does not fit. `what` begins the message, `remedy` ends it.
void require_memory(double bytes, const std::string& what, const std::string& remedy);

}  // namespace quoin
