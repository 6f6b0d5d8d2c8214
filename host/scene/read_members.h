// Members of a scene: ties, springs to the ground.
#pragma once

#include "scene/members.h"
#include "scene/reader.h"

namespace quoin {

// Null: the scene has none.
std::shared_ptr<const MemberSpecs> read_members(reader::Table& t, const Scene& scene);

}  // namespace quoin
