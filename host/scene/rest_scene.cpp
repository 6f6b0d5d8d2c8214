#include "scene/rest_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "scene/generate.h"
#include "scene/stage_named.h"

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
  const auto found =
      name.empty() ? std::find_if(stages.begin(), stages.end(), has_load) : stages.begin() + stage_named(scene, name);
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
