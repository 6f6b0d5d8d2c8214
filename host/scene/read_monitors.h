// What a run follows beside its first monitor: [[monitor]] of a scene. Of the results alone, so no part of Scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/reader.h"
#include "scene/scene.h"

namespace quoin {

struct Monitor {
  std::string name;           // name of its columns
  std::string block;          // a block, or a body or floor of several
  std::optional<Vec3> point;  // m: the corner or gridpoint that is closest to it at the start; else the mean of all
  std::string below;          // another monitor, from which its drift counts; empty: none
  Source source;
};

std::vector<Monitor> read_monitors(reader::Table& scene);
// Monitors in the text of a scene that has been read, and in the changes laid over it.
std::vector<Monitor> monitors_of(const std::string& text, const std::string& path,
                                 const std::vector<std::string>& overrides);

}  // namespace quoin
