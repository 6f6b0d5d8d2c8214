#include "results/file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <random>
#include <system_error>

#include "results/result_folder.h"
#include "scene/error.h"

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

}  // namespace quoin
