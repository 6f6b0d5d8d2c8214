// Laws for the adapters: found by name, opened once a process, never unloaded (a host may hold points until it exits).
#pragma once

#include <filesystem>
#include <string>

#include "quoin/quoin.h"

namespace quoin::adapters {

// The shared library or program that holds this code.
std::filesystem::path own_file();

// The law of this name (NAME.so, on Windows NAME.dll). It is sought in the folders of QUOIN_LAW_PATH (separated by ':',
// on Windows by ';'), in the adapter's own folder and in laws/ beside that. Throws std::runtime_error saying where it
// was sought, or why the library was refused. Any thread.
const quoin_law& law_by_name(const std::string& name);

// The first law of a library file.
const quoin_law& law_in_file(const std::filesystem::path& file);

}  // namespace quoin::adapters
