// Files that never look whole before they are: written under a name of their own, renamed when complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace quoin {

// Throws Error(bad_input) when the folder cannot be made or written.
void make_folder(const std::filesystem::path& folder);
void write_file(const std::filesystem::path& path, const std::string& bytes);
// On the disk when it returns, so that it outlives a crash of the machine too.
void write_durable_file(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes);

// For files that are written bit by bit: begin_file() notes PATH in the manifest of the folder of results that it lies
// in (result_folder.h) and returns where to write, finish_file() renames that.
std::filesystem::path begin_file(const std::filesystem::path& path);
void finish_file(const std::filesystem::path& path);

// PATH.TOKEN.part. The token is this process's own, so that two processes never write into one file.
std::filesystem::path part_name(const std::filesystem::path& path);
const std::string& part_token();

}  // namespace quoin
