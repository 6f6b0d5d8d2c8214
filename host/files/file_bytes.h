// Part of a file as a source of bytes. Only bytes that are taken are read, some hundred kilobytes at a time.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/archive.h"

namespace quoin {

struct InputFile;

class FileBytes : public ByteSource {
 public:
  // The whole file. Throws Error(bad_input) as open_input_file, and where reading fails later.
  explicit FileBytes(const std::filesystem::path& path);
  ~FileBytes() override;
  std::size_t left() const override { return end_ - position_; }
  void take(void* to, std::size_t size) override;
  void skip(std::size_t size) override { position_ += size; }

  std::size_t position() const { return position_; }  // bytes from the beginning of the file
  void end_after(std::size_t size) { end_ = position_ + size; }

 private:
  void read_at(std::size_t position, void* to, std::size_t size) const;

  std::string path_;
  std::unique_ptr<InputFile> file_;
  std::size_t position_ = 0, end_ = 0;
  std::vector<std::uint8_t> window_;  // bytes of the file from window_begin_ on
  std::size_t window_begin_ = 0;
};

}  // namespace quoin
