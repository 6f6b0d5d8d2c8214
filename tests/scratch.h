// Files of a test, in a folder of its own that goes with it: test programs run side by side, and leave nothing behind.
#pragma once

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace quoin {

class Scratch {
 public:
  Scratch() { std::filesystem::create_directories(folder_); }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  // Writes a file, and returns its path.
  std::string file(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }

 private:
  static std::string next_name() {
    static std::atomic<int> count = 0;
    return "quoin_test_" + std::to_string(getpid()) + "_" + std::to_string(++count);
  }
  std::filesystem::path folder_ = std::filesystem::temp_directory_path() / next_name();
};

}  // namespace quoin
