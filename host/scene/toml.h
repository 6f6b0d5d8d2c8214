// toml++ as a header, without its shared library.
#pragma once

#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
// Version 3.3 asserts that a key begins with a valid character before it reports one that does not. A faulty file would
// end the program. Where asserts are off and assumed true, a compiler may drop the report.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_assert(true)
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <optional>

namespace quoin {

// Number of a node, or nothing. An integer without an exact double is rounded to the nearest one, as digits with a
// decimal point are. The function value<double>() of toml++ returns nothing for it.
inline std::optional<double> number_of(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  if (const auto* decimal = node.as_floating_point()) return decimal->get();
  return std::nullopt;
}

}  // namespace quoin
