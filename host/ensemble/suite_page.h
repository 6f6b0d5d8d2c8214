// What a study with records adds up to: tables of samples and runs, fragilities, pictures, a page.
#pragma once

#include <cstdint>
#include <string>

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

// Files of a study, from what is finished of it. One process at a time. Throws Error(bad_input).
struct SuiteResults {
  std::uint64_t finished = 0, failed = 0, runs = 0;
  std::string text;  // fragilities, for the screen, one line each
};
SuiteResults gather_suite(const StudyFolder& folder, const Study& study, bool pictures);

}  // namespace quoin::ensemble
