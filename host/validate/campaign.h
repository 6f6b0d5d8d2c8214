// A campaign: predictions of all walls of a table, compared with the measurements.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "validate/outcome.h"

namespace quoin::validate {

struct CampaignSettings {
  std::filesystem::path out;
  bool cyclic = false;
  int jobs = 1;
  int samples = 0;                     // number of samples of each banded wall, with random properties
  std::vector<std::string> overrides;  // overrides of every scene, for trials
};

struct Prediction {
  WallRow row;
  TestScene scene;
  Outcome outcome;
  double ratio() const { return outcome.peak / row.peak(); }
  bool mode_known() const { return !row.failure_mode.empty(); }
  bool mode_met() const { return leading_mode(outcome.mode) == leading_mode(row.failure_mode); }
  // Measured peak over that of a rigid wall without tension. Above 1.15 no model without tension or another boundary
  // condition reaches the measured peak.
  double beyond_equilibrium() const { return row.peak() / rocking_force_with_weight(row); }
  bool within_equilibrium() const { return beyond_equilibrium() <= 1.15; }
};

// Peaks of a wall with random properties, whose scatter follows from the rule of each.
struct Band {
  WallRow row;
  std::vector<double> peaks;  // kN, ascending
  // Quantile at probability `part`, interpolated between peaks; requires at least one peak.
  double quantile(double part) const;
};

// Lognormal factor of mean 1, a function of wall, sample and name.
ScatterFactor lognormal_factor(const WallRow& row, int sample);

struct Statistics {
  std::size_t count = 0;
  // Statistics of ratios; variation: standard deviation over mean, n - 1.
  double mean = 0.0, median = 0.0, variation = 0.0;
};
Statistics statistics_of(const std::vector<double>& ratios);

struct Campaign {
  std::vector<Prediction> done;
  std::vector<Band> bands;
  std::vector<std::string> faults;  // rows left out, and runs that failed
};

// Computes all walls. Scenes are in OUT/scenes, runs in OUT/runs. Finished runs are not repeated.
Campaign run_campaign(const WallTable& table, const CampaignSettings& settings);

std::string validation_csv(const Campaign& campaign);
std::string bands_csv(const Campaign& campaign);

}  // namespace quoin::validate
