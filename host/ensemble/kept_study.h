// Copies of all input of a study in its folder. Any process on any machine can continue the study from them, even after
// the original files have changed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace quoin::ensemble {

struct StudyRequest {
  std::string study;                   // file
  std::vector<std::string> overrides;  // --set of the command line
};

// Writes kept_inputs() and the request to FOLDER/inputs; equal files stay. One process at a time. Throws
// Error(bad_input).
void keep_study(const std::filesystem::path& folder, const StudyRequest& request);

// Whether FOLDER is the folder of a study.
bool is_kept_study(const std::filesystem::path& folder);
// Sets kept_inputs() from FOLDER/inputs and changes to the working directory of the study, to which paths are relative.
// Throws Error(bad_input) if the copy is damaged.
StudyRequest take_kept_study(const std::filesystem::path& folder);

}  // namespace quoin::ensemble
