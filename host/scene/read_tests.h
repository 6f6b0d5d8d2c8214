// [tests]: what tests of a masonry gave, and the properties of joints and units that follow from it (properties/).
#pragma once

#include <vector>

#include "properties/from_tests.h"
#include "scene/reader.h"

namespace quoin {

// A table [tests]. block_height and axial_stress where it does not give them.
TestedMasonry read_tests(reader::Table tests, double block_height, double axial_stress);

// What a joint family of `law` gets: id and value. part: bed, head, inside.
std::vector<std::pair<const char*, double>> joint_properties(const MasonryNumbers& numbers, const std::string& part,
                                                             const std::string& law);

// Puts numbers in place of properties = "from_tests" in [materials.*] and [joints.*]. What is given besides stays.
// Returns how they came about; nothing in a scene without [tests].
std::vector<Derivation> fill_in_from_tests(toml::table& root, reader::Context& context);

// The same of the text of a scene, for people. Throws Error(bad_input).
std::vector<Derivation> derivation_of(const std::string& text, const std::string& path,
                                      const std::vector<std::string>& overrides);

}  // namespace quoin
