// SHA-256, as sha256sum prints it: files and texts that a run depends on are named by it.
#pragma once

#include <openssl/evp.h>

#include <array>
#include <cstdint>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

namespace quoin {

// By libcrypto, which has the processor's own instructions for it: every run hashes its program and its laws.
class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new()) {
    if (!context_) throw std::bad_alloc();
    need(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr));
  }
  void add(const void* data, std::size_t size) { need(EVP_DigestUpdate(context_.get(), data, size)); }
  // With its length, so that two texts in a row are not one.
  void add_text(const std::string& text) {
    const std::uint64_t size = text.size();
    add(&size, sizeof size);
    add(text.data(), text.size());
  }
  // 64 hexadecimal digits, once.
  std::string end() {
    std::array<unsigned char, 32> bytes;
    need(EVP_DigestFinal_ex(context_.get(), bytes.data(), nullptr));
    std::string digits;
    for (const unsigned char byte : bytes) {
      digits += "0123456789abcdef"[byte / 16];
      digits += "0123456789abcdef"[byte % 16];
    }
    return digits;
  }

 private:
  static void need(int done) {
    if (done != 1) throw std::runtime_error("libcrypto cannot compute SHA-256");
  }
  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  std::unique_ptr<EVP_MD_CTX, Free> context_;
};

inline std::string sha256_of(const std::string& bytes) {
  Sha256 hash;
  hash.add(bytes.data(), bytes.size());
  return hash.end();
}

}  // namespace quoin
