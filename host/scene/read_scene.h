// Scenes from TOML files. Every key is checked; scenes/README.md lists them all with units, defaults and ranges.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace quoin {

// overrides: "dotted.key=value", laid over the file before anything is checked. The value is TOML (1e5, true, [1, 2])
// and a plain word otherwise. An element of a list is named by its number from 1, or by its `name`: stage.2.velocity,
// stage.shear.velocity. Throws Error(bad_input) with every fault of the scene, one a line.
Scene read_scene(const std::string& path, const std::vector<std::string>& overrides = {});
// The same of a text in place of what the file holds; other files are looked for beside PATH all the same.
Scene read_scene_text(const std::string& text, const std::string& path, const std::vector<std::string>& overrides = {});

// ", did you mean 'courses'?" for the candidate nearest to a misspelt word, or nothing.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace quoin
