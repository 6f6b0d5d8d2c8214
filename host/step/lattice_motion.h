// Motion and forces of bricks on the lattice, for rows, checks and promotion.
#pragma once

#include <cstdint>
#include <utility>

#include "step/state.h"

namespace quoin {

// Components of a gridpoint, by its offset in lane layout.
inline Vec3 at_gridpoint(const LaneVector<double>& values, std::size_t offset) {
  return {values[offset], values[offset + kLanes], values[offset + 2 * kLanes]};
}
// Traction of a contact point with its viscous part, Pa. In measured steps of each contact point.
inline Vec3 point_traction(const Simulation::Impl& s, std::size_t point) {
  Vec3 sum;
  for (std::size_t k = 0; k < 3; ++k)
    sum[k] = s.lattice.traction[k][point] + (s.lattice.damps_joints() ? s.lattice.viscous[k][point] : 0.0);
  return sum;
}
// Translation + rotation x arm of a rigid body, at a position in the reference configuration.
Vec3 of_body_at(const Simulation::Impl& s, int body, BodyLanes::Quantity BodyLanes::*translation,
                BodyLanes::Quantity BodyLanes::*rotation, const Vec3& position);
// Opening and slips of a contact point at the time of its traction, one step before the current displacements.
Vec3 jump_at_traction(const Simulation::Impl& s, std::int32_t point);
// of_displacement * u + of_velocity * v, at the gridpoints of a contact point on blocks a and b.
std::pair<Vec3, Vec3> motion_of_sides(const Simulation::Impl& s, std::int32_t point, double of_displacement,
                                      double of_velocity);
// Difference of that motion, side b less side a, along n, s, t.
Vec3 jump_of(const Simulation::Impl& s, std::int32_t point, double of_displacement, double of_velocity);
// Opening that the law receives, m: with the shift of law swaps.
double opening_at_traction(const Simulation::Impl& s, std::int32_t point);
// Contact forces on a rigid brick at the last evaluation of the laws: of a process that has its contact points, of any.
JointWrench sum_joint_wrench(const Simulation::Impl& s, int block);
JointWrench joint_wrench(const Simulation::Impl& s, int block);
WholeMotion whole_motion_of(const Simulation::Impl& s, std::size_t brick);

}  // namespace quoin
