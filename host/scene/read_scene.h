// Scenes from TOML files. Every key is checked; scenes/README.md lists them all with units, defaults and ranges.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/did_you_mean.h"
#include "base/error.h"
#include "scene/scene.h"

namespace quoin {

// All faults of a scene, one a line, in the order of its lines. scene: all that could be read.
class SceneFaults : public Error {
 public:
  SceneFaults(const std::string& faults, Scene read)
      : Error(Exit::bad_input, faults), scene(std::make_shared<const Scene>(std::move(read))) {}
  std::shared_ptr<const Scene> scene;
};

// overrides: "dotted.key=value", which replace values of the file before any check. The value is TOML (1e5, true, [1,
// 2]), or a text without quotes. An element of a list has its number from 1, or its `name`: stage.2.velocity,
// stage.shear.velocity. Throws SceneFaults.
Scene read_scene(const std::string& path, const std::vector<std::string>& overrides = {});
// Reads a scene from a text. Other files are searched relative to the folder of `path`.
Scene read_scene_text(const std::string& text, const std::string& path, const std::vector<std::string>& overrides = {});

}  // namespace quoin
