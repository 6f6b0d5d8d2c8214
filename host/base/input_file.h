// Whole input files of users. Devices and pipes, which may never end, are refused before they are read.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string>
#include <system_error>

#include "base/error.h"
#include "base/kept_inputs.h"

namespace quoin {

inline constexpr std::size_t kLargestInput = std::size_t{1} << 28;  // bytes; no reader takes larger text

[[noreturn]] inline void refuse_input(const std::string& file, const std::string& why) {
  throw Error(Exit::bad_input, file + ": cannot read it: " + why);
}
inline std::string system_words() { return std::error_code(errno, std::generic_category()).message(); }

// A file that is open for reading; closed with the object.
struct InputFile {
  explicit InputFile(int opened) : number(opened) {}
  ~InputFile() {
    if (number >= 0) close(number);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  const int number;
  std::size_t size = 0;  // size by the file system, bytes
};

// Throws Error(bad_input) with the reason: missing file, folder, device or pipe, not readable.
inline std::unique_ptr<InputFile> open_input_file(const std::string& file) {
  struct stat status {};
  // The kind is checked before opening, as opening a device can have effects, and opening a pipe waits for its writer.
  if (stat(file.c_str(), &status) != 0) refuse_input(file, errno == ENOENT ? "no such file" : system_words());
  if (S_ISDIR(status.st_mode)) refuse_input(file, "it is a folder; give a file");
  if (!S_ISREG(status.st_mode))
    refuse_input(file, "it is no regular file but a device, pipe or socket; give a file on a disk");
  auto input = std::make_unique<InputFile>(open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (input->number < 0 || fstat(input->number, &status) != 0) refuse_input(file, system_words());
  if (!S_ISREG(status.st_mode)) refuse_input(file, "it is no regular file");
  input->size = static_cast<std::size_t>(status.st_size);
  return input;
}

// Bytes of FILE, or its kept bytes (kept_inputs.h). Throws as open_input_file, and for more than `largest` bytes.
inline std::string read_input_file(const std::string& file, std::size_t largest = kLargestInput) {
  if (const std::string* kept = kept_inputs().find(file)) return *kept;
  const auto input = open_input_file(file);
  const auto too_large = [&] {
    refuse_input(file, fmt::format("it has more than {} MB; is it the right file?", largest >> 20));
  };
  if (input->size > largest) too_large();

  // Reads to the end, not to the size: files of /proc have size 0.
  std::string bytes;
  for (std::size_t done = 0;;) {
    bytes.resize(done + (done < input->size ? input->size - done : 0) + 4096);
    const ssize_t count = read(input->number, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse_input(file, system_words());
    done += static_cast<std::size_t>(count);
    if (done > largest) too_large();
    if (count > 0) continue;
    bytes.resize(done);
    if (kept_inputs().keeping()) kept_inputs().keep(file, bytes);
    return bytes;
  }
}

// The same of a text, without the byte order mark that some editors write first.
inline std::string read_text_file(const std::string& file) {
  std::string text = read_input_file(file);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

}  // namespace quoin
