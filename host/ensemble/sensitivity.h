// Sensitivity without sampling: each input alone at its 16 % and 84 % quantile, the others at their means.
#pragma once

#include <string>

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

// Writes sensitivity.csv and sensitivity.png in the folder of a finished study with Trials::one_at_a_time. Each row has
// an input and an output: low, high, that of the means, elasticity, share of the variance and bend. The share holds for
// independent inputs and a straight response; the bend measures the deviation from that. Returns a table as text for
// the peak force, or for the collapse multiplier without one. The largest effects come first. Throws Error(bad_input)
// when a file cannot be written.
std::string write_sensitivity(const StudyFolder& folder, const Study& study, bool pictures);

}  // namespace quoin::ensemble
