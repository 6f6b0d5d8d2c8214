#pragma once

#include <cstddef>

namespace quoin {

// Index of an array from a number that is not negative.
inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace quoin
