// What matters, without sampling: every input tried by itself, at its 16 % and 84 % quantile, the others at their
// means.
#pragma once

#include <string>

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

// sensitivity.csv and sensitivity.png in the folder of a study with Trials::one_at_a_time whose samples are finished. A
// row an input and output: low, high, of the means, elasticity, share of the variance and bend. The share is for
// independent inputs and a straight response; the bend is how far it is from that. Returns a table in words, of the
// peak force (of the collapse multiplier where there is no peak), what matters most first. Throws Error(bad_input)
// where something cannot be written.
std::string write_sensitivity(const StudyFolder& folder, const Study& study, bool pictures);

}  // namespace quoin::ensemble
