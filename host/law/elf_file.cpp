#include "law/elf_file.h"

#include <elf.h>
#include <fmt/format.h>
#include <link.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

namespace quoin {

std::string missing_of_elf(const std::string& bytes) {
  using Head = ElfW(Ehdr);
  using Part = ElfW(Phdr);
  if (bytes.compare(0, SELFMAG, ELFMAG) != 0) return bytes.empty() ? "the file is empty" : "";
  const auto too_short = [&](std::uint64_t needed) {
    return fmt::format("the file has {} bytes of {}: it was not copied or built to its end", bytes.size(), needed);
  };
  Head head;
  if (bytes.size() < sizeof head) return too_short(sizeof head);
  std::memcpy(&head, bytes.data(), sizeof head);
  const int word = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
  const int order = std::endian::native == std::endian::little ? ELFDATA2LSB : ELFDATA2MSB;
  if (head.e_ident[EI_CLASS] != word || head.e_ident[EI_DATA] != order) return "";

  // Sums cannot overflow: numbers beyond the file's size are compared before they are added.
  const std::uint64_t size = bytes.size();
  const auto end_of = [&](std::uint64_t from, std::uint64_t length) {
    return from > size || length > size - from ? std::max(from, length) + std::min(from, length) : 0;
  };
  if (head.e_phentsize != sizeof(Part) && head.e_phnum > 0) return "its head is damaged";
  if (const auto end = end_of(head.e_phoff, std::uint64_t{head.e_phnum} * sizeof(Part))) return too_short(end);
  for (int i = 0; i < head.e_phnum; ++i) {
    Part part;
    std::memcpy(&part, bytes.data() + head.e_phoff + static_cast<std::size_t>(i) * sizeof part, sizeof part);
    if (const auto end = end_of(part.p_offset, part.p_filesz)) return too_short(end);
  }
  // The section table, which the loader ignores, is the end of the files that linkers write.
  if (const auto end = end_of(head.e_shoff, std::uint64_t{head.e_shnum} * head.e_shentsize)) return too_short(end);
  return "";
}

}  // namespace quoin
