#include "validate/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "random/counter.h"
#include "reproduce/run_cache.h"

namespace quoin::validate {

namespace {

std::string csv_cell(const std::string& text) {
  return text.find_first_of(",\"\n") == std::string::npos ? text : csv_text(text);
}

// Walls with random samples. Of brick_walls.csv: one with diagonal cracks, one of thick mortar, a slender one. Of other
// tables: the first ones.
std::vector<const WallRow*> banded_walls(const std::vector<Prediction>& walls) {
  constexpr std::size_t kWalls = 3;
  std::vector<const WallRow*> banded;
  for (const char* number : {"2", "25", "33"}) {
    const auto found =
        std::find_if(walls.begin(), walls.end(), [&](const Prediction& w) { return w.row.number == number; });
    if (found != walls.end()) banded.push_back(&found->row);
  }
  if (banded.size() == kWalls) return banded;
  banded.clear();
  for (const Prediction& wall : walls) {
    if (banded.size() < kWalls) banded.push_back(&wall.row);
  }
  return banded;
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

double Band::quantile(double part) const {
  const double at = part * static_cast<double>(peaks.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, peaks.size() - 1);
  return peaks[below] + (at - static_cast<double>(below)) * (peaks[above] - peaks[below]);
}

ScatterFactor lognormal_factor(const WallRow& row, int sample) {
  return [wall = random::name_of(row.folder_name()), sample](const std::string& name, double spread) {
    const double of_log = std::sqrt(std::log1p(spread * spread));
    const random::Quantity quantity{1, static_cast<std::uint64_t>(sample), random::name_of(name)};
    return std::exp(of_log * random::normal(quantity, wall) - of_log * of_log / 2);
  };
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
  const std::vector<const WallRow*> banded = settings.samples > 0 ? banded_walls(walls) : std::vector<const WallRow*>{};
  std::vector<reproduce::RunSpec> of_samples;
  for (const WallRow* row : banded) {
    for (int sample = 1; sample <= settings.samples; ++sample) {
      const TestScene scene = scene_of(*row, settings.cyclic, lognormal_factor(*row, sample));
      const std::string name =
          fmt::format("{}{}_sample_{}", row->folder_name(), settings.cyclic ? "_cyclic" : "", sample);
      write_file(cache_settings.scenes / (name + ".toml"), scene.text);
      of_samples.push_back({fmt::format("{}, sample {}", row->name(), sample),
                            name,
                            {"output.frames=0", "output.plots=false"},
                            "",
                            scene.half_units * row->height,
                            true});
    }
  }
  std::vector<reproduce::RunSpec> all = specs;
  all.insert(all.end(), of_samples.begin(), of_samples.end());
  cache.compute(all);
  for (std::size_t k = 0; k < banded.size(); ++k) {
    Band& band = campaign.bands.emplace_back();
    band.row = *banded[k];
    for (int sample = 0; sample < settings.samples; ++sample) {
      const reproduce::RunSpec& spec =
          of_samples[k * static_cast<std::size_t>(settings.samples) + static_cast<std::size_t>(sample)];
      const reproduce::RunResult run = cache.result(spec);
      if (run.complete && !run.curve.empty())
        band.peaks.push_back(peak_of(run));
      else
        campaign.faults.push_back(fmt::format("{}: the run did not end: {}", spec.name, run.message));
    }
    std::sort(band.peaks.begin(), band.peaks.end());
    if (band.peaks.empty()) campaign.bands.pop_back();
  }
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

std::string bands_csv(const Campaign& campaign) {
  std::string csv = "number,campaign,specimen,samples,peak_p16_kN,peak_median_kN,peak_p84_kN,measured_peak_kN\n";
  for (const Band& b : campaign.bands)
    csv += fmt::format("{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g}\n", csv_cell(b.row.number), csv_cell(b.row.campaign),
                       csv_cell(b.row.specimen), b.peaks.size(), b.quantile(0.16), b.quantile(0.5), b.quantile(0.84),
                       b.row.peak());
  return csv;
}

}  // namespace quoin::validate
