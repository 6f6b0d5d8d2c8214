// Rigid motion of deformable blocks as they stand, and inertia that is scaled apart from it.
//
// P_b and P_u are the projections of motion on rigid motions of blocks and of units in two halves. They are of the
// gridpoints where they are now. They are orthogonal in the mass matrix M, and P_u P_b = P_u. Kinetic energy is
//   T = 1/2 v . M' v,  M' = M (P_u + s_u (P_b - P_u) + s_b (1 - P_b)),
// as on the lattice (model/rigid_motion.h). M' depends on the place, and Lagrange's equations of T are, with
// a = M^-1 f,
//   v' = P_u a + (P_b - P_u) (a/s_u + (1 - 1/s_u) g_u)
//      + (1 - P_b) (a/s_b + (1 - s_u/s_b) g_b + (s_u - 1)/s_b g_u),
//   g = w x (w x r) + 2 w x (v - P v),  w the spin of the block or of the unit.
// What turns along with a block needs no more force than its true mass does. So a spinning block is stretched as if
// nothing had been scaled. The second part of g does no work and is w over the slowed frequency of the vibration beside
// the forces of stiffness. It is left out. Mass, moments of inertia, momentum and angular momentum are the true ones.
// Limits: s = 1 is M v' = f; s -> infinity a rigid block or unit; no rotation: the lattice's scaled inertia.
//
// In a step, P is that of the positions x_n at its forces. g is the mean of those of both velocities beside it, whose
// rigid parts are found at once. A block that turns by theta in the step has the spin sin(theta)/dt there; its velocity
// changes by 4 sin^2(theta/2)/dt r. So g counts (w dt)^2 as 2 (1 - cos(theta)): steady spin is the same for all s to
// rounding. The step can be taken backwards, so that energy swings and does not drift.
//
// Damping by block: eq. 1 on the forces and moments of rigid motion, component by component along the axes of space,
// -gamma |F_k| sgn(v_k). Rigid blocks and the lattice have the same. In whatever axes its size is gamma |F| and it
// never does positive work. Along a motion that goes with or against the force it is the same vector. Only the
// direction beside an oblique motion depends on the axes.
#pragma once

#include <cstdint>
#include <span>

#include "geometry/vector.h"

namespace quoin::blocks {

using geometry::Matrix;
using geometry::Vector;

// Force and moment about a centre, or velocity and spin, or acceleration of both.
struct Rigid {
  Vector linear, angular;
};
inline Rigid operator+(const Rigid& a, const Rigid& b) { return {a.linear + b.linear, a.angular + b.angular}; }
inline Rigid operator-(const Rigid& a, const Rigid& b) { return {a.linear - b.linear, a.angular - b.angular}; }
inline Rigid operator*(double f, const Rigid& a) { return {f * a.linear, f * a.angular}; }
inline double dot(const Rigid& a, const Rigid& b) { return dot(a.linear, b.linear) + dot(a.angular, b.angular); }

// Inertia of the rigid motions that gridpoints allow: along an axis where none of them is held, about it where none is
// held across it.
class RigidInertia {
 public:
  RigidInertia() = default;
  RigidInertia(std::span<const Vector> x, std::span<const double> mass, std::span<const std::uint8_t> held);
  // From sums about the mass centre: second = sum m r r^T, kg m2; held: bits of all gridpoints.
  RigidInertia(const Vector& centre, double mass, const Matrix& second, std::uint8_t held);
  // Inertia of both together.
  RigidInertia(const RigidInertia& a, const RigidInertia& b);

  const Vector& centre() const { return centre_; }  // m
  Rigid acceleration(const Rigid& force) const;     // or velocity of a momentum
  Rigid force(const Rigid& acceleration) const;     // or momentum of a velocity
  double twice_energy(const Rigid& velocity) const { return dot(force(velocity), velocity); }  // J

 private:
  void invert();
  Vector centre_;
  double mass_ = 0.0;
  Matrix inertia_ = Matrix::zero(), inverse_ = Matrix::zero();
  bool held_[3] = {false, false, false};
};

// Sum and moment about a centre of vectors at gridpoints, weighted by mass where that is given.
Rigid sum_about(const Vector& centre, std::span<const Vector> x, std::span<const Vector> y,
                std::span<const double> weight = {});

// Inertia of a block that stands alone (count 1), or of the two halves of a unit.
struct UnitInertia {
  int count = 1;
  RigidInertia block[2], whole;

  // Motion of the whole from forces on the blocks about their centres, or from their momenta.
  Rigid motion(const Rigid (&force)[2]) const;
  // Motion of the whole at block b.
  Rigid at_block(int b, const Rigid& of_whole) const;
};

struct InertiaFactors {
  double deformation = 1.0, unit = 1.0;  // s_b, s_u
};

// 1/2 v . M' v less that of s_b M: J. velocity: of each block.
double rigid_energy(const UnitInertia& inertia, const InertiaFactors& s, const Rigid (&velocity)[2]);

}  // namespace quoin::blocks
