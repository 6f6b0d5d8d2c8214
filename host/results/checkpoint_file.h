// checkpoint.bin: all that a run needs to continue with the same bits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "results/provenance.h"
#include "results/stage_modes.h"
#include "step/simulation.h"

namespace quoin {

// Identity of the run of a checkpoint. A run that continues it must have an equal one.
struct Identity {
  struct Part {
    std::string what;   // its name in messages: "scene", "library of the law 'elastic'"
    std::string value;  // version or hash
  };
  std::vector<Part> parts;
};

// Identity of a simulation before its first step: program, scene (text, overrides, series and blocks from other files)
// and every law of every stage.
Identity identity_of(const Simulation& simulation, const Provenance& provenance);

// Position of the state in a complete file, which other ranks receive.
struct StoredState {
  std::uint64_t begin = 0, bytes = 0;
  std::uint64_t checksum = 0;  // checksum by which ranks compare files
  bool is_refused = false;     // for other ranks: there is no checkpoint to continue from
};

// Results of a run up to a checkpoint, beside the state.
struct ResultsSoFar {
  std::vector<HistoryRow> rows;                     // rows of the history
  std::vector<double> frame_times;                  // s, of the VTK frames
  std::vector<StageModes> modes;                    // modes of stages with ground motion
  std::vector<std::vector<double>> monitor_rows{};  // rows of monitors.csv
};

struct Checkpoint {
  ResultsSoFar results;
  std::vector<std::uint8_t> state;  // bytes of Simulation::save
  StoredState stored{};             // state of a checkpoint that was read
};

// Writes a temporary file, flushes and renames it: the checkpoint is complete and on the disk, or absent. Throws
// Error(bad_input).
void write_checkpoint(const std::filesystem::path& path, const Identity& identity, const Checkpoint& checkpoint);
// Writes the current state, piece by piece. Collective: all ranks call simulation.save at this moment.
void write_checkpoint(const std::filesystem::path& path, const Identity& identity, const ResultsSoFar& results,
                      const Simulation& simulation);

// Throws Error(bad_input) with the reason: damaged, of another machine, another version, another scene or law.
Checkpoint read_checkpoint(const std::filesystem::path& path, const Identity& expected);
// A checkpoint in memory, without protection against damage. Reading throws as read_checkpoint; its message names it
// `state`.
std::vector<std::uint8_t> checkpoint_bytes(const Identity& identity, const Checkpoint& checkpoint);
Checkpoint checkpoint_of(std::span<const std::uint8_t> bytes, const Identity& expected);
// Reads a checkpoint without its state, which may be as large as the memory.
Checkpoint find_checkpoint(const std::filesystem::path& path, const Identity& expected);
// Restores the state. Collective: each rank reads its own part. Throws as Simulation::restore, or if the file has
// changed.
void restore_from(const std::filesystem::path& path, const StoredState& state, Simulation* simulation);

// Writes FOLDER/end_state.bin, from which scenes with start = FOLDER begin. Throws as write_checkpoint.
void write_end_state(const std::filesystem::path& folder, const Simulation& simulation, const Provenance& provenance);

// Throws Error(bad_input) when the scene starts from a run that has no end state.
void require_start(const Scene& scene);

// Sets the initial state of a simulation: at rest, or the end state of another run. The first stages of its scene must
// be those of that run. Throws Error(bad_input) with the reason, as read_checkpoint.
void take_start(Simulation* simulation);

// Throws Error(bad_input) when the scene starts from results in the folder, which the run is about to empty.
void keep_start(const Scene& scene, const std::filesystem::path& folder);

}  // namespace quoin
