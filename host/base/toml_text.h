// Checks of TOML text before it is parsed. One reason is memory: toml++ recurses for each part of a dotted key, and
// uses a kilobyte per table. The other reason is control characters, which names and titles would send to the terminal.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/printable.h"

namespace quoin {

inline constexpr long kMostKeyParts = 100;
inline constexpr long kMostTables = 200000;   // [table] and [[table]]
inline constexpr long kMostValues = 4000000;  // values in lists included

// End of the string that begins at i: after its closing quote, or at the end of the line.
inline std::size_t end_of_toml_string(std::string_view text, std::size_t i) {
  const char quote = text[i];
  const std::string three(3, quote);
  const bool long_one = text.substr(i, 3) == three;
  for (i += long_one ? 3 : 1; i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"') {
      ++i;
    } else if (long_one && text.substr(i, 3) == three) {
      return i + 3;
    } else if (!long_one && (text[i] == quote || text[i] == '\n')) {
      return text[i] == quote ? i + 1 : i;
    }
  }
  return text.size();
}

// Whether a string with its quotes has no control characters, neither literal nor as an escape.
inline bool toml_string_is_printable(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t count = text[i] == '\r' ? 1 : shown_bytes(text, i);
    if (count == 0) return false;
    i += count;
    if (text[0] != '"' || text[i - 1] != '\\' || i >= text.size()) continue;
    const char kind = text[i++];
    if (kind == 'b' || kind == 'f' || kind == 'e') return false;
    if (kind != 'u' && kind != 'U') continue;
    unsigned long code = 0x20;  // the parser refuses malformed digits
    const std::string_view digits = text.substr(i, kind == 'u' ? 4 : 8);
    std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
    if ((code < 0x20 && code != 9 && code != 10 && code != 13) || (code >= 0x7f && code < 0xa0)) return false;
  }
  return true;
}

// Throws Error(bad_input) with file and line for text beyond these limits or with control characters. It does not
// detect all malformed TOML.
inline void refuse_unfit_toml(std::string_view text, const std::string& file) {
  long line = 1, depth = 0, dots = 0, tables = 0, values = 0;
  bool line_begins = true;
  const auto refuse = [&](const std::string& what) {
    throw Error(Exit::bad_input, fmt::format("{}:{}: {}", file, line, what));
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      const std::size_t end = end_of_toml_string(text, i);
      if (!toml_string_is_printable(text.substr(i, end - i)))
        refuse("a text holds a control character, or is not UTF-8; remove it, or save the file as UTF-8");
      for (; i < end; ++i) line += text[i] == '\n';
      --i;
      line_begins = false;
      continue;
    }
    if (c == '#') i = std::min(text.find('\n', i), text.size()) - 1;
    if (c == '#' || c == ' ' || c == '\t' || c == '\r') continue;
    if (c == '.' && ++dots >= kMostKeyParts) refuse(fmt::format("a key has more than {} parts", kMostKeyParts));
    if (c == '[' && line_begins && depth == 0 && ++tables > kMostTables)
      refuse(fmt::format("more than {} tables; is it the right file?", kMostTables));
    if ((c == '=' || c == ',') && ++values > kMostValues)
      refuse(fmt::format("more than {} values; give long series as CSV files", kMostValues));
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) dots = 0;
    line += c == '\n';
    line_begins = c == '\n';
  }
}

}  // namespace quoin
