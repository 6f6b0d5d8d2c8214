// Bytes of a checkpoint; one list of fields serves writing and reading, so that both have the same fields. Structs are
// written as they lie in memory. They have no bytes between their members, which would be undefined: flags in them are
// as wide as their neighbours.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.h"

namespace quoin {

struct ArchiveWriter {
  std::vector<std::uint8_t>& bytes;
  void append(const void* from, std::size_t size) {
    const std::size_t end = bytes.size();
    bytes.resize(end + size);
    if (size > 0) std::memcpy(bytes.data() + end, from, size);
  }
  template <class T>
  void value(const T& x) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(&x, sizeof x);
  }
  template <class... T>
  void values(const T&... x) {
    (value(x), ...);
  }
  template <class T>
  void optional(const std::optional<T>& x) {
    value(x.has_value());
    value(x.value_or(T{}));
  }
  template <class Array>
  void array(const Array& x) {
    static_assert(std::is_trivially_copyable_v<std::remove_cvref_t<decltype(x[0])>>);
    const std::uint64_t count = x.size();
    value(count);
    append(x.data(), count * sizeof(x[0]));
  }
  // Writes each element by a list of fields: of_element(archive, element).
  template <class Element, class Fields>
  void list(const std::vector<Element>& x, Fields&& of_element) {
    const std::uint64_t count = x.size();
    value(count);
    for (const Element& element : x) of_element(*this, element);
  }
};

// Sequential source of bytes.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::size_t left() const = 0;
  // size: at most left()
  virtual void take(void* to, std::size_t size) = 0;
  virtual void skip(std::size_t size) = 0;
};

class BytesInMemory : public ByteSource {
 public:
  explicit BytesInMemory(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::size_t left() const override { return bytes_.size(); }
  void take(void* to, std::size_t size) override {
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    skip(size);
  }
  void skip(std::size_t size) override { bytes_ = bytes_.subspan(size); }

 private:
  std::span<const std::uint8_t> bytes_;
};

// Reads values from a source. Throws Error(bad_input) where the bytes end too early.
struct ArchiveReader {
  ByteSource& source;
  std::size_t left() const { return source.left(); }
  void take(void* to, std::size_t size) {
    if (left() < size) ends_too_early();
    source.take(to, size);
  }
  template <class T>
  void value(T& x) {
    static_assert(std::is_trivially_copyable_v<T>);
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      take(&byte, sizeof byte);
      if (byte > 1) throw Error(Exit::bad_input, "checkpoint: a flag is neither true nor false");
      x = byte == 1;
    } else {
      take(&x, sizeof x);
    }
  }
  template <class... T>
  void values(T&... x) {
    (value(x), ...);
  }
  template <class T>
  void optional(std::optional<T>& x) {
    bool has_value = false;
    T content{};
    value(has_value), value(content);
    x = has_value ? std::optional<T>(content) : std::nullopt;
  }
  template <class Array>
  void array(Array& x) {
    static_assert(std::is_trivially_copyable_v<std::remove_cvref_t<decltype(x[0])>>);
    x.resize(count_of(sizeof(x[0])));
    take(x.data(), x.size() * sizeof(x[0]));
  }
  // Reads the number of elements that follow, each of at least element_bytes.
  std::size_t count_of(std::size_t element_bytes) {
    std::uint64_t count = 0;
    value(count);
    if (count > left() / element_bytes) ends_too_early();
    return count;
  }
  template <class Element, class Fields>
  void list(std::vector<Element>& x, Fields&& of_element) {
    x.clear();
    // An element has at least one byte. Memory grows with the bytes that are there.
    for (std::size_t left = count_of(1); left > 0; --left) of_element(*this, x.emplace_back());
  }
  [[noreturn]] static void ends_too_early() { throw Error(Exit::bad_input, "checkpoint: the data end too early"); }
};

}  // namespace quoin
