// Properties of joint families with a random distribution, and the number of the scene's random sample.
#pragma once

#include "scene/reader.h"

namespace quoin::reader {

// Reads the keys of a distribution; faults go to the context.
random::Distribution read_distribution(Table& t);
// Reads { distribution = "lognormal", mean = 0.2e6, cov = 0.3, level = "joint" } as the value of a property.
Scatter read_scatter(Table t);
// Reads correlation = [["a", "b", 0.8]] of these names, each pair once. what: the names in messages. Returns
// random::mix_of; empty with a fault.
std::vector<double> read_correlation(Table& t, const std::vector<std::string>& names, const std::string& what,
                                     std::vector<PropertyCorrelation>& pairs);
// Reads correlation of a joint family. The properties must have been read, with a distribution.
void read_correlation(Table& t, JointFamily& family);
RandomSample read_random(Table& t);  // reads [random]

}  // namespace quoin::reader
