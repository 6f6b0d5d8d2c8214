// [tests]: results of tests on a masonry, and the properties of joints and units that follow from them (properties/).
#pragma once

#include <vector>

#include "properties/from_tests.h"
#include "scene/reader.h"

namespace quoin {

// Reads a table [tests]. block_height (m) and axial_stress (Pa) are its defaults.
TestedMasonry read_tests(reader::Table tests, double block_height, double axial_stress);

// Properties of a joint family of `law`: id and value. part: bed, head, inside.
std::vector<std::pair<const char*, double>> joint_properties(const MasonryNumbers& numbers, const std::string& part,
                                                             const std::string& law);

// Replaces properties = "from_tests" in [materials.*] and [joints.*] by numbers. Explicit values stay. Returns how the
// numbers follow from the tests; empty without [tests].
std::vector<Derivation> fill_in_from_tests(toml::table& root, reader::Context& context);

}  // namespace quoin
