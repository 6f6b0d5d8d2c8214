// Blanks and capitals of text that users write.
#pragma once

#include <cctype>
#include <string>
#include <string_view>

namespace quoin {

// Without the blanks at both ends; blanks: characters that count as such.
inline std::string trimmed(std::string_view text, std::string_view blanks = " \t\r\n") {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(blanks) - first + 1));
}
// Without blanks and quotes at both ends, as cells of tables have them.
inline std::string unquoted(std::string_view text) { return trimmed(text, " \t\r\""); }

// Small letters of ASCII for capital ones, and the other way round.
inline std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}
inline std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace quoin
