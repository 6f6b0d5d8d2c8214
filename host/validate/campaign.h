// A campaign: all walls of a table, predicted and compared with what was measured.
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
  int samples = 0;                     // samples of each banded wall, with properties that scatter
  std::vector<std::string> overrides;  // laid over every scene; for trials
};

struct Prediction {
  WallRow row;
  TestScene scene;
  Outcome outcome;
  double ratio() const { return outcome.peak / row.peak(); }
  bool mode_known() const { return !row.failure_mode.empty(); }
  bool mode_met() const { return leading_mode(outcome.mode) == leading_mode(row.failure_mode); }
  // Measured over what a rigid wall without tension can carry: more than 15 % above it and no model without tension or
  // another boundary meets the test.
  double beyond_equilibrium() const { return row.peak() / rocking_force_with_weight(row); }
  bool within_equilibrium() const { return beyond_equilibrium() <= 1.15; }
};

// Peaks of a wall whose properties scatter by what the rule says of each.
struct Band {
  WallRow row;
  std::vector<double> peaks;  // kN, ascending
  // With this part of the peaks below it, between those that are there; of one peak at least.
  double quantile(double part) const;
};

// Lognormal, of mean 1, by wall, sample and name.
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
  std::vector<std::string> faults;  // rows left out, and runs that did not end
};

// Scenes go to OUT/scenes, runs to OUT/runs. What is done is not computed again.
Campaign run_campaign(const WallTable& table, const CampaignSettings& settings);

std::string validation_csv(const Campaign& campaign);
std::string bands_csv(const Campaign& campaign);

}  // namespace quoin::validate
