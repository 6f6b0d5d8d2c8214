#include "analysis/collapse_start.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "files/notice.h"

#ifdef QUOIN_LIMIT
#include "analysis/limit_of_scene.h"
#include "step/simulation.h"
#endif

namespace quoin {
namespace {

#ifdef QUOIN_LIMIT

// Start over the multiplier without dilation: runs of 27 dry assemblies lie within 4 % of that multiplier.
constexpr double kOfSettled = 0.9;
// Start over the associated multiplier, where the other did not converge. Runs in which stones must lift to slide lie
// below that multiplier: a dome by a sixth. A bonded wall that cannot dilate lies below it by more than half. Its start
// is then too high, which the run reports.
constexpr double kOfAssociated = 0.5;
// Largest model for the analysis without dilation, in contact points: it takes a minute.
constexpr long kMostPoints = 12000;
// End of the stage over the associated multiplier; no brittle joint exceeds it before blocks have moved.
constexpr double kGivesUp = 1.2;

void find_start(const Simulation& simulation, Stage* stage) {
  Collapse& c = *stage->collapse;
  LimitOptions options;
  options.direction.assign(c.direction.begin(), c.direction.end());
  options.stage = stage;
  options.associated = simulation.point_count() > kMostPoints, options.friction = false;
  const SceneLimit limit = limit_of(simulation, options);
  if (!limit.stands.stands)
    throw Error(Exit::numerical, fmt::format("the masonry does not stand under its weight; out of balance:{}",
                                             blocks_text(limit, limit.stands.out_of_balance)));
  const double associated = limit.limit->multiplier;
  const bool settled = limit.without_dilation && limit.without_dilation->settled;
  const double multiplier = settled ? std::min(associated, limit.without_dilation->multiplier) : associated;
  c.start = (settled ? kOfSettled : kOfAssociated) * multiplier;
  if (!c.limit) c.limit = kGivesUp * associated;
  notice(fmt::format("quoin: stage '{}': collapse.start = {:.4g}, {:g} of the multiplier {:.4g} of limit analysis, {}",
                     stage->name, *c.start, settled ? kOfSettled : kOfAssociated, multiplier,
                     settled ? "without dilation" : "associated"));
  if (!(*c.limit > *c.start))
    throw Error(
        Exit::bad_input,
        fmt::format("limit = {:g} is no more than the start {:.4g}; give a larger one, or none", *c.limit, *c.start));
}

#endif

}  // namespace

void find_collapse_starts(Scene* scene) {
  const auto asks = [](const Stage& s) { return s.collapse && !s.collapse->start; };
  if (std::none_of(scene->stages.begin(), scene->stages.end(), asks)) return;
#ifdef QUOIN_LIMIT
  const Simulation simulation(*scene, 1);
#endif
  for (Stage& stage : scene->stages) {
    if (!asks(stage)) continue;
#ifdef QUOIN_LIMIT
    try {
      find_start(simulation, &stage);
    } catch (const Error& error) {
      throw Error(error.exit_code,
                  fmt::format("{}: collapse.start = \"limit\": {}\n  Or give start as a number, times the weight",
                              stage.source.text, error.what()));
    }
#else
    throw Error(Exit::bad_input,
                fmt::format("{}: collapse.start = \"limit\": this program has no limit analysis; build it with "
                            "coinor-libclp-dev, or give start as a number, times the weight",
                            stage.source.text));
#endif
  }
}

}  // namespace quoin
