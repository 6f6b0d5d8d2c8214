// Shared libraries as files: whether all of one is there. The loader maps what the head of the file promises, and ends
// the program where the file is shorter.
#pragma once

#include <string>

namespace quoin {

// What is missing from the bytes of an ELF file of this machine's kind. Empty: nothing, or it is another file, whose
// fault the loader reports.
std::string missing_of_elf(const std::string& bytes);

}  // namespace quoin
