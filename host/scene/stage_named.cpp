#include "scene/stage_named.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "base/did_you_mean.h"
#include "base/error.h"

namespace quoin {

int stage_named(const Scene& scene, const std::string& name) {
  if (name.empty()) return 0;
  std::vector<std::string> names;
  for (const Stage& stage : scene.stages) names.push_back(stage.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw Error(Exit::bad_input, fmt::format("{}: stage '{}': no such stage{}; the scene has: {}", scene.file, name,
                                             did_you_mean(name, names), fmt::join(names, ", ")));
  return static_cast<int>(found - names.begin());
}

}  // namespace quoin
