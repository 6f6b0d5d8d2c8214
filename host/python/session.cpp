#include "python/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <thread>
#include <utility>

#ifdef QUOIN_MODES
#include "analysis/damping_ratios.h"
#endif
#include "files/file.h"
#include "results/crushed_out.h"
#include "results/parted_joints.h"
#include "results/quasi_static.h"
#include "results/summary.h"
#include "results/warnings.h"
#include "scene/generate_blocks.h"
#include "scene/read_scene.h"
#include "step/findings.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "step/steer.h"

namespace quoin::python {

namespace {

constexpr double kLookPeriod = 0.05;  // s between two checks for Ctrl-C

// Array of rows x columns with the values value(row, column).
template <class T, class Value>
py::array_t<T> table_of(std::size_t rows, std::size_t columns, const Value& value) {
  const std::vector<py::ssize_t> shape =
      columns == 0 ? std::vector<py::ssize_t>{static_cast<py::ssize_t>(rows)}
                   : std::vector<py::ssize_t>{static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(columns)};
  py::array_t<T> result(shape);
  T* to = result.mutable_data();
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < std::max<std::size_t>(1, columns); ++c) *to++ = static_cast<T>(value(r, c));
  }
  return result;
}

template <class T, class Items, class Value>
py::array_t<T> column_of(const Items& items, const Value& value) {
  return table_of<T>(items.size(), 0, [&](std::size_t r, std::size_t) { return value(items[r]); });
}

template <class Items, class Value>
py::array_t<double> vectors_of(const Items& items, const Value& value) {
  return table_of<double>(items.size(), 3, [&](std::size_t r, std::size_t c) { return value(items[r])[c]; });
}

py::dict joints_of(const std::vector<JointPoint>& joints) {
  py::dict d;
  d["position"] = vectors_of(joints, [](const JointPoint& p) { return p.contact.position; });
  d["displacement"] = vectors_of(joints, [](const JointPoint& p) { return p.displacement; });
  d["traction"] = vectors_of(joints, [](const JointPoint& p) { return p.contact.traction; });
  d["opening"] = column_of<double>(joints, [](const JointPoint& p) { return p.opening; });
  d["slip"] = column_of<double>(joints, [](const JointPoint& p) { return p.slip; });
  d["damage_tension"] = column_of<double>(joints, [](const JointPoint& p) { return p.damage_tension; });
  d["damage_shear"] = column_of<double>(joints, [](const JointPoint& p) { return p.damage_shear; });
  d["crack"] = column_of<std::int32_t>(joints, [](const JointPoint& p) { return static_cast<int>(p.crack); });
  d["block_a"] = column_of<std::int32_t>(joints, [](const JointPoint& p) { return p.contact.block_a; });
  d["block_b"] = column_of<std::int32_t>(joints, [](const JointPoint& p) { return p.contact.block_b; });
  d["joint"] = column_of<std::int32_t>(joints, [](const JointPoint& p) { return p.contact.family; });
  d["gap"] = vectors_of(joints, [](const JointPoint& p) { return p.gap; });
  return d;
}

// Laws that this thread loads during the life of this object run in processes of their own.
class Isolated {
 public:
  explicit Isolated(const LawIsolation& wanted) : before_(isolate_laws(wanted)) {}
  ~Isolated() { isolate_laws(before_); }
  Isolated(const Isolated&) = delete;
  Isolated& operator=(const Isolated&) = delete;

 private:
  LawIsolation before_;
};

std::vector<Vec3> gridpoints_of(const Simulation& simulation) {
  std::vector<Vec3> places;
  for (int b = 0; b < simulation.block_count(); ++b) {
    const auto of_block = block_mesh(simulation, b).gridpoint;
    places.insert(places.end(), of_block.begin(), of_block.end());
  }
  return places;
}

