// Repetition of a run by its summary, and comparison of both results.
#pragma once

#include <filesystem>

#include "cli/prepare.h"
#include "results/provenance.h"

namespace quoin {

// Options of a run by its provenance, with the stored text of its scene. Changes the working directory to that of the
// run.
SceneOptions options_of(const Provenance& there);

// Default folder of the results: FOLDER-again, next to FOLDER.
std::filesystem::path folder_again(const std::filesystem::path& folder);

// Throws Error(bad_input) before the run when other files have changed since. Prints other differences on the terminal.
void hold_against(const Provenance& here, const Provenance& there);

// After the run, prints on standard output whether the bits are equal, and the first difference. The folders hold
// history.csv. Returns whether they are equal.
bool say_whether_same(const Provenance& here, const std::filesystem::path& folder_here, const Provenance& there,
                      const std::filesystem::path& folder_there);

}  // namespace quoin
