// The results of a study: samples.csv, summary.json, curve_bands.csv, crack_probability.csv, pictures and index.html.
#pragma once

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

struct Gathered {
  std::uint64_t finished = 0, failed = 0;  // numbers of samples, without the means
  double peak = 0.0, scatter = 0.0;        // mean and scatter of peak_force_N; NaN: there are no peaks
  double of_means = 0.0;                   // peak of sample 0, the means
};

// Writes the results of the finished samples among 1 to `samples`. pictures: also draws them. One process at a time, so
// that an earlier state never replaces a later one. Throws Error(bad_input) when a file cannot be written.
Gathered gather(const StudyFolder& folder, const Study& study, std::uint64_t samples, bool pictures);

}  // namespace quoin::ensemble
