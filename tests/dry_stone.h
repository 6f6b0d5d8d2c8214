// Head of a scene of rigid blocks of dry stone.
#pragma once

#include <fmt/core.h>

#include <string>

// friction_angle: degrees.
inline std::string dry_stone(double friction_angle) {
  return R"(
[materials.stone]
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 1e9
friction_angle = )" +
         fmt::format("{}\n", friction_angle);
}

// A cube of 1 m on a wide ground.
inline constexpr const char* kCubeOnGround = R"([[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-2, -1, -2], size = [4, 1, 4] }
[[block]]
name = "cube"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
)";

// Stages of that cube: its weight, and 0.1 mm downwards.
inline constexpr const char* kPressedCube = R"([[stage]]
gravity = [0, -9.81, 0]
ramp_time = 0.05
duration = 0.1
[[stage]]
displacement = 1e-4
ramp_time = 0.01
[[stage.velocity]]
block = "cube"
velocity = [0, -0.005, 0]
)";
