// What the settings of a stage make doubtful, before it has run: for `check` and for the watch of a run.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

struct StageWarning {
  const char* about;  // key of the warning in summary.json; a run gives each key once
  std::string text;
};
// Whether a stage drives nothing, and its duration alone ends it: a static load, or free motion.
bool ends_by_duration(const Stage& stage);
std::vector<StageWarning> stage_warnings(const Scene& scene, std::size_t stage);

}  // namespace quoin
