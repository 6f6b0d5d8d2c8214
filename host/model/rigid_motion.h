// Rigid motion of deformable blocks and of masonry units. It keeps its inertia, while the inertia of all other motion
// is scaled.
//
// Blocks are stiff compared with mortar joints, and so is the joint between the halves of a unit. Their vibrations set
// the time step, although a quasi-static wall does not depend on them. P_u and P_b are the projections of motion on
// rigid motions of units and of blocks. They are orthogonal in the mass matrix M, and P_u P_b = P_u. The inertia
//   M' = M (P_u + s_u (P_b - P_u) + s_b (1 - P_b)),  s_u, s_b >= 1,
// slows the motion of halves against each other by sqrt(s_u) and the deformation of blocks by sqrt(s_b). It does not
// change mass, moments of inertia and stiffness, so that rigid units on joints move as before. This is selective mass
// scaling after Olovsson, Simonsson and Unosson (2005), with all six rigid modes kept. Limits: s = 1 is the true
// inertia, s -> infinity a rigid block or unit. Its inverse takes no solution of equations:
//   M'^-1 f = M^-1 f/s_b + (1/s_u - 1/s_b) P_b M^-1 f + (1 - 1/s_u) P_u M^-1 f,
//   P M^-1 f = A + alpha x r,  A = sum f / sum m,  alpha = J^-1 sum r x f.
#pragma once

#include <array>
#include <vector>

#include "model/model.h"

namespace quoin {

struct RigidMotion {
  Vec3 centre{};                    // centre from the lowest corner of the block, or of the first block of the unit, m
  double mass = 0.0;                // kg
  Vec3 inverse_mass{};              // by direction, 1/kg; 0: held by a symmetry plane
  std::array<double, 9> inertia{};  // about the centre, rows; kg m2
  std::array<double, 9> inverse_inertia{};  // 1/(kg m2); 0 where rotation is held
};

struct RigidMotions {
  std::vector<RigidMotion> block;  // by block group, whose blocks share one inertia
  std::vector<RigidMotion> unit;   // by unit group
};

// node_mass: in lane layout, kg; units that are not laid out have none, and no motion.
RigidMotions rigid_motions(const Model& model, const LaneVector<double>& node_mass);

}  // namespace quoin
