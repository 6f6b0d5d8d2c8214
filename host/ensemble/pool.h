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

struct SampleActions {
  // Computes a sample, in a process of its own that dies with this one.
  std::function<void(std::uint64_t number, const std::filesystem::path& folder)> compute;
  // Records a failed sample.
  std::function<void(std::uint64_t number, const std::filesystem::path& folder, const std::string& reason)> fail;
  std::function<bool(const std::filesystem::path& folder)> is_finished;  // some calls a sample
};

// Computes samples that are neither finished nor claimed. A crash makes a failed sample; a sample whose process is
// killed is computed again. Progress goes to standard error. Throws Error(interrupted) after Ctrl-C, with all running
// samples given up, and Error(bad_input) when samples cannot be written.
void compute_samples(const StudyFolder& folder, const PoolSettings& settings, const SampleActions& actions);

}  // namespace quoin::ensemble
