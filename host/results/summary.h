// summary.json: settings and results of a run, in one object.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/crushed_out.h"
#include "results/provenance.h"
#include "results/quasi_static.h"
#include "results/stage_modes.h"
#include "results/warnings.h"
#include "step/simulation.h"

namespace quoin {

std::string modes_text(const StageModes& modes);  // "first modes: 12.1 Hz 0.4 %, 15.3 Hz 0.5 %"

struct RunInfo {
  std::string status = "done";  // done, interrupted, failed
  std::string message;          // message of a failure
  double wall_clock_s = 0.0;    // from process start to end
  QuasiStatic quasi_static;
  CrushedOut crushed_out;
  bool law_answers = true;  // else results without the states of contact points, which laws return
  std::vector<Warning> warnings;
  std::vector<StageModes> modes;
  Provenance provenance;
};

// False after the process that evaluates a law has ended.
bool laws_answer(const Simulation& simulation);

// Message about a law that does not return from a batch, without advice to change its time limit.
std::string overdue_text(const Simulation& simulation, const Material& material, const quoin_batch& batch,
                         double seconds);

// Names of the laws in use: one name, or "mortar: a, unit: b" when families differ.
std::string law_names(const Assembly& assembly);

// Reason why the stated errors of the quality do not apply to this run: its kind, or its course. Empty where they do.
std::string why_error_unknown(const Scene& scene, const RunInfo& info);

// Contents of the file.
std::string summary_text(const Simulation& simulation, const std::vector<HistoryRow>& rows, const RunInfo& info);
void write_summary(const std::filesystem::path& path, const Simulation& simulation, const std::vector<HistoryRow>& rows,
                   const RunInfo& info);

}  // namespace quoin
