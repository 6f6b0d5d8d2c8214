// Scenes as Python has them, dictionaries and lists with the names of the TOML keys, and as the reader of scenes does.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "scene/toml.h"

namespace quoin::python {

// Numbers, words, true and false, lists and dictionaries. TypeError with the dotted key for anything else.
toml::table table_of(const pybind11::dict& document);
pybind11::dict document_of(const toml::table& table);
std::string text_of(const toml::table& table);  // TOML that reads back to the same table

}  // namespace quoin::python
