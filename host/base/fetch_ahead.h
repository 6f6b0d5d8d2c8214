// Prefetch of memory that is read soon. It changes no result.
#pragma once

#include <cstddef>

namespace quoin {

inline void fetch_ahead(const void* from, std::size_t bytes) {
  constexpr std::size_t kCacheLine = 64;
  for (std::size_t at = 0; at < bytes; at += kCacheLine)
    __builtin_prefetch(static_cast<const unsigned char*>(from) + at);
}

}  // namespace quoin
