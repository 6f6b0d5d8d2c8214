// Numbers in text: on command lines, in CSV, mesh and record files.
#pragma once

#include <charconv>
#include <string_view>
#include <system_error>

namespace quoin {

// Reads the number that is the whole of `text`, in any locale; blanks around it and a plus sign are allowed. False for
// other text, and for numbers out of the type's range. For floating point, "inf" and "nan" are numbers. Integers have
// digits only, so 1.7 and 1e3 are none.
template <typename Number>
bool parse_number(std::string_view text, Number& value) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return false;
  text = text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  return fault == std::errc() && end == text.data() + text.size();
}

}  // namespace quoin
