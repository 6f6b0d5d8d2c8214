// Sensitivity with interactions of inputs: Sobol's indices of a study with Trials::exchanged.
#pragma once

#include <string>

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

// Writes sobol.csv in the folder, for the finished ones among `rows` rows. It has a row per input and output, with
// first and total index and their intervals. Returns a table as text for the peak force, or for the collapse multiplier
// without one. The largest effects come first. Throws Error(bad_input) when the file cannot be written.
std::string write_sobol_table(const StudyFolder& folder, const Study& study, std::uint64_t rows);

}  // namespace quoin::ensemble
