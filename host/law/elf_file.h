// Completeness of shared libraries. The loader maps the sizes in a file's header, and a shorter file ends the program.
#pragma once

#include <string>

namespace quoin {

// The missing part of the bytes of an ELF file of this machine's kind. Empty for complete files, and for other files,
// whose error the loader reports.
std::string missing_of_elf(const std::string& bytes);

}  // namespace quoin
