// What a run leaves in its folder when it has ended, in whatever way.
#pragma once

#include <filesystem>
#include <optional>

#include "base/error.h"
#include "cli/recorder.h"
#include "cli/run_options.h"

namespace quoin {

// What was computed is kept, whatever ended the run; the summary says what ended it. What cannot be written is
// reported, and costs nothing else but the exit code.
void keep_results(const std::filesystem::path& folder, Simulation& simulation, const Surfaces& surfaces,
                  const RunOptions& options, const std::optional<Error>& failure, Recorder& recorder, RunInfo& info,
                  int& exit_code);

// What keep_results of rank 0 waits for.
void collect_results(Simulation& simulation, const Surfaces& surfaces, bool failed);

// From the thread that watches, while another one never returns from the law. What was computed is kept, as far as the
// law is not called for it.
[[noreturn]] void end_with_law(const Material& material, const quoin_batch& batch, double seconds,
                               const std::filesystem::path& folder, const Simulation& simulation, Recorder& recorder,
                               RunInfo info);

}  // namespace quoin
