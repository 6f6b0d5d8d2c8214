// A simulation for Python. Its steps run without the interpreter's lock. It keeps all that it has reported.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "files/result_folder.h"
#include "law/law_calls.h"
#include "law/law_library.h"
#include "results/checkpoint_file.h"
#include "results/history.h"
#include "results/monitors.h"
#include "results/provenance.h"
#include "results/summary.h"
#include "results/surface.h"
#include "results/vtk.h"
#include "step/simulation.h"
#include "step/steer.h"

namespace quoin::python {

namespace py = pybind11;

using SceneHashes = std::map<std::string, std::string>;  // by key of the scene

struct Frame {
  double time = 0.0;               // s
  std::vector<Vec3> displacement;  // displacement of the gridpoints of all blocks, block by block, m
  // Places of these gridpoints at the start, m; a promotion changes their order.
  std::shared_ptr<const std::vector<Vec3>> place;
  std::vector<JointPoint> joints;
};

// Every method throws quoin::Error, and std::runtime_error while another thread steps the simulation.
class Session : private Observer {
 public:
  // threads: 0: all of the machine. folder: of files of the results; empty: no files. A law in processes of its own
  // that does not return from a batch within law_seconds (0: no limit) is ended, with Error(numerical). Otherwise it
  // ends the program, as on the command line.
  Session(Scene scene, int threads, bool keep_frames, const std::string& folder, bool isolate_law, double law_seconds);

  // Computes `count` steps, or fewer if the last stage ends or, with stop_at_stage_end, any stage. Returns whether more
  // steps remain. KeyboardInterrupt between two steps leaves the state as it is.
  bool step(long count, bool stop_at_stage_end);
  // Sets a function of (stage from 0, stages, name, fraction), called about four times a second; None: no function.
  void set_progress(py::object progress) { progress_ = std::move(progress); }

  // Columns of the history so far, {name: array}; texts are lists.
  py::dict history() const;
  py::dict measure() const;  // the current row of the history
  // Text of summary.json of the run; completes the files of the folder, if there is one. The end of the last stage
  // completes them too.
  std::string finish(const std::string& status, const std::string& message);
  // Completes the files of a run that is left before its end. failure: what ended it; empty: nothing.
  void close(const std::string& failure);
  void tell_warnings();  // as UserWarnings, each assumption once
  py::list frames() const;
  py::dict mesh() const;
  py::dict contacts(int family) const;
  std::array<py::array, 3> damage(int family) const;

  py::array block_array(BlockArray what, int block);
  py::array point_array(PointArray what, int family);
  py::array state(int family, const std::string& id);
  LawSwap swap_law(const std::string& joint, const std::string& law);
  void velocities_changed() { quoin::velocities_changed(use()); }
  int block_named(const py::object& block) const;  // number, or name of one block; throws IndexError, KeyError
  int family_named(const std::string& name) const;

  py::bytes save(const SceneHashes& scene) const;
  void restore(const py::bytes& bytes, const SceneHashes& scene);
  void checkpoint(const std::string& path, const SceneHashes& scene) const;
  void resume(const std::string& path, const SceneHashes& scene);

  Simulation& use() const;  // simulation for a call that holds the interpreter's lock

 private:
  bool advance(long count, bool stop_at_stage_end);
  // Begins the files of the folder with the rows so far, and with rows of monitors and times of frames of the same run.
  void begin_files(const std::vector<std::vector<double>>& monitor_rows, std::vector<double> frame_times);
  void on_stage_begin(const Simulation& simulation, int stage) override;
  void on_promotion(const Simulation& simulation) override;
  void on_warning(const Warning& warning) override { warn(warning); }
  void on_row(const HistoryRow& row) override;
  void on_pause(const Simulation& simulation, bool last) override;
  void on_progress(const Progress& progress) override;
  void on_frame(const Simulation& simulation, int stage, int frame) override;
  void warn(const Warning& warning);
  RunInfo info_of(const std::string& status, const std::string& message);
  [[noreturn]] void end_with_law(const Material& material, const quoin_batch& batch, double seconds);
  py::array array_of(const ArrayView& view, bool writeable) const;
  Identity identity_of(const SceneHashes& scene) const;
  Checkpoint now() const;
  void go_back(const Checkpoint& to, std::vector<double> frame_times);
  std::pair<std::size_t, std::size_t> points_of(int family) const;  // index of the first point, and one past the last

  LawIsolation isolation_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), looked_ = start_;
  std::unique_ptr<Simulation> simulation_;
  std::vector<HistoryColumn> columns_;
  std::vector<HistoryRow> rows_;
  bool keep_frames_;
  std::unique_ptr<Surfaces> surfaces_;
  std::vector<Frame> frames_;
  std::unique_ptr<ResultFolder> own_;
  std::filesystem::path folder_;
  std::optional<History> file_;
  std::optional<MonitorFile> monitors_;
  std::optional<VtkSeries> series_;
  py::object progress_ = py::none();
  bool stepping_ = false;
  std::string summary_;                // summary.json, when the files are complete; else empty
  std::vector<StageModes> modes_;      // modes of stages with ground motion
  std::vector<std::string> warnings_;  // warnings not yet returned to Python
  std::set<std::string> reported_;     // Warning::about of these, and of those that were returned
  std::optional<LawWatchdog> watchdog_;
  std::vector<HashedFile> files_;  // files of the scene and of its laws, with their hashes at the start
  Provenance provenance_;
};

}  // namespace quoin::python
