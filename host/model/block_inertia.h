// Rigid motion of deformable blocks in large motion, and inertia that is scaled apart from it.
//
// P_b and P_u are the projections of motion on rigid motions of blocks and of units in two halves. They are taken at
// the current positions of the gridpoints. They are orthogonal in the mass matrix M, and P_u P_b = P_u. Kinetic energy:
//   T = 1/2 v . M' v,  M' = M (P_u + s_u (P_b - P_u) + s_b (1 - P_b)),
// as on the lattice (model/rigid_motion.h). M' depends on the positions. With a = M^-1 f, Lagrange's equations of T are
//   v' = P_u a + (P_b - P_u) (a/s_u + (1 - 1/s_u) g_u)
//      + (1 - P_b) (a/s_b + (1 - s_u/s_b) g_b + (s_u - 1)/s_b g_u),
//   g = w x (w x r) + 2 w x (v - P v),  w the spin of the block or of the unit.
// Motion that turns along with a block takes no more force than its true mass does. So a spinning block is stretched as
// if nothing had been scaled. The second part of g does no work. Compared with the forces of stiffness it is of the
// order of w over the slowed frequency of vibration. It is left out. Mass, moments of inertia, momentum and angular
// momentum are the true ones. Limits: s = 1 is M v' = f; s -> infinity a rigid block or unit; no rotation: the
// lattice's scaled inertia.
//
// In a step, P is that of the positions x_n, at which its forces are computed. g is the mean of its values at the
// velocities half a step before and after. Their rigid parts are found in one solution. A block that turns by theta in
// the step has the spin sin(theta)/dt there; its velocity changes by 4 sin^2(theta/2)/dt r. So g counts (w dt)^2 as 2
// (1 - cos(theta)): steady spin is the same for all s to rounding. The step is reversible in time, so that energy
// oscillates and does not drift.
//
// Damping by block is eq. 1 on the forces and moments of rigid motion, component by component along the axes of space,
// -gamma |F_k| sgn(v_k). Rigid blocks and the lattice have the same damping. In any axes its size is gamma |F|, and it
// never does positive work. For motion along or against the force it is the same vector in any axes. Its direction
// depends on the axes only for motion oblique to the force.
#pragma once

#include <cstdint>
#include <span>

#include "geometry/vector.h"
#include "model/lanes.h"

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

// One number a lane.
struct alignas(64) ByLane {
  double of[kLanes];
};

// Sums over the gridpoints of each block of a SIMD group, about its mass centre.
struct InertiaLanes {
  ByLane centre[3], mass, second[3][3];  // m; kg; sum m r r^T, kg m2
  ByLane held[3];                        // not 0: some gridpoint is held along this axis
};

// Inertia of the rigid motions that supports leave free. Translation along an axis is free where no gridpoint is held
// along it. Rotation about an axis is free where no gridpoint is held across it.
class RigidInertia {
 public:
  RigidInertia() = default;
  RigidInertia(std::span<const Vector> x, std::span<const double> mass, std::span<const std::uint8_t> held);
  // From sums about the mass centre: second = sum m r r^T, kg m2; held: bits of all gridpoints.
  RigidInertia(const Vector& centre, double mass, const Matrix& second, std::uint8_t held);
  // Inertia of both bodies moving as one.
  RigidInertia(const RigidInertia& a, const RigidInertia& b);

  const Vector& centre() const { return centre_; }  // m
  Rigid acceleration(const Rigid& force) const;     // or the velocity of a momentum
  Rigid force(const Rigid& acceleration) const;     // or the momentum of a velocity
  double twice_energy(const Rigid& velocity) const { return dot(force(velocity), velocity); }  // J

 private:
  void invert();
  Vector centre_;
  double mass_ = 0.0;
  Matrix inertia_ = Matrix::zero(), inverse_ = Matrix::zero();
  bool held_[3] = {false, false, false};
};

// Sum of vectors y at gridpoints x, and their moment about a centre; weighted by mass where `weight` is given.
Rigid sum_about(const Vector& centre, std::span<const Vector> x, std::span<const Vector> y,
                std::span<const double> weight = {});

// Inertia of a block that stands alone (count 1), or of the two halves of a unit.
struct UnitInertia {
  int count = 1;
  RigidInertia block[2], whole;

  // Rigid motion of the whole unit, from forces on the blocks about their centres or from their momenta.
  Rigid motion(const Rigid (&force)[2]) const;
  // Motion of the whole unit, as velocity at the centre of block b and spin.
  Rigid at_block(int b, const Rigid& of_whole) const;
};

struct InertiaFactors {
  double deformation = 1.0, unit = 1.0;  // s_b, s_u
};

// 1/2 v . M' v less 1/2 v . s_b M v. velocity: rigid motion of each block.
double rigid_energy(const UnitInertia& inertia, const InertiaFactors& s, const Rigid (&velocity)[2]);

}  // namespace quoin::blocks
