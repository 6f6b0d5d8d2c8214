#include "files/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
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

namespace {

std::string& own_token() {
  // Random, as two computers or containers that share a folder may use the same process number.
  static std::string token = fmt::format("{:08x}", std::random_device{}());
  return token;
}

}  // namespace

const std::string& part_token() { return own_token(); }
void use_part_token(const std::string& token) { own_token() = token; }

std::filesystem::path part_name(const std::filesystem::path& path) {
  return fmt::format("{}.{}.part", path.string(), part_token());
}

std::filesystem::path begin_file(const std::filesystem::path& path) {
  note_result(path);
  return part_name(path);
}

void abandon_file(const std::filesystem::path& path) {
  std::error_code ignored;
  std::filesystem::remove(part_name(path), ignored);
}

void finish_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::rename(part_name(path), path, error);
  if (error) throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}", path.string(), error.message()));
}

namespace {

std::string words_of(int fault) { return std::error_code(fault, std::generic_category()).message(); }

[[noreturn]] void refuse_write(const std::filesystem::path& path, int fault) {
  throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}; free space or choose another place with --out",
                                           path.string(), words_of(fault)));
}

// Writes all bytes; returns false with errno set on failure.
bool write_all(int file, const void* bytes, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t count = write(file, static_cast<const char*>(bytes) + done, size - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}

}  // namespace

void write_file(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream stream(begin_file(path), std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) {
    const int fault = errno;
    abandon_file(path);
    refuse_write(path, fault);
  }
  finish_file(path);
}

std::filesystem::path named_place(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status kind = fs::status(path, error);
  if (fs::is_directory(kind)) throw Error(Exit::bad_input, path.string() + ": is a folder; give the name of a file");
  const bool device = fs::exists(kind) && !fs::is_regular_file(kind);  // /dev/stdout may be a link without a file
  if (device || !fs::is_symlink(path, error)) return path;
  const fs::path target = fs::canonical(path, error);
  if (error)
    throw Error(Exit::bad_input, fmt::format("{}: is a link that leads to no file ({}); remove it or give another name",
                                             path.string(), error.message()));
  return target;
}

void refuse_input_as_output(const std::filesystem::path& output, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    std::error_code none;
    if (std::filesystem::equivalent(output, input, none) && std::filesystem::is_regular_file(output, none))
      throw Error(Exit::bad_input,
                  fmt::format("{}: is an input of this command, and would be written over; give another name to --out",
                              output.string()));
  }
}

void write_named_file(const std::filesystem::path& path, const std::string& bytes) {
  const std::filesystem::path place = named_place(path);
  std::error_code error;
  if (!std::filesystem::exists(place, error) || std::filesystem::is_regular_file(place, error))
    return write_file(place, bytes);
  const int file = open(place.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  const bool good = file >= 0 && write_all(file, bytes.data(), bytes.size());
  const int fault = errno;
  if (file >= 0) close(file);
  if (!good) refuse_write(path, fault);
}

void require_space(const std::filesystem::path& folder, double bytes, const std::string& what) {
  std::error_code unknown;
  std::filesystem::path there = std::filesystem::absolute(folder);
  while (!std::filesystem::exists(there, unknown) && there.has_relative_path()) there = there.parent_path();
  double room = static_cast<double>(std::filesystem::space(there, unknown).available);
  if (unknown) return;
  for (const auto& entry : std::filesystem::directory_iterator(folder, unknown)) {
    std::error_code no_file;
    const auto size = entry.file_size(no_file);
    if (!no_file) room += static_cast<double>(size);
  }
  if (bytes <= room) return;
  throw Error(
      Exit::bad_input,
      fmt::format("{}: {} need about {:.3g} MB and {:.3g} MB are free there; free space, ask for less or choose "
                  "another place with --out",
                  folder.string(), what, bytes / 1e6, room / 1e6));
}

UnfinishedFile::UnfinishedFile(const std::filesystem::path& path) : path_(path), part_(begin_file(path)) {
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);  // removed first, so that a link is never followed
  file_ = open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (file_ < 0) refuse_write(path, errno);
}

UnfinishedFile::~UnfinishedFile() {
  if (file_ < 0) return;
  close(file_);
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void UnfinishedFile::require(bool good) {
  if (good) return;
  const int fault = errno;
  close(file_);
  file_ = -1;
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
  refuse_write(path_, fault);
}

void UnfinishedFile::close_and_rename() {
  close(file_);
  file_ = -1;
  finish_file(path_);
}

void DurableFile::append(std::span<const std::uint8_t> bytes) { require(write_all(file_, bytes.data(), bytes.size())); }

void DurableFile::finish(std::span<const std::uint8_t> first_bytes) {
  if (!first_bytes.empty() && lseek(file_, 0, SEEK_SET) == 0) append(first_bytes);
  require(fsync(file_) == 0);
  close_and_rename();
  // The name is on the disk only after its folder is synchronised.
  const int folder =
      open(path_.has_parent_path() ? path_.parent_path().c_str() : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  fsync(folder);
  close(folder);
}

void GrowingFile::append(std::string_view bytes) { require(write_all(file_, bytes.data(), bytes.size())); }

void PlacedFile::write_at(std::uint64_t place, std::span<const char> bytes) {
  require(lseek(file_, static_cast<off_t>(place), SEEK_SET) >= 0 && write_all(file_, bytes.data(), bytes.size()));
}

}  // namespace quoin
