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

// Every fault of a scene, one a line, in the order of its lines. scene: what could be read all the same.
class SceneFaults : public Error {
 public:
  SceneFaults(const std::string& faults, Scene read)
      : Error(Exit::bad_input, faults), scene(std::make_shared<const Scene>(std::move(read))) {}
  std::shared_ptr<const Scene> scene;
};

// overrides: "dotted.key=value", laid over the file before anything is checked. The value is TOML (1e5, true, [1, 2])
// and a plain word otherwise. An element of a list is named by its number from 1, or by its `name`: stage.2.velocity,
// stage.shear.velocity. Throws SceneFaults.
Scene read_scene(const std::string& path, const std::vector<std::string>& overrides = {});
// The same of a text in place of what the file holds; other files are sought beside PATH all the same.
Scene read_scene_text(const std::string& text, const std::string& path, const std::vector<std::string>& overrides = {});

}  // namespace quoin
