// Pool of processes that compute samples, one sample and one thread each. Any number of pools may work on one folder.
#pragma once

#include <cstdint>
#include <functional>

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

struct PoolSettings {
  std::uint64_t first = 0, samples = 0;  // numbers of samples, both inclusive; 0: the means
  int jobs = 1;
  bool wait_for_others = true;  // whether to wait for samples that other processes have claimed
};

// Computes samples that are neither finished nor claimed. compute(number, folder) runs in a process of its own, which
// dies with this one. A crash there makes a failed sample, which fail(number, folder, reason) records; a sample whose
// process is killed is computed again. Progress goes to standard error. Throws Error(interrupted) after Ctrl-C, with
// all running samples given up, and Error(bad_input) when samples cannot be written.
void compute_samples(const StudyFolder& folder, const PoolSettings& settings,
                     const std::function<void(std::uint64_t, const std::filesystem::path&)>& compute,
                     const std::function<void(std::uint64_t, const std::filesystem::path&, const std::string&)>& fail);

}  // namespace quoin::ensemble
