#include "library.h"

#include <dlfcn.h>
#include <elf.h>

#include <cstring>
#include <fstream>
#include <iterator>

namespace check {
namespace {

template <class T>
T at(const std::vector<char>& file, uint64_t offset) {
  T value{};
  if (offset + sizeof value <= file.size()) std::memcpy(&value, file.data() + offset, sizeof value);
  return value;
}

std::vector<std::string> exported_symbols(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::vector<char> file((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const auto header = at<Elf64_Ehdr>(file, 0);
  std::vector<std::string> names;
  if (file.size() < sizeof header || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return names;
  for (unsigned s = 0; s < header.e_shnum; ++s) {
    const auto section = at<Elf64_Shdr>(file, header.e_shoff + s * uint64_t{header.e_shentsize});
    if (section.sh_type != SHT_DYNSYM || section.sh_entsize == 0) continue;
    const auto strings = at<Elf64_Shdr>(file, header.e_shoff + section.sh_link * uint64_t{header.e_shentsize});
    for (uint64_t i = 0; i < section.sh_size / section.sh_entsize; ++i) {
      const auto symbol = at<Elf64_Sym>(file, section.sh_offset + i * section.sh_entsize);
      const unsigned visibility = ELF64_ST_VISIBILITY(symbol.st_other);
      if (symbol.st_shndx == SHN_UNDEF || ELF64_ST_BIND(symbol.st_info) == STB_LOCAL) continue;
      if (visibility != STV_DEFAULT && visibility != STV_PROTECTED) continue;
      std::string name;
      for (uint64_t c = strings.sh_offset + symbol.st_name; c < file.size() && file[c] != 0; ++c) name += file[c];
      names.push_back(name);
    }
  }
  return names;
}

}  // namespace

Library open_library(const std::string& path) {
  Library library;
  library.path = path.find('/') == std::string::npos ? "./" + path : path;
  library.exported = exported_symbols(library.path);
  void* handle = dlopen(library.path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    library.error = dlerror();
    return library;
  }
  void* symbol = dlsym(handle, QUOIN_LIBRARY_SYMBOL);
  if (symbol == nullptr) library.error = std::string("no symbol ") + QUOIN_LIBRARY_SYMBOL;
  std::memcpy(&library.entry, &symbol, sizeof symbol);
  return library;  // stays loaded until the checker ends
}

quoin_host_info host_info(uint32_t major, uint32_t minor) {
  return {sizeof(quoin_host_info), major, minor, "quoin-check-law", "1.0.0"};
}

}  // namespace check
