// summary.json: what a run was and what came out, in one object.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/crushed_out.h"
#include "results/provenance.h"
#include "results/quasi_static.h"
#include "results/warnings.h"
#include "step/simulation.h"

namespace quoin {

// What damping does to the first modes of vibration of a stage that moves the ground, as it begins.
struct StageModes {
  struct Mode {
    double frequency = 0.0, ratio = 0.0;  // Hz; of critical
  };
  int stage = 0;
  std::vector<Mode> modes;
  std::string why_none;  // empty: they are known
};
std::string modes_text(const StageModes& modes);  // "first modes: 12.1 Hz 0.4 %, 15.3 Hz 0.5 %"

struct RunInfo {
  std::string status = "done";  // done, interrupted, failed
  std::string message;          // message of a failure
  double wall_clock_s = 0.0;    // process start to end
  QuasiStatic quasi_static;
  CrushedOut crushed_out;
  bool law_answers = true;  // else states of contact points, which laws return, are left out
  std::vector<Warning> warnings;
  std::vector<StageModes> modes;
  Provenance provenance;
};

// False once the process that evaluates one of them has ended.
bool laws_answer(const Simulation& simulation);

// Message about a law that does not return from a batch, but for how to give it more time.
std::string overdue_text(const Simulation& simulation, const Material& material, const quoin_batch& batch,
                         double seconds);

// The laws in use: one name, or "mortar: a, unit: b" when families differ.
std::string law_names(const Assembly& assembly);

// Reason why the stated errors of the quality do not apply to this run: its kind, or its course. Empty where they do.
std::string why_error_unknown(const Scene& scene, const RunInfo& info);

// As the file has it.
std::string summary_text(const Simulation& simulation, const std::vector<HistoryRow>& rows, const RunInfo& info);
void write_summary(const std::filesystem::path& path, const Simulation& simulation, const std::vector<HistoryRow>& rows,
                   const RunInfo& info);

}  // namespace quoin
