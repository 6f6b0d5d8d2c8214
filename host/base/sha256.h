// SHA-256, as sha256sum prints it: files and texts that a run depends on are named by it.
#pragma once

#include <sha256.h>

#include <cstdint>
#include <string>

namespace quoin {

class Sha256 {
 public:
  Sha256() { SHA256Init(&context_); }
  void add(const void* data, std::size_t size) {
    SHA256Update(&context_, static_cast<const std::uint8_t*>(data), size);
  }
  // With its length, so that two texts in a row are not one.
  void add_text(const std::string& text) {
    const std::uint64_t size = text.size();
    add(&size, sizeof size);
    add(text.data(), text.size());
  }
  // 64 hexadecimal digits, once.
  std::string end() {
    char digits[SHA256_DIGEST_STRING_LENGTH];
    return SHA256End(&context_, digits);
  }

 private:
  SHA2_CTX context_;
};

inline std::string sha256_of(const std::string& bytes) {
  Sha256 hash;
  hash.add(bytes.data(), bytes.size());
  return hash.end();
}

}  // namespace quoin
