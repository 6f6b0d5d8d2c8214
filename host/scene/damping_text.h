// What damping does in a stage, in words: for the screen, check, the summary and warnings.
#pragma once

#include <string>

#include "scene/scene.h"

namespace quoin {

// gamma of eq. 1 in this stage; 0: it has none.
double local_damping_in(const Scene& scene, std::size_t stage);

// "damping local 0.8, time_step_fraction 0.6". settling: of stages that run to equilibrium.
std::string solver_text(const SolverSettings& solver, bool settling);
// Whether the inertia that is added to vibrations is another one than that of [solver].
bool has_own_inertia(const Scene& scene, std::size_t stage);
// Text for stages with a solver table of their own, and for those after them; else empty.
std::string own_solver_text(const Scene& scene, std::size_t stage);

// The part of the damping of a stage that acts on motion in space, whole blocks included. It falsifies what slides,
// rocks or falls: "local damping (gamma 0.8)", "mass damping (0.5 1/s)". Empty: none does.
std::string damping_in_space(const Scene& scene, std::size_t stage);
// What to write in its place.
inline constexpr const char* kDampingForMotion =
    "take damping = \"impact\", \"viscous\" with stiffness_damping = 2 zeta/omega of the contacts and no mass_damping, "
    "or \"none\", in [solver] or in the solver table of the stage (scenes/BLOCKS.md, \"Ground motion and damping\")";
// Warning for a stage that moves the ground under damping of that kind; else empty.
std::string ground_damping_warning(const Scene& scene, std::size_t stage);

// The share of its velocity with which an edge comes back after landing on a spring and a dashpot of this share of
// critical. They never pull: m u'' = -k u - c u' from u = 0 until that is 0 again.
double landing_restitution(double damping_ratio);

// What the record of a stage with ground motion leaves: "record of 0.8 s along (1, 0, 0), which ends at 1 m/s".
std::string ground_text(const GroundMotion& ground);
double end_velocity(const GroundMotion::Component& component);  // m/s, along its direction

}  // namespace quoin
