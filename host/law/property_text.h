// Property values as people write them on a command line: id=value, by the kind that the law's metadata gives the id.
#pragma once

#include <string>

#include "base/number_text.h"
#include "quoin/quoin.h"
#include "scene/scene.h"

namespace quoin {

// "cohesion=0.3e6", "softening=exponential", "softening_table=0:1,0.3:0.5,1:0". An id that the law does not have is
// passed on, so that the law lists it with its other faults. Throws Error(usage): no '=', empty id; Error(bad_input): a
// number or a table that is none.
PropertySetting parse_setting(const quoin_law& law, const std::string& assignment, const Source& source);

// The property of that id, or null.
const quoin_property_info* find_property(const quoin_law& law, const std::string& id);

}  // namespace quoin
