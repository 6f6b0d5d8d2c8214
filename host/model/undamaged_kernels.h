// Inner loops of K u for the undamaged system, compiled for every instruction set of Highway and chosen at run time.
// They use no fused multiply-adds, and add in the order of memory: the time step has the same bits on every machine.
#pragma once

#include <cstdint>

#include "model/model.h"
#include "model/rigid_motion.h"

namespace quoin {

// Operator S, the square root of the inverse inertia of rigid_motion.h, in coordinates sqrt(m) u:
// P_u + (P_b - P_u)/sqrt(s_u) + (1 - P_b)/sqrt(s_b).
struct MotionScaling {
  const RigidMotions* rigid = nullptr;     // null: the identity
  double of_deformation = 1.0;             // 1/sqrt(s_b)
  double of_unit = 1.0;                    // 1/sqrt(s_u)
  const double* node_root_mass = nullptr;  // [line][lane], sqrt(kg)
};

// y = D S x for the gridpoints of a unit group, D diagonal. x and y: distinct whole arrays in lane layout.
void scale_motion_then(const Model& model, const UnitGroup& unit, const MotionScaling& scaling, const double* diagonal,
                       const double* x, double* y);

// y = S D y; returns sum + x . y, added in the order of memory.
double scale_motion_after(const Model& model, const UnitGroup& unit, const MotionScaling& scaling,
                          const double* diagonal, double sum, const double* x, double* y);

// f = K u of the zones of a unit group; whole arrays in lane layout.
void zone_stiffness(const Model& model, const UnitGroup& unit, const double* u, double* f);

// Consecutive contact points between gridpoints of deformable blocks, of one family and axis.
struct SpringRun {
  std::int32_t first_point = 0, point_count = 0;
  int axis = 0;
  double normal_stiffness = 0.0, shear_stiffness = 0.0;  // Pa/m
};

// f += K u of the springs of contact points, one point after the other.
void add_springs(const Model& model, const SpringRun& run, const double* u, double* f);

}  // namespace quoin
