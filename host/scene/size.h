// How large a scene is, from its numbers alone: before anything of that size is made.
#pragma once

#include "scene/scene.h"

namespace quoin {

// Blocks of mesh files are not counted: only reading them tells.
struct SceneSize {
  double blocks = 0.0, zones = 0.0;
  double points = 0.0;  // of contacts, at most
  double bytes = 0.0;   // of memory, within about a factor of 2
};

SceneSize size_of(const Scene& scene);

}  // namespace quoin
