// Counts allocations by operator new in this program and in the plug-ins that it loads. Included by one file of a
// program. Out of line, so that the compiler does not warn about free in place of delete.
#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

namespace quoin::tests {
inline std::atomic<long> allocations = 0;
}

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++quoin::tests::allocations;
  if (void* const memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
