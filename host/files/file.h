// Files that are never visible before they are complete: written under a name of their own, renamed when complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace quoin {

// Throws Error(bad_input) when the folder cannot be made or written.
void make_folder(const std::filesystem::path& folder);
void write_file(const std::filesystem::path& path, const std::string& bytes);
// A file that a user named. Where PATH is a link it stays one and its target is written; a device or pipe gets the
// bytes and keeps its place. Throws Error(bad_input), for a folder and a link to nothing too.
void write_named_file(const std::filesystem::path& path, const std::string& bytes);
// The target of such a link, or PATH itself. Throws Error(bad_input) for a folder and a link to nothing.
std::filesystem::path named_place(const std::filesystem::path& path);
// A file that is written bit by bit; not there without finish() of what it is. All throw Error(bad_input).
class UnfinishedFile {
 public:
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

 protected:
  explicit UnfinishedFile(const std::filesystem::path& path);
  ~UnfinishedFile();
  // Result of the last call of the system: on failure the file is abandoned.
  void require(bool good);
  void close_and_rename();

  std::filesystem::path path_, part_;
  int file_ = -1;
};

// On the disk when it is finished, so that it outlives a crash of the machine too.
class DurableFile : public UnfinishedFile {
 public:
  explicit DurableFile(const std::filesystem::path& path) : UnfinishedFile(path) {}
  void append(std::span<const std::uint8_t> bytes);
  // The first bytes once more, with what is known at the end alone.
  void finish(std::span<const std::uint8_t> first_bytes = {});
};

// From its first byte to its last.
class GrowingFile : public UnfinishedFile {
 public:
  explicit GrowingFile(const std::filesystem::path& path) : UnfinishedFile(path) {}
  void append(std::string_view bytes);
  void finish() { close_and_rename(); }
};

// Written at any places, in any order.
class PlacedFile : public UnfinishedFile {
 public:
  explicit PlacedFile(const std::filesystem::path& path) : UnfinishedFile(path) {}
  void write_at(std::uint64_t place, std::span<const char> bytes);
  void finish() { close_and_rename(); }
};

// Throws Error(bad_input) where the disk of FOLDER has not so many bytes left; `what` they are for stands in the
// message.
void require_space(const std::filesystem::path& folder, double bytes, const std::string& what);

// For files that are written bit by bit. begin_file() notes PATH in the manifest of its folder of results
// (result_folder.h) and returns where to write; finish_file() renames that.
std::filesystem::path begin_file(const std::filesystem::path& path);
void finish_file(const std::filesystem::path& path);

// PATH.TOKEN.part. The token is this process's own, so that two processes never write into one file.
std::filesystem::path part_name(const std::filesystem::path& path);
const std::string& part_token();
// One token of the manifest for all processes that write files of the same folder. Called before any file is written.
void use_part_token(const std::string& token);

}  // namespace quoin
