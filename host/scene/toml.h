// toml++ as a header, so that a scene reader depends on no shared library of it.
#pragma once

#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
// Version 3.3 asserts that a key begins as keys do, and only then reports one that does not. The program would end over
// a bad file. Where asserts are off and assumed true, a compiler might leave the report out.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_assert(true)
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <optional>

namespace quoin {

// The number of a node, or nothing. An integer that no double equals is rounded to the nearest one, as the same digits
// with a decimal point are. The function value<double>() of toml++ gives nothing for it.
inline std::optional<double> number_of(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  if (const auto* decimal = node.as_floating_point()) return decimal->get();
  return std::nullopt;
}

}  // namespace quoin
