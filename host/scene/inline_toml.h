// TOML on one line that parses to the same node. The formatter of toml++ breaks lines by an estimated width, which is
// not a number for values between -0.1 and 0.1.
#pragma once

#include <string>

#include "scene/toml.h"

namespace quoin {

// Text of a node for the right side of "key = ". Tables are inline.
std::string inline_toml(const toml::node& node);
// A name as part of a dotted key of --set: in quotes where it has a dot, an equals sign or a quote.
std::string key_part(const std::string& name);
// Text of a document: a line for each key.
std::string toml_lines(const toml::table& table);

}  // namespace quoin
