// The tables that a law library describes itself with, checked before anything else of the host reads them.
#pragma once

#include <cstddef>
#include <string>

#include "quoin.hpp"

namespace quoin {

// Whether so many bytes are there, without a crash when they are not. Where the system gives no answer: true.
bool is_readable(const void* address, std::size_t bytes);

// What is wrong with the tables, as far as the host relies on them, whatever they hold; empty: nothing. The head of
// the library (size and version) has been checked.
std::string fault_of_tables(const quoin_library& library);

}  // namespace quoin
