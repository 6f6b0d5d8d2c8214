#include "results/file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "scene/error.h"

namespace quoin {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw Error(Exit::bad_input, fmt::format("{}: cannot make this folder for results ({}); choose another with --out",
                                             folder.string(), error ? error.message() : "a file is in the way"));
}

std::filesystem::path part_name(const std::filesystem::path& path) { return path.string() + ".part"; }

void finish_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::rename(part_name(path), path, error);
  if (error) throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}", path.string(), error.message()));
}

void write_file(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream stream(part_name(path), std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream)
    throw Error(Exit::bad_input,
                fmt::format("{}: cannot be written: {}; free space or choose another folder with --out", path.string(),
                            std::strerror(errno)));
  finish_file(path);
}

}  // namespace quoin
