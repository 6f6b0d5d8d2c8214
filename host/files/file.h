// Files that are visible only when complete: written under a temporary name, then renamed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace quoin {

// Both throw Error(bad_input) when the folder cannot be made or written.
void make_folder(const std::filesystem::path& folder);
void write_file(const std::filesystem::path& path, const std::string& bytes);
// Writes a file that a user named. A link stays a link, and its target is written. A device or pipe receives the bytes
// and stays. Throws Error(bad_input), also for a folder and for a link without target.
void write_named_file(const std::filesystem::path& path, const std::string& bytes);
// Throws Error(bad_input) where the output is a file of the inputs, also by another name. An empty name is none.
void refuse_input_as_output(const std::filesystem::path& output, const std::vector<std::string>& inputs);
// Target of a link, or PATH itself. Throws Error(bad_input) for a folder and for a link without target.
std::filesystem::path named_place(const std::filesystem::path& path);
// A file that is written in parts; without finish() of the derived class it disappears. All calls throw
// Error(bad_input).
class UnfinishedFile {
 public:
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

 protected:
  explicit UnfinishedFile(const std::filesystem::path& path);
  ~UnfinishedFile();
  // good: result of the last system call; false abandons the file.
  void require(bool good);
  void close_and_rename();

  std::filesystem::path path_, part_;
  int file_ = -1;
};

// A file that is on the disk when finished, so that it survives a crash of the machine.
class DurableFile : public UnfinishedFile {
 public:
  explicit DurableFile(const std::filesystem::path& path) : UnfinishedFile(path) {}
  void append(std::span<const std::uint8_t> bytes);
  // first_bytes: replaces the beginning by values that are known only at the end.
  void finish(std::span<const std::uint8_t> first_bytes = {});
};

// A file that is written from its first byte to its last.
class GrowingFile : public UnfinishedFile {
 public:
  explicit GrowingFile(const std::filesystem::path& path) : UnfinishedFile(path) {}
  void append(std::string_view bytes);
  void finish() { close_and_rename(); }
};

// A file that is written at any positions, in any order.
class PlacedFile : public UnfinishedFile {
 public:
  explicit PlacedFile(const std::filesystem::path& path) : UnfinishedFile(path) {}
  void write_at(std::uint64_t place, std::span<const char> bytes);
  void finish() { close_and_rename(); }
};

// Throws Error(bad_input) where the disk of FOLDER has fewer bytes left. Files in it count as free, as results replace
// them. what: use of the bytes, for the message.
void require_space(const std::filesystem::path& folder, double bytes, const std::string& what);

// For files that are written in parts. begin_file() adds PATH to the manifest of its result folder (result_folder.h)
// and returns the temporary name; finish_file() renames that file, abandon_file() removes it.
std::filesystem::path begin_file(const std::filesystem::path& path);
void finish_file(const std::filesystem::path& path);
void abandon_file(const std::filesystem::path& path);

// PATH.TOKEN.part. The token is unique to this process, so that two processes never write the same file.
std::filesystem::path part_name(const std::filesystem::path& path);
const std::string& part_token();
// Sets one token for all processes that write files of the same folder. Called before any file is written.
void use_part_token(const std::string& token);

}  // namespace quoin
