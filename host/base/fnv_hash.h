// FNV-1a hash in 64 bits: it detects accidental changes, not intended ones (for those see sha256.h).
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace quoin {

class FnvHash {
 public:
  FnvHash() = default;
  explicit FnvHash(std::uint64_t start) : value_(start) {}

  // Adds a byte, or a word of eight bytes in one step. A word's hash differs from that of its bytes.
  void add(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001b3u; }
  void add(std::string_view text) {
    for (const char c : text) add(static_cast<unsigned char>(c));
  }
  void add(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) add(byte);
  }
  // Mixes high bits into low ones, which multiplication alone does not change.
  void fold() { value_ ^= value_ >> 29; }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

// Start value of the hashes of golden runs and caches; it is not that of FNV.
inline constexpr std::uint64_t kOtherHashStart = 1469598103934665603u;

}  // namespace quoin
