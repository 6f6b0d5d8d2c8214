#include "cli/live_run.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "results/summary.h"
#include "step/findings.h"

namespace quoin {

namespace {

using Json = nlohmann::ordered_json;

// Columns of the history by name, in the format of the page.
std::string history_text(const std::vector<HistoryColumn>& columns, const std::vector<HistoryRow>& rows,
                         const Scene& scene) {
  Json history = Json::object();
  for (const HistoryColumn& column : columns) {
    Json& values = history[column.name] = Json::array();
    for (const HistoryRow& row : rows) {
      const Stage& stage = scene.stages[static_cast<std::size_t>(row.stage)];
      values.push_back(column.kind == HistoryColumn::Kind::text ? Json(stage.name) : Json(column.value(row, stage)));
    }
  }
  return history.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

LiveRun::LiveRun(std::unique_ptr<PageServer> server, const std::filesystem::path& folder, const Simulation& simulation,
                 const std::vector<HistoryRow>& before, std::vector<double> frame_times)
    : scene_(simulation.scene()),
      columns_(history_columns(scene_, restraints_of(simulation))),
      rows_(before),
      times_(std::move(frame_times)),
      state_("{}"),
      growing_(folder),
      server_(std::move(server)) {
  const std::string page = live_page_text(scene_.title.empty() ? folder.filename().string() : scene_.title);
  if (!times_.empty()) add_frame(simulation, rows_), times_.pop_back();
  server_->start({{"/",
                   [page] {
                     return PageAnswer{"text/html", page};
                   }},
                  {"/state", [this] { return state(); }},
                  {"/run", [this] { return run(); }}});
}

std::string LiveRun::address() const { return fmt::format("http://127.0.0.1:{}/", server_->port()); }

void LiveRun::add_row(const HistoryRow& row) {
  const std::lock_guard lock(mutex_);
  rows_.push_back(row);
}

void LiveRun::add_frame(const Simulation& simulation, const std::vector<HistoryRow>& rows) {
  RunInfo info;
  info.status = "running";
  info.message = "the run goes on";
  info.law_answers = laws_answer(simulation);
  std::string summary = summary_text(simulation, rows, info);
  const std::lock_guard lock(mutex_);
  summary_ = std::move(summary);
  times_.push_back(simulation.time());
}

void LiveRun::show(const Progress& p, const RunSoFar& so_far) {
  const Json state = {{"stage", p.stage + 1},
                      {"stages", p.stage_count},
                      {"name", p.settings ? p.settings->name : ""},
                      {"fraction", p.fraction},
                      {"seconds_left", p.seconds_left},
                      {"unbalanced_ratio", p.unbalanced_ratio},
                      {"steps_per_second", p.steps_per_second},
                      {"displacement_m", so_far.displacement},
                      {"force_N", so_far.force},
                      {"peak_N", so_far.peak},
                      {"displacement_at_peak_m", so_far.displacement_at_peak},
                      {"cracked", so_far.cracked},
                      {"kinetic_energy_J", so_far.kinetic_energy}};
  const std::lock_guard lock(mutex_);
  state_ = state.dump(-1, ' ', false, Json::error_handler_t::replace);
}

PageAnswer LiveRun::state() {
  const std::lock_guard lock(mutex_);
  Json state = Json::parse(state_);
  state["frames"] = times_.size(), state["rows"] = rows_.size();
  return {"application/json", state.dump()};
}

// Reads files of frames without the lock, so that the run continues meanwhile.
PageAnswer LiveRun::run() {
  std::unique_lock lock(mutex_);
  if (times_.empty()) throw Error(Exit::bad_input, "no frame yet");
  const std::vector<HistoryRow> rows = rows_;
  const std::vector<double> times = times_;
  const std::string summary = summary_;
  lock.unlock();
  return {"application/json", growing_.part(summary, history_text(columns_, rows, scene_), times)};
}

}  // namespace quoin
