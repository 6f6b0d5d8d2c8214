// Rigid-body motion of a deformable block: what scaling the inertia of deformation leaves as it is.
//
// Blocks are stiff beside their joints, so their own vibrations set the time step although nothing in a quasi-static
// wall hangs on them. With P the projection of a block's motion on rigid motions (orthogonal in the mass matrix M), the
// inertia M' = M (P + s (1 - P)), s >= 1, slows these vibrations by sqrt(s) and leaves mass, moments of inertia and
// stiffness of the block: rigid blocks on joints move as before (selective mass scaling after Olovsson, Simonsson and
// Unosson 2005, with all six rigid modes kept). Limits: s = 1 is the true inertia, s -> infinity a rigid block. Its
// inverse needs no solution:
//   M'^-1 f = f/(s m) + (1 - 1/s) (A + alpha x r),  A = sum f / sum m,  alpha = J^-1 sum r x f.
#pragma once

#include <array>
#include <vector>

#include "model/model.h"

namespace quoin {

struct RigidMotion {
  Vec3 centre{};                            // from the lowest corner of the block, m
  Vec3 inverse_mass{};                      // by direction, 1/kg; 0: held by a symmetry plane
  std::array<double, 9> inverse_inertia{};  // about the centre, rows; 1/(kg m2); 0 where rotation is held
};

// Of the blocks of a group, which share one inertia: node_mass in lane layout, kg.
RigidMotion rigid_motion_of(const Model& model, const BlockGroup& group, const LaneVector<double>& node_mass);

// In coordinates sqrt(m) u: x -> (P + (1 - P)/sqrt(s)) x over all blocks, the square root of the inverse inertia.
void scale_deformation(const Model& model, const std::vector<RigidMotion>& motions, const LaneVector<double>& node_mass,
                       double deformation_inertia, std::vector<double>* x);

}  // namespace quoin
