// Text from outside (laws, scenes, meshes, file names) for a terminal, which would execute control characters.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace quoin {

// Number of bytes of the printable character at `i`; 0 for a control character or invalid UTF-8. Line ends and tabs
// count as printable.
inline std::size_t shown_bytes(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u; };
  const unsigned first = byte(i);
  if (first < 0x80) return first == '\n' || first == '\t' || (first >= 0x20 && first != 0x7f) ? 1 : 0;
  const std::size_t count = first >= 0xf0 && first < 0xf5 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 0;
  if (count == 0 || first >= 0xf5) return 0;
  for (std::size_t k = 1; k < count; ++k) {
    if ((byte(i + k) & 0xc0) != 0x80) return 0;
  }
  return first == 0xc2 && byte(i + 1) < 0xa0 ? 0 : count;  // U+0080 to U+009F control terminals too
}

inline bool is_printable(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t count = shown_bytes(text, i);
    if (count == 0) return false;
    i += count;
  }
  return true;
}

// The text with bytes that is_printable refuses written as \x1b.
inline std::string printable(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t count = shown_bytes(text, i);
    if (count == 0)
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    else
      result += text.substr(i, count);
    i += count == 0 ? 1 : count;
  }
  return result;
}

}  // namespace quoin
