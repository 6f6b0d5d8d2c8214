// Files that users name, read whole: what never ends (a device, a pipe that nobody writes) is refused before it is
// read.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "base/error.h"

namespace quoin {

inline constexpr std::size_t kLargestInput = std::size_t{1} << 28;  // bytes; text of this size has no reader

// The bytes of FILE. Throws Error(bad_input) with the reason: missing, a folder, a device or pipe, not readable, or
// larger than `largest` bytes.
inline std::string read_input_file(const std::string& file, std::size_t largest = kLargestInput) {
  const auto refuse = [&](const std::string& why) { throw Error(Exit::bad_input, file + ": cannot read it: " + why); };
  const auto system_words = [] { return std::error_code(errno, std::generic_category()).message(); };
  struct stat status {};
  // Looked at before it is opened, as opening alone has effects on some devices and waits for the writer of a pipe.
  if (stat(file.c_str(), &status) != 0) refuse(errno == ENOENT ? "no such file" : system_words());
  if (S_ISDIR(status.st_mode)) refuse("it is a folder; give a file");
  if (!S_ISREG(status.st_mode)) refuse("it is no regular file but a device, pipe or socket; give a file on a disk");
  struct Descriptor {
    int number;
    ~Descriptor() {
      if (number >= 0) close(number);
    }
  } const input{open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)};
  if (input.number < 0 || fstat(input.number, &status) != 0) refuse(system_words());
  if (!S_ISREG(status.st_mode)) refuse("it is no regular file");
  const auto too_large = [&] { refuse(fmt::format("it has more than {} MB; is it the right file?", largest >> 20)); };
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > largest) too_large();

  // To its end and not to the size: files of /proc say 0.
  std::string bytes;
  for (std::size_t done = 0;;) {
    bytes.resize(done + (done < size ? size - done : 0) + 4096);
    const ssize_t count = read(input.number, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse(system_words());
    done += static_cast<std::size_t>(count);
    if (done > largest) too_large();
    if (count > 0) continue;
    bytes.resize(done);
    return bytes;
  }
}

}  // namespace quoin
