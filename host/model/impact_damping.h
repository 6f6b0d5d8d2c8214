// Damping of impacts (scenes/BLOCKS.md): the viscosity under which an edge stops where it lands, and what that does to
// the time step. The same for bricks on the lattice and for blocks of any shape.
#pragma once

#include <array>
#include <functional>
#include <vector>

namespace quoin {

// A block that lands on an edge of one of its faces. Inertia with its scaling.
struct LandingBlock {
  double mass, area;              // kg; of the face, m2
  std::array<double, 2> reach;    // m, along two axes in the face, from the centre of mass to the edge
  std::array<double, 2> inertia;  // kg m2, about these axes
  double height;                  // m, of the centre of mass above the face
};

// Normal to the face omega^2 = kn (A/2) (1/m + b^2/I), of two edges the one with the higher frequency. Along it omega^2
// = ks (A/2) (1/m + h^2/I), 1/s2. kn, ks: of the joint, Pa/m.
std::array<double, 2> landing_squares(const LandingBlock& landing, double kn, double ks);

// Viscosity over stiffness normal to the joint and along it, s; 0 where nothing lands. squares: the largest, 1/s2.
std::array<double, 2> impact_viscosity(const std::array<double, 2>& squares, double impact_damping);

// The same of zones: 1 % of critical at the first vibration of a bar of this length (m) between free ends. Its omega =
// pi c/L, with the speed of sound c, m/s.
double zone_viscosity(double length, double speed);

// Stiffness K and viscosity C, whose forces are those of the velocities half a step ago. Central differences are stable
// where 4 M - dt^2 K - 2 dt C is positive. Thus dt <= 2/omega(dt), where omega^2 is the largest eigenvalue of K + 2
// C/dt over M. That one grows as dt falls, so from a dt that is stable 2/omega(dt) is stable too, and no shorter. The
// first is that of the sum of both largest eigenvalues: x^2 + z x = 1. Where the step would fall below kLeastImpactStep
// of the undamped one, viscosity becomes less instead. The eigenvalue is convex in its share, so that a chord is safe.
struct ImpactStep {
  double left;   // share of the undamped step that is left
  double share;  // share of the viscosity that is kept
};
inline constexpr double kLeastImpactStep = 0.5;
// critical: undamped, s. rate: largest eigenvalue of C over M, 1/s. eigenvalue(share, dt): of K + 2 share C/dt, 1/s2.
ImpactStep step_under_impacts(double critical, double rate, const std::function<double(double, double)>& eigenvalue);

// What a model has of it.
struct ImpactDamping {
  std::vector<std::array<double, 2>> viscosity;  // by joint family, s; empty: impacts are not damped
  double of_zones = 0.0;                         // s
  double in_use = 0.0;                           // share of critical in use, for a block that lands on an edge
};

}  // namespace quoin
