// SHA-256 as sha256sum prints it; it identifies the files and texts that a run depends on.
#pragma once

#define OPENSSL_SUPPRESS_DEPRECATED  // EVP, its successor, allocates in every call, and crashes where that fails
#include <openssl/sha.h>

#include <array>
#include <cstdint>
#include <string>

namespace quoin {

// Uses libcrypto, which has the processor's instructions for it: every run hashes its program and its laws.
class Sha256 {
 public:
  Sha256() { SHA256_Init(&context_); }
  void add(const void* data, std::size_t size) { SHA256_Update(&context_, data, size); }
  // Includes the length, so that two consecutive texts differ from one.
  void add_text(const std::string& text) {
    const std::uint64_t size = text.size();
    add(&size, sizeof size);
    add(text.data(), text.size());
  }
  // 64 hexadecimal digits; may be called once.
  std::string end() {
    std::array<unsigned char, 32> bytes;
    SHA256_Final(bytes.data(), &context_);
    std::string digits;
    for (const unsigned char byte : bytes) {
      digits += "0123456789abcdef"[byte / 16];
      digits += "0123456789abcdef"[byte % 16];
    }
    return digits;
  }

 private:
  SHA256_CTX context_;
};

inline std::string sha256_of(const std::string& bytes) {
  Sha256 hash;
  hash.add(bytes.data(), bytes.size());
  return hash.end();
}

}  // namespace quoin