// Index among `places` of each gridpoint in the current mesh. Places are the same, block by block.
std::vector<std::size_t> numbers_among(const std::vector<Vec3>& places, const Simulation& simulation) {
  const auto key = [](const Vec3& x) {  // cells of 0.1 um, whose boundaries avoid gridpoints
    std::array<long long, 3> cell{};
    for (std::size_t c = 0; c < 3; ++c) cell[c] = std::llround(x[c] * 1e7 + 0.3183);
    return cell;
  };
  std::vector<std::size_t> numbers;
  for (int b = 0; b < simulation.block_count(); ++b) {
    const auto of_block = block_mesh(simulation, b).gridpoint;
    std::map<std::array<long long, 3>, std::size_t> then;
    for (std::size_t i = 0; i < of_block.size(); ++i) then.emplace(key(places[numbers.size() + i]), numbers.size() + i);
    for (const Vec3& x : of_block) numbers.push_back(then.at(key(x)));
  }
  return numbers;
}

}  // namespace

Session::Session(Scene scene, int threads, bool keep_frames, const std::string& folder, bool isolate_law,
                 double law_seconds)
    : keep_frames_(keep_frames), folder_(folder) {
  const py::gil_scoped_release release;
  const int wanted = threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency());
  if (isolate_law) isolation_ = {std::max(1, wanted), law_seconds};
  const Isolated isolated(isolation_);
  if (!folder.empty()) keep_start(scene, folder_);
  std::optional<LawWatchdog> of_set_up;
  if (!isolate_law) of_set_up.emplace(law_seconds, end_program(law_seconds, "law_seconds"));
  simulation_ = std::make_unique<Simulation>(std::move(scene), threads);
  take_start(simulation_.get());
  files_ = input_files(simulation_->scene());
  for (const HashedFile& law : law_files(simulation_->scene())) files_.push_back(law);
  provenance_ = provenance_of(*simulation_, {});
  columns_ = history_columns(simulation_->scene(), restraints_of(*simulation_));
  if (keep_frames || !folder.empty()) surfaces_ = std::make_unique<Surfaces>();
  if (!folder.empty()) {
    own_ = std::make_unique<ResultFolder>(folder_);
    begin_files({}, {});
    if (simulation_->scene().has_frames() && simulation_->scene().output.pieces) {
      const py::gil_scoped_acquire lock;
      if (PyErr_WarnEx(PyExc_UserWarning,
                       "output.pieces: without effect in one process, which writes each frame as one file", 1) != 0)
        throw py::error_already_set();
    }
  }
  if (isolate_law) return;
  of_set_up.reset();
  watchdog_.emplace(law_seconds, [this, law_seconds](const Material& material, const quoin_batch& batch) {
    const auto& families = simulation_->model().families;
    const auto is_it = [&](const ContactFamily& f) { return f.material.get() == &material; };
    if (std::any_of(families.begin(), families.end(), is_it)) end_with_law(material, batch, law_seconds);
  });
}

void Session::begin_files(const std::vector<std::vector<double>>& monitor_rows, std::vector<double> frame_times) {
  if (!own_) return;
  summary_.clear();
  file_.emplace(folder_ / "history.csv", *simulation_, rows_);
  if (!simulation_->scene().monitors.empty()) monitors_.emplace(folder_, *simulation_, monitor_rows);
  if (simulation_->scene().has_frames()) series_.emplace(folder_, *surfaces_, std::move(frame_times));
}

// Called by the watching thread, without the interpreter's lock, while another thread never returns from the law.
void Session::end_with_law(const Material& material, const quoin_batch& batch, double seconds) {
  RunInfo info;
  info.status = "failed";
  info.law_answers = false;
  info.message = overdue_text(*simulation_, material, batch, seconds) +
                 "law_seconds; with isolate_law=True it would be raised as an exception";
  fmt::print(stderr, "quoin: {}\n", info.message);
  try {
    if (file_) {
      file_->finish();
      info.wall_clock_s = seconds_since(start_);
      write_summary(folder_ / "summary.json", *simulation_, rows_, info);
      fmt::print(stderr, "quoin: what was computed is kept in {}\n", folder_.string());
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "quoin: {}\n", error.what());
  }
  _exit(static_cast<int>(Exit::numerical));
}

Simulation& Session::use() const {
  if (stepping_) throw std::runtime_error("the simulation is being stepped by another thread; wait for it");
  return *simulation_;
}

