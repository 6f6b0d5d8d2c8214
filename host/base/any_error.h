// Error with a message for the user, from any exception that ends a command or a run.
#pragma once

#include <fmt/format.h>

#include <new>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "base/error.h"

namespace quoin {

// An Error stays as it is. smaller: remedy where memory is missing; std::filesystem and threads report that as a
// std::system_error. with: what a report of a fault of the program or of a law should include.
inline Error any_error(const std::exception& error, std::string_view smaller = "make the scene smaller",
                       std::string_view with = "the scene") {
  if (const auto* known = dynamic_cast<const Error*>(&error)) return *known;
  const auto* of_system = dynamic_cast<const std::system_error*>(&error);
  if (dynamic_cast<const std::bad_alloc*>(&error) || (of_system && of_system->code() == std::errc::not_enough_memory))
    return {Exit::numerical, fmt::format("out of memory; {}", smaller)};
  return {Exit::numerical, fmt::format("internal error: {}; please report it with {}", error.what(), with)};
}

}  // namespace quoin
