// Properties of joint families that scatter, and the sample that a scene stands for.
#pragma once

#include "scene/reader.h"

namespace quoin::reader {

// The keys of a distribution; faults go to the context.
random::Distribution read_distribution(Table& t);
// { distribution = "lognormal", mean = 0.2e6, cov = 0.3, level = "joint" } as the value of a property.
Scatter read_scatter(Table t);
// correlation = [["tensile_strength", "cohesion", 0.8]], of properties that scatter and have been read.
void read_correlation(Table& t, JointFamily& family);
RandomSample read_random(Table& t);  // [random]

}  // namespace quoin::reader