bool Session::step(long count, bool stop_at_stage_end) {
  const bool more = advance(count, stop_at_stage_end);
  if (!more && file_)
    finish("done", "");
  else if (!more)
    info_of("done", "");
  tell_warnings();
  return more;
}

void Session::warn(const Warning& warning) {
  if (reported_.insert(warning.about).second) warnings_.push_back(warning.text);
}

void Session::tell_warnings() {
  for (const std::string& text : std::exchange(warnings_, {})) {
    if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  }
}

bool Session::advance(long count, bool stop_at_stage_end) {
  Simulation& simulation = use();
  stepping_ = true;
  struct Done {
    bool& stepping;
    ~Done() { stepping = false; }  // with the interpreter's lock, which has been taken again
  } const done{stepping_};
  bool more = true;
  const py::gil_scoped_release release;
  const Isolated isolated(isolation_);
  const long end = simulation.step() + std::min(count, std::numeric_limits<long>::max() - simulation.step());
  while (more && simulation.step() < end) {
    more = simulation.run_stage(*this, end - simulation.step());
    if (stop_at_stage_end && simulation.step() < end) break;
  }
  return more;
}

void Session::on_stage_begin([[maybe_unused]] const Simulation& simulation, [[maybe_unused]] int stage) {
#ifdef QUOIN_MODES
  const bool shakes = simulation.scene().stages[static_cast<std::size_t>(stage)].ground.has_value();
  if (shakes && (modes_.empty() || modes_.back().stage != stage)) modes_.push_back(damped_modes(simulation, stage));
#endif
}

void Session::on_promotion(const Simulation&) {
  if (surfaces_) *surfaces_ = Surfaces();
}

void Session::on_row(const HistoryRow& row) {
  rows_.push_back(row);
  if (file_) file_->add(row);
  if (monitors_) monitors_->add(row);
}

