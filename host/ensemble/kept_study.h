// What a study was read from, kept in its folder. Any process on any machine goes on with it, whatever has become of
// the files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace quoin::ensemble {

struct StudyRequest {
  std::string study;                   // file
  std::vector<std::string> overrides;  // overrides of the command line
};

// Writes kept_inputs() and the request to FOLDER/inputs; what is there already is left or replaced, file by file. One
// process at a time. Throws Error(bad_input).
void keep_study(const std::filesystem::path& folder, const StudyRequest& request);

// Whether FOLDER is one of a study, and not the file of one.
bool is_kept_study(const std::filesystem::path& folder);
// Gives kept_inputs() what is kept there and goes to the working folder of then, from which paths count. Throws
// Error(bad_input): it is not whole.
StudyRequest take_kept_study(const std::filesystem::path& folder);

}  // namespace quoin::ensemble
