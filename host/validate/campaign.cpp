#include "validate/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "reproduce/run_cache.h"

namespace quoin::validate {

namespace {

std::string csv_cell(const std::string& text) {
  return text.find_first_of(",\"\n") == std::string::npos ? text : csv_text(text);
}

}  // namespace

Statistics statistics_of(const std::vector<double>& ratios) {
  Statistics s;
  s.count = ratios.size();
  if (ratios.empty()) return s;
  for (const double r : ratios) s.mean += r / static_cast<double>(ratios.size());
  std::vector<double> sorted = ratios;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t half = sorted.size() / 2;
  s.median = sorted.size() % 2 == 1 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
  if (ratios.size() < 2) return s;
  double squares = 0.0;
  for (const double r : ratios) squares += (r - s.mean) * (r - s.mean);
  s.variation = std::sqrt(squares / static_cast<double>(ratios.size() - 1)) / s.mean;
  return s;
}

Campaign run_campaign(const WallTable& table, const CampaignSettings& settings) {
  Campaign campaign;
  campaign.faults = table.faults;
  reproduce::CacheSettings cache_settings;
  cache_settings.root = settings.out;
  cache_settings.scenes = settings.out / "scenes";
  cache_settings.overrides = settings.overrides;
  cache_settings.jobs = settings.jobs;
  make_folder(cache_settings.scenes);
  reproduce::RunCache cache(cache_settings);
  std::vector<Prediction> walls;
  std::vector<reproduce::RunSpec> specs;
  for (const WallRow& row : table.rows) {
    Prediction& wall = walls.emplace_back();
    wall.row = row;
    try {
      wall.scene = scene_of(row, settings.cyclic);
    } catch (const Error& error) {
      campaign.faults.push_back(fmt::format("line {}: {}", row.line, error.what()));
      walls.pop_back();
      continue;
    }
    const std::string name = row.folder_name() + (settings.cyclic ? "_cyclic" : "");
    write_file(cache_settings.scenes / (name + ".toml"), wall.scene.text);
    specs.push_back({row.name(), name, {"output.frames=1"}, "", wall.scene.half_units * row.height});
  }
  cache.compute(specs);
  for (std::size_t i = 0; i < walls.size(); ++i) {
    reproduce::RunResult run = cache.result(specs[i]);
    if (!run.complete || run.curve.empty()) {
      campaign.faults.push_back(fmt::format("number {} ({}): the run did not end: {}", walls[i].row.number,
                                            walls[i].row.name(), run.message));
      continue;
    }
    walls[i].outcome = outcome_of(walls[i].row, walls[i].scene, std::move(run));
    campaign.done.push_back(std::move(walls[i]));
  }
  return campaign;
}

std::string validation_csv(const Campaign& campaign) {
  std::string csv = "number,campaign,specimen,predicted_peak_kN,measured_peak_kN,ratio,predicted_mode,measured_mode\n";
  for (const Prediction& p : campaign.done)
    csv += fmt::format("{},{},{},{:.6g},{:.6g},{:.6g},{},{}\n", csv_cell(p.row.number), csv_cell(p.row.campaign),
                       csv_cell(p.row.specimen), p.outcome.peak, p.row.peak(), p.ratio(), p.outcome.mode,
                       csv_cell(p.row.failure_mode));
  return csv;
}

}  // namespace quoin::validate
