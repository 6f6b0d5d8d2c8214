#pragma once

#include <cstddef>

namespace quoin {

// Array index from a non-negative number.
inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace quoin
