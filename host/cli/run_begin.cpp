#include "cli/run_begin.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <thread>

#include "results/report.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

// Sends bytes of rank 0 to all other ranks: a vector, or a text.
template <class Bytes>
void share_bytes(Ranks& ranks, Bytes& bytes) {
  std::uint64_t size = bytes.size();
  ranks.share(std::as_writable_bytes(std::span(&size, 1)));
  bytes.resize(size);
  ranks.share(std::as_writable_bytes(std::span(bytes)));
}

}  // namespace

Scene scene_of(RunOptions* options, const Ranks* ranks) {
  if (ranks) options->scene.processes = ranks->count(), options->scene.processes_here = ranks->count_on_this_machine();
  options->scene.runs = true;
  Scene scene = prepare_scene(options->scene);
  if (options->report && pieces_of(scene, ranks).count > 1)
    throw Error(Exit::usage, "--report: not with output.pieces, which ParaView reads and the page does not");
  if (options->report && !scene.has_frames())
    throw Error(Exit::usage,
                "--report: the page shows frames, and with output.frames = 0 there are none; set output.frames, for "
                "instance with --set output.frames=20, or leave --report out");
  if (options->serve >= 0 && (!scene.has_frames() || scene.output.pieces))
    throw Error(Exit::usage,
                "--live, --serve: the page shows frames, each in one file: leave output.pieces out, and set "
                "output.frames, for instance with --set output.frames=20");
  if ((options->report || options->serve >= 0) && (!ranks || ranks->rank() == 0)) require_report_library();
  return scene;
}

int threads_of(const RunOptions& options, const Ranks* ranks) {
  const int here = static_cast<int>(std::thread::hardware_concurrency());
  if (options.threads > 0) return options.threads;
  return std::max(1, ranks ? here / ranks->count_on_this_machine() : here);
}

Pieces pieces_of(const Scene& scene, const Ranks* ranks) {
  if (!ranks || !scene.output.pieces || !scene.has_frames()) return {};
  return {ranks->rank(), ranks->count()};
}

void begin(Simulation* simulation, const fs::path& folder, const StoredState& kept) {
  if (kept.bytes > 0)
    restore_from(folder / "checkpoint.bin", kept, simulation);
  else
    take_start(simulation);
}

void share(Ranks& ranks, SharedFolder& folder) {
  share_bytes(ranks, folder.path), share_bytes(ranks, folder.token), share_bytes(ranks, folder.frame_times);
}

}  // namespace quoin
