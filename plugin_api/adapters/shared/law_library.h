// Laws for the adapters: found by name, opened once in a process, never unloaded, since a host may have contact points
// until it exits.
#pragma once

#include <filesystem>
#include <string>

#include "quoin/quoin.h"

namespace quoin::adapters {

// Returns the path of the shared library or program that contains this code.
std::filesystem::path own_file();

// Returns the law of this name, from NAME.so or on Windows NAME.dll. The search path is the folders of QUOIN_LAW_PATH
// (separated by ':', on Windows by ';'), the adapter's folder, and laws/ beside it. Throws std::runtime_error with the
// searched folders, or with the reason why the library is refused. May be called from any thread.
const quoin_law& law_by_name(const std::string& name);

// Returns the first law of a library file.
const quoin_law& law_in_file(const std::filesystem::path& file);

}  // namespace quoin::adapters
