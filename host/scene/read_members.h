// Members of a scene: ties, springs, strips, floors, beams, dowels and fills.
#pragma once

#include "scene/members.h"
#include "scene/reader.h"

namespace quoin {

// Members; null: the scene has none.
std::shared_ptr<const MemberSpecs> read_members(reader::Table& t, const Scene& scene);

}  // namespace quoin
