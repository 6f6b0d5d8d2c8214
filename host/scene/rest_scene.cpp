#include "scene/rest_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/did_you_mean.h"
#include "base/error.h"
#include "scene/generate.h"

namespace quoin {
namespace {

bool has_load(const Stage& s) {
  const auto pushes = [](const BodyControl& c) {
    for (std::size_t i = 0; i < 3; ++i)
      if (c.kind[i] != DofKind::velocity && c.force[i] != 0.0) return true;
    return false;
  };
  return s.gravity != Vec3{} || !s.forces.empty() || !s.pressures.empty() ||
         std::any_of(s.controls.begin(), s.controls.end(), pushes);
}

}  // namespace

Scene at_rest(Scene scene, const std::string& name) {
  std::vector<Stage>& stages = scene.stages;
  const auto wanted = [&](const Stage& s) { return name.empty() ? has_load(s) : s.name == name; };
  const auto found = std::find_if(stages.begin(), stages.end(), wanted);
  if (found == stages.end() && !name.empty()) {
    std::vector<std::string> names;
    for (const Stage& s : stages) names.push_back(s.name);
    throw Error(Exit::bad_input, fmt::format("{}: stage '{}': no such stage{}; the scene has: {}", scene.file, name,
                                             did_you_mean(name, names), fmt::join(names, ", ")));
  }
  if (found == stages.end())
    throw Error(Exit::bad_input,
                fmt::format("{}: no stage has a weight or a load, so all is at rest as it is; give one gravity, forces "
                            "or pressures",
                            scene.file));
  scene.had_ground = stands_on_ground(scene);
  Stage rest = *found;
  rest.kind = "rest", rest.ramp_time = 0.0;
  if (!rest.equilibrium_ratio) rest.equilibrium_ratio = 1e-4;
  rest.max_steps = std::min(rest.max_steps, 1000000L);
  rest.displacement.reset(), rest.duration.reset(), rest.whiffletree.reset(), rest.cycles.reset();
  rest.ground.reset(), rest.collapse.reset(), rest.moving_load.reset();
  for (BodyControl& c : rest.controls) c.velocity = c.omega = {}, c.in_cycles = -1;
  stages = {rest};
  scene.output.end_state = true;
  return scene;
}

}  // namespace quoin
