// Memory of the machine, and checks of what fits into it.
#pragma once

#include <string>

namespace quoin {

// Memory limit of this process, bytes: the least of the machine, its control group (a container) and ulimit -v.
double memory_here();

// Throws Error(bad_input) where this many bytes do not fit. `what` begins the message, `remedy` ends it.
void require_memory(double bytes, const std::string& what, const std::string& remedy);

}  // namespace quoin
