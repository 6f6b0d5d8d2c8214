// Monitors of a run, [[monitor]] of a scene, in addition to those of its stages. They serve results alone, so that
// Scene does not have them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/reader.h"
#include "scene/scene.h"

namespace quoin {

struct Monitor {
  std::string name;           // name of its columns
  std::string block;          // name of a block, of a body, or of a floor
  std::optional<Vec3> point;  // m; nearest corner or gridpoint at the start; none: mean of all
  std::string below;          // monitor against which its drift is measured; empty: none
  Source source;
};

std::vector<Monitor> read_monitors(reader::Table& scene);
// Monitors in the text of a scene, with its overrides.
std::vector<Monitor> monitors_of(const std::string& text, const std::string& path,
                                 const std::vector<std::string>& overrides);

}  // namespace quoin
