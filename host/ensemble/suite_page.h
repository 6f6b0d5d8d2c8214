// Results of a study with records: tables of samples and runs, fragilities, pictures, page.
#pragma once

#include <cstdint>
#include <string>

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

// Results in the files of a study, from its finished tasks. One process at a time. Throws Error(bad_input).
struct SuiteResults {
  std::uint64_t finished = 0, failed = 0, runs = 0;
  std::string text;  // fragilities, one line each
};
SuiteResults gather_suite(const StudyFolder& folder, const Study& study, bool pictures);

}  // namespace quoin::ensemble
