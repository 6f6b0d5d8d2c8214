// Shared libraries as files: whether all of one is there. The loader maps what the head of the file promises, and ends
// the program where the file is shorter.
#pragma once

#include <string>

namespace quoin {

// What is missing from the bytes of an ELF file of this machine's kind; empty: nothing, or they are something else, of
// which the loader can speak.
std::string missing_of_elf(const std::string& bytes);

}  // namespace quoin
