// Runs that are repeated: from what their summary says of them, compared with what came out then.
#pragma once

#include <filesystem>

#include "cli/prepare.h"
#include "results/provenance.h"

namespace quoin {

// The request of the run in FOLDER, with its scene as it was read then. The working directory is changed to where
// it was started.
SceneOptions options_of(const Provenance& there);

// Where results go when nothing else is said: FOLDER-again, beside it.
std::filesystem::path folder_again(const std::filesystem::path& folder);

// Before the work: refuses other files that have changed since, and says on the terminal what else is not the same.
// Throws Error(bad_input).
void hold_against(const Provenance& here, const Provenance& there);

// After it: says on the standard output whether the bits are the same, and where they part. FOLDERS hold history.csv.
// Returns whether they are.
bool say_whether_same(const Provenance& here, const std::filesystem::path& folder_here, const Provenance& there,
                      const std::filesystem::path& folder_there);

}  // namespace quoin
