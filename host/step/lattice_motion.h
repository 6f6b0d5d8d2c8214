// Motion and forces of bricks on the lattice, as a row, a check or a promotion reads them.
#pragma once

#include <cstdint>
#include <utility>

#include "step/state.h"

namespace quoin {

// By the mass of gridpoints.
double mean_along_x(const Simulation::Impl& s, const LoadedBlock& block, const LaneVector<double>& field);
// Displacement of the deformable blocks of the monitor at the time of the last forces, m.
Vec3 displacement_of_loaded(const Simulation::Impl& s, int index);
// Sum of the forces of its points on the deformable blocks of the monitor, N.
Vec3 sum_on_monitor(const Simulation::Impl& s, int index);
// Translation + rotation x arm of a rigid body at a reference position.
Vec3 of_body_at(const Simulation::Impl& s, int body, BodyLanes::Quantity BodyLanes::*translation,
                BodyLanes::Quantity BodyLanes::*rotation, const Vec3& position);
// Sum over its contact points at the last evaluation of the laws, N.
Vec3 sum_joint_force(const Simulation::Impl& s, int body);
// Opening and slips of a contact point at the time of its traction: displacements have moved on by one step since.
Vec3 jump_at_traction(const Simulation::Impl& s, std::int32_t point);
// Combination of displacement and velocity with these factors, at the gridpoints of a contact point on blocks a and b.
std::pair<Vec3, Vec3> motion_of_sides(const Simulation::Impl& s, std::int32_t point, double of_displacement,
                                      double of_velocity);
// Motion of side b less that of side a, along n, s, t.
Vec3 jump_of(const Simulation::Impl& s, std::int32_t point, double of_displacement, double of_velocity);
// As its law has it, with the shift of laws swapped in.
double opening_at_traction(const Simulation::Impl& s, std::int32_t point);
JointWrench sum_joint_wrench(const Simulation::Impl& s, int body);
WholeMotion whole_motion_of(const Simulation::Impl& s, std::size_t brick);

}  // namespace quoin