void Session::on_pause(const Simulation&, bool) {
  if (seconds_since(looked_) < kLookPeriod) return;
  looked_ = std::chrono::steady_clock::now();
  const py::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void Session::on_progress(const Progress& progress) {
  const py::gil_scoped_acquire acquire;
  if (!progress_.is_none()) progress_(progress.stage, progress.stage_count, progress.settings->name, progress.fraction);
}

void Session::on_frame(const Simulation& simulation, int, int) {
  if (series_) series_->add_frame(simulation);
  if (!keep_frames_) return;
  auto places = std::make_shared<const std::vector<Vec3>>(gridpoints_of(simulation));
  if (!frames_.empty() && *frames_.back().place == *places) places = frames_.back().place;
  Frame& frame = frames_.emplace_back();
  frame.time = simulation.time();
  frame.place = std::move(places);
  for (int b = 0; b < simulation.block_count(); ++b) {
    const std::vector<Vec3> moved = block_displacement(simulation, b);
    frame.displacement.insert(frame.displacement.end(), moved.begin(), moved.end());
  }
  frame.joints = surfaces_->joint_points(simulation);
  for (const PartedPoint& p : parted_points(simulation)) frame.joints.push_back(p.joint);
}

py::dict Session::history() const {
  const std::vector<Stage>& stages = use().scene().stages;
  py::dict result;
  for (const HistoryColumn& column : columns_) {
    const auto stage_of = [&](const HistoryRow& row) -> const Stage& {
      return stages[static_cast<std::size_t>(row.stage)];
    };
    const py::str name(column.name);
    if (column.kind == HistoryColumn::Kind::text) {
      py::list texts;
      for (const HistoryRow& row : rows_) texts.append(stage_of(row).name);
      result[name] = texts;
    } else if (column.kind == HistoryColumn::Kind::integer) {
      result[name] =
          column_of<std::int64_t>(rows_, [&](const HistoryRow& row) { return column.value(row, stage_of(row)); });
    } else {
      result[name] = column_of<double>(rows_, [&](const HistoryRow& row) {
        const double value = column.value(row, stage_of(row));
        return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
      });
    }
  }
  return result;
}

py::dict Session::measure() const {
  const Simulation& simulation = use();
  py::dict result;
  const HistoryRow row = simulation.measure();
  const Stage& stage = simulation.scene().stages[static_cast<std::size_t>(row.stage)];
  for (const HistoryColumn& column : columns_) {
    const py::str name(column.name);
    if (column.kind == HistoryColumn::Kind::text)
      result[name] = stage.name;
    else if (column.kind == HistoryColumn::Kind::integer)
      result[name] = static_cast<long>(column.value(row, stage));
    else
      result[name] = column.value(row, stage);
  }
  return result;
}

// Warns also of what only a whole run shows.
RunInfo Session::info_of(const std::string& status, const std::string& message) {
  const Simulation& simulation = use();
  RunInfo info;
  info.status = status;
  info.message = message;
  info.quasi_static = check_quasi_static(rows_, simulation.scene());
  info.law_answers = laws_answer(simulation);
  if (info.law_answers) info.crushed_out = find_crushed_out(simulation);
  info.warnings = warnings_of(simulation, info.quasi_static, info.crushed_out);
  std::ranges::for_each(info.warnings, [this](const Warning& warning) { warn(warning); });
  info.wall_clock_s = seconds_since(start_);
  info.modes = modes_;
  return info;
}

std::string Session::finish(const std::string& status, const std::string& message) {
  const Simulation& simulation = use();
  if (!summary_.empty()) return summary_;
  RunInfo info = info_of(status, message);
  info.provenance = provenance_;
  if (!file_) return summary_text(simulation, rows_, info);
  file_->finish();
  if (monitors_) monitors_->finish();
  if (series_ && status != "done" && info.law_answers) series_->add_frame(simulation);
  if (series_) series_->finish();
  note_results(simulation, folder_, &info.provenance);
  if (status == "done" && simulation.scene().output.end_state) write_end_state(folder_, simulation, info.provenance);
  const std::string summary = summary_text(simulation, rows_, info);
  write_file(folder_ / "summary.json", summary);
  return summary_ = summary;
}

void Session::close(const std::string& failure) {
  const Simulation& simulation = use();
  if (!file_) return;
  const std::string left = fmt::format("left at step {}, before the end of its last stage", simulation.step());
  finish(failure.empty() ? "interrupted" : "failed", failure.empty() ? left : failure);
  tell_warnings();
}

py::list Session::frames() const {
  const Simulation& simulation = use();
  py::list result;
  std::vector<std::size_t> number;
  for (const Frame& frame : frames_) {
    if (&frame == frames_.data() || frame.place != (&frame - 1)->place)
      number = numbers_among(*frame.place, simulation);
    py::dict d = joints_of(frame.joints);
    py::dict of_frame;
    of_frame["time"] = frame.time;
    of_frame["displacement"] = vectors_of(number, [&](std::size_t i) { return frame.displacement[i]; });
    of_frame["joints"] = d;
    result.append(of_frame);
  }
  return result;
}

py::dict Session::mesh() const {
  const Simulation& simulation = use();
  std::vector<Vec3> points;
  std::vector<std::array<int, 4>> zones;
  std::vector<int> block;  // by gridpoint
  py::list faces;
  for (int b = 0; b < simulation.block_count(); ++b) {
    const BlockMesh mesh = block_mesh(simulation, b);
    const int first = static_cast<int>(points.size());
    points.insert(points.end(), mesh.gridpoint.begin(), mesh.gridpoint.end());
    block.insert(block.end(), mesh.gridpoint.size(), b);
    for (std::array<int, 4> zone : mesh.zone) {
      for (int& corner : zone) corner += first;
      zones.push_back(zone);
    }
    for (std::vector<int> face : mesh.face) {
      for (int& corner : face) corner += first;
      faces.append(face);
    }
  }
  py::dict d;
  d["points"] = vectors_of(points, [](const Vec3& p) { return p; });
  d["zones"] = table_of<std::int32_t>(zones.size(), 4, [&](std::size_t r, std::size_t c) { return zones[r][c]; });
  d["block"] = column_of<std::int32_t>(block, [](int b) { return b; });
  d["faces"] = faces;
  return d;
}

std::pair<std::size_t, std::size_t> Session::points_of(int family) const {
  std::size_t first = 0;
  for (int f = 0; f < family; ++f) first += view(*simulation_, PointArray::area, f).rows;
  return {first, first + view(*simulation_, PointArray::area, family).rows};
}

py::dict Session::contacts(int family) const {
  use();
  const auto [first, end] = points_of(family);
  const std::vector<ContactPoint> points =
      contact_points(*simulation_, {static_cast<std::int32_t>(first), static_cast<std::int32_t>(end)});
  py::dict d;
  d["position"] = vectors_of(points, [](const ContactPoint& p) { return p.position; });
  d["normal"] = vectors_of(points, [](const ContactPoint& p) { return p.normal; });
  d["s"] = vectors_of(points, [](const ContactPoint& p) { return p.s; });
  d["t"] = vectors_of(points, [](const ContactPoint& p) { return p.t; });
  d["area"] = column_of<double>(points, [](const ContactPoint& p) { return p.area; });
  d["jump"] = vectors_of(points, [](const ContactPoint& p) { return p.jump; });
  d["block_a"] = column_of<std::int32_t>(points, [](const ContactPoint& p) { return p.block_a; });
  d["block_b"] = column_of<std::int32_t>(points, [](const ContactPoint& p) { return p.block_b; });
  d["condition"] = py::list();
  for (const ContactPoint& p : points) d["condition"].cast<py::list>().append(condition_name(p.condition));
  return d;
}

std::array<py::array, 3> Session::damage(int family) const {
  use();
  const auto [first, end] = points_of(family);
  const auto all = damage_of_points(*simulation_);
  std::array<py::array, 3> result;
  for (std::size_t k = 0; k < result.size(); ++k) {
    const std::vector<double> part(all[k].begin() + static_cast<long>(first), all[k].begin() + static_cast<long>(end));
    result[k] = column_of<double>(part, [](double x) { return x; });
  }
  return result;
}

py::array Session::array_of(const ArrayView& view, bool writeable) const {
  constexpr auto kSize = static_cast<py::ssize_t>(sizeof(double));
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(view.rows)}, strides{view.row_stride * kSize};
  if (view.columns > 1)
    shape.push_back(static_cast<py::ssize_t>(view.columns)), strides.push_back(view.column_stride * kSize);
  // A base object keeps NumPy from copying. The package returns no such array from a call (view.py).
  py::array_t<double> array(shape, strides, view.data, py::capsule(this, [](void*) {}));
  if (!writeable) array.attr("flags").attr("writeable") = false;
  return array;
}

