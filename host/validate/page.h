// Page of a campaign: OUT/index.html.
#pragma once

#include <string>

#include "validate/campaign.h"

namespace quoin::validate {

std::string page_of(const Campaign& campaign, const CampaignSettings& settings);

// "mean 1.02, median 1.00, coefficient of variation 0.17 (15 walls)".
std::string statistics_text(const Statistics& statistics);
std::vector<double> ratios_of(const Campaign& campaign, bool within_equilibrium_only);
// Number of walls whose leading mode is predicted, and of those with a measured mode.
std::pair<int, int> modes_met(const Campaign& campaign);

}  // namespace quoin::validate
