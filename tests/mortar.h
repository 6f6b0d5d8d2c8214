// Table 1 of the paper, mortar joint, SI units; for tests and benchmarks.
#pragma once

#include <utility>
#include <vector>

namespace quoin::test::mortar {

inline constexpr double kn = 82e9, ks = 36e9;                // Pa/m
inline constexpr double ft = 0.2e6, c0 = 0.3e6, fc = 5e6;    // Pa
inline constexpr double phi = 35.0;                          // deg
inline constexpr double G1 = 15.0, G2 = 125.0, Gc = 8000.0;  // J/m2

// Properties by id; each law uses those that it has.
inline const std::vector<std::pair<const char*, double>> properties = {{"normal_stiffness", kn},
                                                                       {"shear_stiffness", ks},
                                                                       {"tensile_strength", ft},
                                                                       {"cohesion", c0},
                                                                       {"friction_angle", phi},
                                                                       {"compressive_strength", fc},
                                                                       {"fracture_energy_tension", G1},
                                                                       {"fracture_energy_shear", G2},
                                                                       {"fracture_energy_compression", Gc}};

}  // namespace quoin::test::mortar
