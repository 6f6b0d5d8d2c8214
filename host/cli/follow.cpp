#include "cli/follow.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <span>

#include "cli/again.h"
#include "cli/keep_results.h"
#include "cli/resume.h"
#include "cli/run_begin.h"
#include "cli/stop_on_signal.h"
#include "files/file.h"
#include "files/notice.h"
#include "files/result_folder.h"
#include "law/law_calls.h"
#include "results/surface.h"
#include "step/findings.h"
#include "step/rest.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

// Observer on ranks other than 0, which alone prints and writes; these write their pieces of frames.
class Follower : public Observer {
 public:
  Follower(const SharedFolder& folder, bool compressed, Pieces pieces) {
    if (pieces.count <= 1) return;
    frames_.emplace(folder.path, surfaces_, folder.frame_times, compressed, pieces);
    try {
      note_results_of_rank(folder.path, pieces.rank);
    } catch (const Error& error) {  // as in on_frame
      fault_ = error;
    }
  }
  bool wants_pause(bool) override { return false; }
  void on_pause(const Simulation& simulation, bool) override { simulation.save({}); }  // rank 0 writes a checkpoint
  void on_promotion(const Simulation&) override { surfaces_ = Surfaces(); }
  void on_frame(const Simulation& simulation, int, int) override {
    if (!frames_) return collect_frame(simulation, surfaces_);
    if (fault_) return;
    try {
      frames_->add_piece(simulation);
    } catch (const Error& error) {  // the run continues without frames
      fault_ = error;
    }
  }
  const std::optional<Error>& fault() const { return fault_; }
  const Surfaces& surfaces() const { return surfaces_; }

 private:
  Surfaces surfaces_;
  std::optional<VtkSeries> frames_;  // in pieces
  std::optional<Error> fault_;
};

}  // namespace

void follow(RunOptions options, Ranks& ranks, int& exit_code) {
  if (!options.resume.empty()) {
    // read_run_record changes the working directory
    options.resume = fs::absolute(options.resume).string();
    if (is_done(options.resume)) return;
    read_run_record(options.resume, &options);
  }
  if (!options.again.empty()) options.scene = options_of(read_provenance(options.again));
  std::optional<LawWatchdog> of_set_up(std::in_place, options.law_seconds,
                                       end_program(options.law_seconds, "--law-seconds"));
  Simulation simulation(scene_of(&options, &ranks), threads_of(options, &ranks), &ranks);
  StoredState state;
  ranks.share(std::as_writable_bytes(std::span(&state, 1)));
  if (state.is_refused) throw Error(Exit::bad_input, "the checkpoint is refused by rank 0, which says why");
  begin(&simulation, options.resume, state);
  require_coming_stages(simulation);  // rank 0 refuses them here
  const Pieces pieces = pieces_of(simulation.scene(), &ranks);
  SharedFolder folder;
  if (pieces.count > 1) {
    share(ranks, folder);
    use_part_token(folder.token);
  }
  of_set_up.reset();
  const LawWatchdog watchdog(options.law_seconds, [&](const Material& material, const quoin_batch& batch) {
    notices_wanted = true;
    notice(fmt::format("quoin: rank {}: the law '{}' has not returned from a batch within {:g} s: {}", ranks.rank(),
                       material.api().id, options.law_seconds, batch_text(simulation, batch)));
    _exit(static_cast<int>(Exit::numerical));
  });
  const StopOnSignal guard(simulation);
  Follower follower(folder, options.compressed, pieces);
  const auto print_fault = [&](const std::string& text) {
    notices_wanted = true;
    notice(fmt::format("quoin: rank {}: {}", ranks.rank(), text));
  };
  bool failed = false;
  try {
    simulation.run(follower);
  } catch (const Error& error) {
    failed = true;
    exit_code = static_cast<int>(error.exit_code);
    if (!ranks_together(simulation)) {
      print_fault(error.what());
      ranks.abort(exit_code);
    }
  }
  collect_results(simulation, follower.surfaces(), failed);
  if (failed || !follower.fault()) return;
  exit_code = static_cast<int>(follower.fault()->exit_code);
  print_fault(fmt::format("frames for ParaView lack its pieces: {}", follower.fault()->what()));
}

}  // namespace quoin
