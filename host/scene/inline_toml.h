// TOML on one line, read back to the same node. The formatter of toml++ breaks lines by a width that it computes as no
// number for values between -0.1 and 0.1.
#pragma once

#include <string>

#include "scene/toml.h"

namespace quoin {

// A node as the right side of key = ...; tables inline.
std::string inline_toml(const toml::node& node);
// A document: a line for each key.
std::string toml_lines(const toml::table& table);

}  // namespace quoin
