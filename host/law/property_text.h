// Property values on a command line: id=value, in the kind that the law's metadata has for the id.
#pragma once

#include <string>

#include "base/number_text.h"
#include "quoin/quoin.h"
#include "scene/scene.h"

namespace quoin {

// "cohesion=0.3e6", "softening=exponential", "softening_table=0:1,0.3:0.5,1:0". An id that the law does not have is
// kept, so that the law reports it with its other errors. Throws Error(usage) without '=' or with an empty id,
// Error(bad_input) for a malformed number or table.
PropertySetting parse_setting(const quoin_law& law, const std::string& assignment, const Source& source);

// Property with that id, or null.
const quoin_property_info* find_property(const quoin_law& law, const std::string& id);

}  // namespace quoin
