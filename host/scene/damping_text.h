// Damping of a stage in words: for the screen, `check`, the summary and warnings.
#pragma once

#include <optional>
#include <string>

#include "scene/scene.h"

namespace quoin {

// gamma of eq. 1 in a stage; 0: eq. 1 does not act.
double local_damping_in(const Scene& scene, std::size_t stage);

// "damping local 0.8, time_step_fraction 0.6". settling: for stages that run to equilibrium.
std::string solver_text(const SolverSettings& solver, bool settling);
// Whether the added inertia of a stage differs from that of [solver].
bool has_own_inertia(const Scene& scene, std::size_t stage);
// Solver settings of a stage with a solver table of its own, or after one; else empty.
std::string own_solver_text(const Scene& scene, std::size_t stage);

// Damping of a stage that acts on the motion of whole blocks in space: "local damping (gamma 0.8)", "mass damping (0.5
// 1/s)". It falsifies sliding, rocking and falling. Empty: there is none.
std::string damping_in_space(const Scene& scene, std::size_t stage);
// Advice that follows such a warning.
inline constexpr const char* kDampingForMotion =
    "take damping = \"impact\", \"viscous\" with stiffness_damping = 2 zeta/omega of the contacts and no mass_damping, "
    "or \"none\", in [solver] or in the solver table of the stage (scenes/BLOCKS.md, \"Ground motion and damping\")";

// Restitution of an edge that lands on a spring and a dashpot of this share of critical, which never pull. It is the
// velocity ratio of m u'' = -k u - c u' from u = 0 to the time at which the force is 0 again.
double landing_restitution(double damping_ratio);

// Records of a stage with ground motion: "record of 0.8 s along (1, 0, 0), which ends at 1 m/s".
std::string ground_text(const GroundMotion& ground, std::optional<double> duration);
// Whether a record begins after the end of a stage of this duration, s.
bool begins_after(const GroundMotion::Component& component, double duration);
double end_velocity(const GroundMotion::Component& component);  // m/s, along its direction, at the end of the record

}  // namespace quoin
