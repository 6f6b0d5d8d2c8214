// Results of a run that has ended, for any reason.
#pragma once

#include <filesystem>
#include <optional>

#include "base/error.h"
#include "cli/recorder.h"
#include "cli/run_options.h"

namespace quoin {

// Writes all that was computed; the summary has the reason of the end. A file that cannot be written is reported and
// changes the exit code.
void keep_results(const std::filesystem::path& folder, Simulation& simulation, const Surfaces& surfaces,
                  const RunOptions& options, const std::optional<Error>& failure, Recorder& recorder, RunInfo& info,
                  int& exit_code);

// Sends what keep_results of rank 0 collects.
void collect_results(Simulation& simulation, const Surfaces& surfaces, bool failed);

// Ends the program from the watching thread while another thread never returns from the law. Writes what was computed,
// as far as it requires no call of the law.
[[noreturn]] void end_with_law(const Material& material, const quoin_batch& batch, double seconds,
                               const std::filesystem::path& folder, const Simulation& simulation, Recorder& recorder,
                               RunInfo info);

}  // namespace quoin
