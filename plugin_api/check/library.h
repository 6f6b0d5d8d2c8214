// A shared library, opened without code of the host: ELF symbols are read from the file, the entry point by dlopen.
#pragma once

#include <string>
#include <vector>

#include "quoin/quoin.h"

namespace check {

struct Library {
  std::string path;
  std::vector<std::string> exported;  // defined, visible dynamic symbols
  quoin_library_function entry = nullptr;
  std::string error;  // why it could not be opened
};

Library open_library(const std::string& path);

// Returns the description of a host of this ABI version.
quoin_host_info host_info(uint32_t major = QUOIN_ABI_MAJOR, uint32_t minor = QUOIN_ABI_MINOR);

}  // namespace check
