// Samples computed by a pool of processes, one sample and one thread each. Any number of pools may work on one folder.
#pragma once

#include <cstdint>
#include <functional>

#include "ensemble/study_folder.h"

namespace quoin::ensemble {

struct PoolSettings {
  std::uint64_t first = 0, samples = 0;  // from the first (0: the means) to this one
  int jobs = 1;
  bool wait_for_others = true;  // for samples that other processes have claimed; else those are left to them
};

// Computes what is not finished and not claimed by others. compute(number, folder) runs in a process of its own, which
// dies with this one. One that crashes there is a failed sample, which fail(number, folder, reason) records; one that
// is killed is computed again. Lines of progress go to standard error. Throws Error(interrupted) after Ctrl-C, when all
// samples under way have been given up; Error(bad_input) when samples cannot be written.
void compute_samples(const StudyFolder& folder, const PoolSettings& settings,
                     const std::function<void(std::uint64_t, const std::filesystem::path&)>& compute,
                     const std::function<void(std::uint64_t, const std::filesystem::path&, const std::string&)>& fail);

}  // namespace quoin::ensemble
