// The smallest scene of blocks.
#pragma once

#include <string>

inline const std::string kStone = R"([materials.stone]
density = 2000
young_modulus = 1e10
poisson_ratio = 0.2
[joints.dry]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 5e8
)";
inline const std::string kOneBlock = kStone + R"([[block]]
name = "block"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[stage]]
duration = 0.1
)";
