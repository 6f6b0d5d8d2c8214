// Scenes that tests write themselves.
#pragma once

#include <string>
#include <vector>

#include "scene/read_scene.h"
#include "scratch.h"

namespace quoin {

inline Scene scene_of_text(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const Scratch scratch;
  return read_scene(scratch.file("scene.toml", text), overrides);
}

}  // namespace quoin
