// Scenes of the tests of members: common parts.
#pragma once

#include <fmt/format.h>

#include <string>

#include "members/members.h"
#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/simulation.h"

namespace quoin::members_cases {

// Returns the beginning of a scene: rigid blocks with stiff dry joints, and a fixed base below y = 0.
inline std::string head(double friction_angle, double normal_stiffness = 1e11, double mass_damping = 4.0) {
  return fmt::format(R"([materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = {0:g}
shear_stiffness = {0:g}
friction_angle = {1:g}
[solver]
damping = "viscous"
mass_damping = {2:g}
stiffness_damping = 2e-5
[output]
frames = 0
plots = false
[[block]]
name = "base"
material = "stone"
fixed = true
box = {{ lower = [-9, -1, -9], size = [30, 1, 30] }}
)",
                     normal_stiffness, friction_angle, mass_damping);
}

inline std::string box(const std::string& name, const std::string& lower, const std::string& size,
                       const std::string& more = "") {
  return fmt::format("[[block]]\nname = \"{}\"\nmaterial = \"stone\"\nbox = {{ lower = {}, size = {} }}\n{}\n", name,
                     lower, size, more);
}

inline std::string tie(const std::string& name, const std::string& from, const std::string& from_point,
                       const std::string& to, const std::string& to_point, const std::string& keys) {
  return fmt::format(
      "[[tie]]\nname = \"{}\"\nfrom = {{ block = \"{}\", point = {} }}\nto = {{ block = \"{}\", "
      "point = {} }}\n{}\n",
      name, from, from_point, to, to_point, keys);
}

}  // namespace quoin::members_cases
