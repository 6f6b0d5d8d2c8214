// Names of properties in 3DEC's joint models and in published models with fracture energies. Data files with these
// names run with a Quoin law.
#pragma once

#include <array>
#include <string_view>
#include <utility>

namespace quoin::threedec {

inline constexpr std::array<std::pair<std::string_view, std::string_view>, 12> property_synonyms = {{
    {"normal_stiffness", "stiffness-normal"},
    {"shear_stiffness", "stiffness-shear"},
    {"tensile_strength", "tension"},
    {"tensile_strength_residual", "tension-residual"},
    {"cohesion_residual", "cohesion-residual"},
    {"friction_angle", "friction"},
    {"friction_angle_residual", "friction-residual"},
    {"dilation_angle", "dilation"},
    {"compressive_strength", "compression"},
    {"fracture_energy_tension", "G_I"},
    {"fracture_energy_shear", "G_II"},
    {"fracture_energy_compression", "G_c"},
}};

// Returns the 3DEC name of a law's property; empty if it has none.
constexpr std::string_view synonym(std::string_view property) {
  for (const auto& [id, name] : property_synonyms)
    if (id == property) return name;
  return {};
}

}  // namespace quoin::threedec
