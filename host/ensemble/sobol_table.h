// What matters where inputs act together: Sobol's indices of a study with Trials::exchanged.
#pragma once

#include <string>

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

// sobol.csv in the folder, of what is finished of so many rows. It has a row an input and output, with first and total
// index and their intervals. Returns a table in words, of the peak force (of the collapse multiplier where there is no
// peak), what matters most first. Throws Error(bad_input) where it cannot be written.
std::string write_sobol_table(const StudyFolder& folder, const Study& study, std::uint64_t rows);

}  // namespace quoin::ensemble
