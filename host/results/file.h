// Files that never look whole before they are: written to NAME.part, renamed when complete.
#pragma once

#include <filesystem>
#include <string>

namespace quoin {

// Throws Error(bad_input) when the folder cannot be made or written.
void make_folder(const std::filesystem::path& folder);
void write_file(const std::filesystem::path& path, const std::string& bytes);
std::filesystem::path part_name(const std::filesystem::path& path);
void finish_file(const std::filesystem::path& path);  // renames the part

}  // namespace quoin
