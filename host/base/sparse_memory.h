// Memory that takes space in the machine only where values other than zero were written.
//
// A rank has arrays with the length of the whole model, so that all item numbers are global. Only its own items and
// those of neighbours take memory; the other addresses are never written to.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace quoin {

// Least size of arrays whose memory comes from the system, which supplies zeroed pages when they are written to.
inline constexpr std::size_t kSparseBytes = std::size_t{1} << 17;

inline constexpr std::size_t kLineBytes = 64;    // line of the cache
inline constexpr std::size_t kPageBytes = 4096;  // least page of the system

// The address sanitizer checks only memory of `new`, so its builds use that.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kSparse = false;
#elif defined(__has_feature)
inline constexpr bool kSparse = !__has_feature(address_sanitizer);
#else
inline constexpr bool kSparse = true;
#endif

// Set with ranks: the system then supplies the memory of large arrays, by small pages. A single process writes to all
// of its arrays. The memory of `new` is used again, while new pages at each detection cost a tenth of a step.
inline std::atomic<bool> sparse_memory_wanted = false;

// Allocator of zeroed memory, aligned to a cache line.
template <class T>
struct SparseMemory {
  static_assert(std::is_trivially_copyable_v<T>);
  using value_type = T;
  SparseMemory() = default;
  template <class U>
  SparseMemory(const SparseMemory<U>&) {}

  // The byte before the array is the number of bytes skipped before it, or 0 for memory of the system.
  T* allocate(std::size_t n) {
    const std::size_t bytes = n * sizeof(T);
    if (!kSparse || !sparse_memory_wanted || bytes < kSparseBytes) {
      // Aligned by hand: an allocator's aligned memory makes a detection a fifth slower.
      auto* const memory = static_cast<unsigned char*>(::operator new(bytes + kLineBytes));
      const std::size_t skipped = kLineBytes - reinterpret_cast<std::uintptr_t>(memory) % kLineBytes;
      memory[skipped - 1] = static_cast<unsigned char>(skipped);
      return reinterpret_cast<T*>(std::memset(memory + skipped, 0, bytes));
    }
    void* const memory =
        mmap(nullptr, bytes + kPageBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    madvise(memory, bytes + kPageBytes, MADV_NOHUGEPAGE);
    return reinterpret_cast<T*>(static_cast<unsigned char*>(memory) + kPageBytes);
  }
  void deallocate(T* p, std::size_t n) {
    auto* const memory = reinterpret_cast<unsigned char*>(p);
    if (memory[-1] == 0)
      munmap(memory - kPageBytes, n * sizeof(T) + kPageBytes);
    else
      ::operator delete(memory - memory[-1]);
  }
  // Default values are zeros, whatever the type, and zeros are not written.
  template <class U>
  void construct(U* place) {
    const auto* const bytes = reinterpret_cast<const unsigned char*>(place);
    unsigned char any = 0;
    for (std::size_t i = 0; i < sizeof(U); ++i) any |= bytes[i];
    if (any != 0) std::memset(static_cast<void*>(place), 0, sizeof(U));
  }
  // Given values that are zeros are not written either.
  template <class U, class... From>
  void construct(U* place, From&&... from) {
    const U value = U(std::forward<From>(from)...);
    // Compares bits: -0.0 is not zero. NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    if (std::memcmp(place, &value, sizeof value) != 0) ::new (static_cast<void*>(place)) U(value);
  }
  template <class U>
  bool operator==(const SparseMemory<U>&) const {
    return true;
  }
};

// Releases the pages that lie wholly in this memory; they read as zeros from then on.
template <class T>
void release_memory(std::span<T> memory) {
  static const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::span<std::byte> bytes = std::as_writable_bytes(memory);
  const std::size_t before = (page - reinterpret_cast<std::uintptr_t>(bytes.data()) % page) % page;
  if (bytes.size() < before + page) return;
  madvise(bytes.data() + before, (bytes.size() - before) / page * page, MADV_DONTNEED);
}

template <class Array>
void release_part(Array& array, std::size_t first, std::size_t end) {
  release_memory(std::span(array).subspan(first, end - first));
}

// Visits runs of consecutive indices with this value: visit(first, end).
template <class Visit>
void each_row(const std::vector<bool>& values, bool value, Visit visit) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != value) continue;
    const std::size_t first = i;
    while (i < values.size() && values[i] == value) ++i;
    visit(first, i);
  }
}

}  // namespace quoin
