#include "files/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <random>
#include <system_error>

#include "base/error.h"
#include "files/result_folder.h"

namespace quoin {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw Error(Exit::bad_input, fmt::format("{}: cannot make this folder for results ({}); choose another with --out",
                                             folder.string(), error ? error.message() : "a file is in the way"));
}

const std::string& part_token() {
  // Random, as two computers or containers that share a folder may have the same process number.
  static const std::string token = fmt::format("{:08x}", std::random_device{}());
  return token;
}

std::filesystem::path part_name(const std::filesystem::path& path) {
  return fmt::format("{}.{}.part", path.string(), part_token());
}

std::filesystem::path begin_file(const std::filesystem::path& path) {
  note_result(path);
  return part_name(path);
}

void finish_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::rename(part_name(path), path, error);
  if (error) throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}", path.string(), error.message()));
}

void write_file(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream stream(begin_file(path), std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) {
    const std::string reason = std::strerror(errno);
    std::error_code ignored;
    std::filesystem::remove(part_name(path), ignored);
    throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}; free space or choose another place with --out",
                                             path.string(), reason));
  }
  finish_file(path);
}

void write_durable_file(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  const std::filesystem::path part = begin_file(path);
  std::error_code ignored;
  std::filesystem::remove(part, ignored);  // never written through a link
  const int file = open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  bool good = file >= 0;
  for (std::size_t done = 0; good && done < bytes.size();) {
    const ssize_t count = write(file, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    good = count > 0;
    if (good) done += static_cast<std::size_t>(count);
  }
  good = good && fsync(file) == 0;
  const int fault = errno;
  if (file >= 0) close(file);
  if (!good) {
    std::filesystem::remove(part, ignored);
    throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}; free space or choose another place with --out",
                                             path.string(), std::strerror(fault)));
  }
  finish_file(path);
  // The name, too, is on the disk only when its folder is.
  const int folder =
      open(path.has_parent_path() ? path.parent_path().c_str() : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  fsync(folder);
  close(folder);
}

}  // namespace quoin