py::array Session::block_array(BlockArray what, int block) {
  const ArrayView lies = view(use(), what, block);
  if (lies.data) return array_of(lies, what == BlockArray::velocity);
  const std::vector<Vec3> moved = block_displacement(*simulation_, block);
  return vectors_of(moved, [](const Vec3& u) { return u; });
}

py::array Session::point_array(PointArray what, int family) {
  const ArrayView lies = view(use(), what, family);
  if (lies.data) return array_of(lies, false);
  if (what != PointArray::position) return py::array_t<double>(0);
  const auto [first, end] = points_of(family);
  return vectors_of(contact_points(*simulation_, {static_cast<std::int32_t>(first), static_cast<std::int32_t>(end)}),
                    [](const ContactPoint& p) { return p.position; });
}

py::array Session::state(int family, const std::string& id) { return array_of(view_state(use(), family, id), false); }

int Session::block_named(const py::object& block) const {
  const Simulation& simulation = use();
  const auto count = static_cast<int>(simulation.block_count());
  if (py::isinstance<py::str>(block)) {
    const auto name = block.cast<std::string>();
    // On the lattice, only bodies of stages have their names.
    std::optional<blocks::Assembly> as_read;
    if (!simulation.large_motion() && simulation.scene().blocks) as_read = blocks::assemble(simulation.scene());
    std::vector<std::string> names;
    std::vector<int> found;
    for (int b = 0; b < count; ++b) {
      const auto i = static_cast<std::size_t>(b);
      const std::string& is = simulation.large_motion() ? simulation.large_motion()->assembly.blocks[i].name
                              : as_read                 ? as_read->blocks[i].name
                                                        : simulation.assembly().bricks[i].body;
      if (is == name) found.push_back(b);
      names.push_back(is);
    }
    if (found.size() == 1) return found.front();
    if (!found.empty())
      throw py::key_error(fmt::format("block: {} blocks are called '{}': give the number of one: {}", found.size(),
                                      name, fmt::join(found, ", ")));
    throw py::key_error(fmt::format("block: nothing is called '{}'{}; give a number from 0 to {}", name,
                                    did_you_mean(name, names), count - 1));
  }
  if (!py::isinstance<py::int_>(block) || py::isinstance<py::bool_>(block))
    throw py::type_error("block: a number or a name is needed");
  int overflow = 0;
  const long index = PyLong_AsLongAndOverflow(block.ptr(), &overflow);
  if (overflow != 0 || index < 0 || index >= count)
    throw py::index_error(fmt::format("block: {} is not among the {} blocks, 0 to {}",
                                      py::str(block).cast<std::string>(), count, count - 1));
  return static_cast<int>(index);
}

