// Bytes of a fuzzer as a file, for readers of files.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

// Writes a file with these bytes and returns its name. The next call with this ending overwrites it.
inline std::string file_of(const std::uint8_t* data, std::size_t size, const std::string& ending) {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path memory = "/dev/shm";
    std::error_code fault;
    return std::filesystem::is_directory(memory, fault) ? memory : std::filesystem::temp_directory_path();
  }();
  const std::string name = (folder / ("quoin_fuzz_" + std::to_string(getpid()) + ending)).string();
  std::ofstream(name, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return name;
}
