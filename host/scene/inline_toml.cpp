#include "scene/inline_toml.h"

#include <fmt/format.h>

#include <sstream>

namespace quoin {

namespace {

std::string line(const toml::key& key, const toml::node& node) {
  return fmt::format("{} = {}", inline_toml(toml::value<std::string>(std::string(key.str()))), inline_toml(node));
}

}  // namespace

std::string inline_toml(const toml::node& node) {
  std::string items;
  const auto add = [&items](const std::string& item) { items += (items.empty() ? "" : ", ") + item; };
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& element : *array) add(inline_toml(element));
    return items.empty() ? "[]" : "[ " + items + " ]";
  }
  if (const toml::table* table = node.as_table()) {
    for (auto&& [key, value] : *table) add(line(key, value));
    return items.empty() ? "{}" : "{ " + items + " }";
  }
  if (const auto* number = node.as_floating_point()) {
    std::string text = fmt::format("{}", number->get());
    if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";  // not an integer
    return text;
  }
  std::ostringstream out;
  out << toml::toml_formatter(node, toml::format_flags::allow_literal_strings);  // no literals of several lines
  return out.str();
}

std::string key_part(const std::string& name) {
  if (name.find_first_of(".='\"") == std::string::npos) return name;
  const char quote = name.find('"') == std::string::npos ? '"' : '\'';
  return quote + name + quote;
}

std::string toml_lines(const toml::table& table) {
  std::string text;
  for (auto&& [key, value] : table) text += line(key, value) + "\n";
  return text;
}

}  // namespace quoin
