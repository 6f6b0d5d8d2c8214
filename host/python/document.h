// Conversion of scenes between Python (dictionaries and lists with the names of TOML keys) and TOML tables.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "scene/toml.h"

namespace quoin::python {

// Table of numbers, texts, booleans, lists and dictionaries. Throws TypeError, with the dotted key, for other values.
toml::table table_of(const pybind11::dict& document);
pybind11::dict document_of(const toml::table& table);
std::string text_of(const toml::table& table);  // TOML that parses to the same table

}  // namespace quoin::python
