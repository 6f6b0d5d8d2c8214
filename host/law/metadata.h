// Checks of the tables in which a law library describes itself, before other code reads them.
#pragma once

#include <cstddef>
#include <string>

#include "quoin.hpp"

namespace quoin {

// Whether this many bytes can be read, without a crash if not. True where the system has no such check.
bool is_readable(const void* address, std::size_t bytes);

// Error in the tables, as far as the host relies on them; empty: none. The head of the library (size and version) must
// have been checked.
std::string fault_of_tables(const quoin_library& library);

}  // namespace quoin
