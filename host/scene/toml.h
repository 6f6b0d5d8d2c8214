// toml++ as a header, so that a scene reader depends on no shared library of it.
#pragma once

#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include <optional>

namespace quoin {

// The number of a node, or nothing. An integer that no double equals is rounded to the nearest one, as the same digits
// with a decimal point are; toml++'s own value<double>() gives nothing for it.
inline std::optional<double> number_of(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  if (const auto* decimal = node.as_floating_point()) return decimal->get();
  return std::nullopt;
}

}  // namespace quoin
