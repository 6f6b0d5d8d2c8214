// checkpoint.bin: what a run needs to go on as if it had never stopped.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "results/provenance.h"
#include "step/simulation.h"

namespace quoin {

// What a checkpoint belongs to. The run that goes on must have the same, word for word.
struct Identity {
  struct Part {
    std::string what;   // as a message calls it: "scene", "library of the law 'elastic'"
    std::string value;  // version or hash
  };
  std::vector<Part> parts;
};

// Of a simulation at its start, before any step. It covers program, scene (text, overrides, series and blocks from
// other files) and every law of every stage.
Identity identity_of(const Simulation& simulation, const Provenance& provenance);

// Place of the state in a file that was found whole, which other ranks receive.
struct StoredState {
  std::uint64_t begin = 0, bytes = 0;
  std::uint64_t checksum = 0;  // by which files are compared
  bool is_refused = false;     // for other ranks: there is nothing to go on from
};

struct Checkpoint {
  std::vector<HistoryRow> rows;     // rows of the history until then
  std::vector<double> frame_times;  // s, of the VTK frames until then
  std::vector<std::uint8_t> state;  // bytes of Simulation::save
  StoredState stored{};             // state of a checkpoint that was read
};

// Complete and on the disk, or not there: written under a name of its own, flushed, renamed. Throws Error(bad_input).
void write_checkpoint(const std::filesystem::path& path, const Identity& identity, const Checkpoint& checkpoint);
// Writes the current state, piece by piece: all ranks call simulation.save at this moment.
void write_checkpoint(const std::filesystem::path& path, const Identity& identity, const std::vector<HistoryRow>& rows,
                      const std::vector<double>& frame_times, const Simulation& simulation);

// Throws Error(bad_input) with the reason: damaged, of another machine, another version, another scene or law.
Checkpoint read_checkpoint(const std::filesystem::path& path, const Identity& expected);
// The same without the state, which may be as large as the memory.
Checkpoint find_checkpoint(const std::filesystem::path& path, const Identity& expected);
// By all ranks, of which each reads what it holds. Throws as Simulation::restore, or where another file lies there.
void restore_from(const std::filesystem::path& path, const StoredState& state, Simulation* simulation);

// FOLDER/end_state.bin: where scenes with start = FOLDER begin. Throws as write_checkpoint.
void write_end_state(const std::filesystem::path& folder, const Simulation& simulation, const Provenance& provenance);

// Puts a simulation that has not moved yet where its scene starts: at rest, or at the end of another run. Its own
// stages begin with those of that run. Throws Error(bad_input) with the reason, as read_checkpoint.
void take_start(Simulation* simulation);

// Before a run empties the folder of its results: throws Error(bad_input) when its scene starts from what lies there.
void keep_start(const Scene& scene, const std::filesystem::path& folder);

}  // namespace quoin