int Session::family_named(const std::string& name) const {
  std::vector<std::string> names;
  for (const ContactFamily& family : use().model().families) {
    if (family.name == name) return static_cast<int>(names.size());
    names.push_back(family.name);
  }
  throw py::key_error(fmt::format("joint: there is no joint family '{}'; there are {}", name, fmt::join(names, ", ")));
}

LawSwap Session::swap_law(const std::string& joint, const std::string& law) {
  const Isolated isolated(isolation_);
  return exchange_law(use(), joint, law);
}

Checkpoint Session::now() const {
  const Simulation& simulation = use();  // before rows, which a thread that steps would change
  Checkpoint checkpoint{{rows_, {}, modes_}, simulation.save()};
  if (monitors_) checkpoint.results.monitor_rows = monitors_->rows();
  return checkpoint;
}

// frame_times: of frames that are kept in the folder.
void Session::go_back(const Checkpoint& to, std::vector<double> frame_times) {
  const Isolated isolated(isolation_);
  const std::size_t stages = use().scene().stages.size(), added = simulation_->measure().added.size();
  const auto is_stage = [&](int stage) { return stage >= 0 && static_cast<std::size_t>(stage) < stages; };
  if (!std::ranges::all_of(to.results.rows,
                           [&](const HistoryRow& row) { return is_stage(row.stage) && row.added.size() == added; }) ||
      !std::ranges::all_of(to.results.modes, is_stage, &StageModes::stage))
    throw Error(Exit::bad_input, "checkpoint: its rows are of another model");
  simulation_->restore(to.state);
  rows_ = to.results.rows;
  modes_ = to.results.modes;
  reported_.clear();
  if (surfaces_) *surfaces_ = Surfaces();
  std::erase_if(frame_times, [&](double time) { return time > simulation_->time(); });
  begin_files(to.results.monitor_rows, std::move(frame_times));
}

py::bytes Session::save(const SceneHashes& scene) const {
  const std::vector<std::uint8_t> bytes = checkpoint_bytes(identity_of(scene), now());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void Session::restore(const py::bytes& bytes, const SceneHashes& scene) {
  const std::string_view view = bytes;
  use();
  go_back(checkpoint_of({reinterpret_cast<const std::uint8_t*>(view.data()), view.size()}, identity_of(scene)),
          series_ ? series_->times() : std::vector<double>());
}

Identity Session::identity_of(const SceneHashes& scene) const {
  Identity identity{{{"version of quoin", QUOIN_VERSION}}};
  for (const auto& [key, hash] : scene)
    identity.parts.push_back({fmt::format("value of '{}' in the scene", key), hash});
  for (const HashedFile& file : files_)
    identity.parts.push_back({"file " + std::filesystem::path(file.name).filename().string(), file.sha256});
  return identity;
}

void Session::checkpoint(const std::string& path, const SceneHashes& scene) const {
  write_checkpoint(path, identity_of(scene), now());
}

void Session::resume(const std::string& path, const SceneHashes& scene) {
  go_back(read_checkpoint(path, identity_of(scene)), {});
}

}  // namespace quoin::python
