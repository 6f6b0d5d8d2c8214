// Properties of joint families with a random distribution, and the number of the scene's random sample.
#pragma once

#include "scene/reader.h"

namespace quoin::reader {

// Reads the keys of a distribution; faults go to the context.
random::Distribution read_distribution(Table& t);
// Reads { distribution = "lognormal", mean = 0.2e6, cov = 0.3, level = "joint" } as the value of a property.
Scatter read_scatter(Table t);
// Reads correlation = [["tensile_strength", "cohesion", 0.8]]. The properties must have been read, with a distribution.
void read_correlation(Table& t, JointFamily& family);
RandomSample read_random(Table& t);  // reads [random]

}  // namespace quoin::reader
