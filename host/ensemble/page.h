// The results of a study: samples.csv, summary.json, curve_bands.csv, crack_probability.csv, pictures and index.html.
#pragma once

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

struct Gathered {
  std::uint64_t finished = 0, failed = 0;  // numbers of samples, from 1 on
  double peak = 0.0, scatter = 0.0;        // mean and scatter of peak_force_N; not a number: no peaks
  double of_means = 0.0;                   // the peak of sample 0
};

// From the finished samples, 1 to `samples`. With pictures only when `pictures`. One process at a time, so that a later
// state of the study is never overwritten by an earlier one. Throws Error(bad_input) where something cannot be written.
Gathered gather(const StudyFolder& folder, const Study& study, std::uint64_t samples, bool pictures);

}  // namespace quoin::ensemble
