// Damping of impacts (scenes/BLOCKS.md): the viscosity under which an edge stops where it lands, and its effect on the
// time step. Bricks on the lattice and blocks of any shape use it.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "scene/scene.h"

namespace quoin {

// A block that lands on an edge of one of its faces. Inertia is with its scaling.
struct LandingBlock {
  double mass, area;     // kg; of the face, m2
  double tipping;        // largest b^2/I of the edges of the face, 1/kg
  double least_inertia;  // least moment of inertia about axes along these edges, kg m2
  double height;         // m, of the centre of mass above the face
};

// Squared frequencies of landing, 1/s2. Normal to the face omega^2 = kn (A/2) (1/m + b^2/I), for the edge with the
// highest frequency. Along it omega^2 = ks (A/2) (1/m + h^2/I). kn, ks: stiffness of the joint, Pa/m.
std::array<double, 2> landing_squares(const LandingBlock& landing, double kn, double ks);

// Viscosity over stiffness normal to the joint and along it, s; 0 where nothing lands. squares: largest squared
// frequencies, 1/s2.
std::array<double, 2> impact_viscosity(const std::array<double, 2>& squares, double impact_damping);

// Lowers the viscosity over stiffness of zones, s, to that of a block; least: 0 before the first one. It is 1 % of
// critical damping at the first vibration of a free bar of the block's length, m. Its omega = pi c/L, with the speed of
// sound c.
void lower_zone_viscosity(double& least, double length, const BlockMaterial& material, double mass_scaling);

// Stable step for stiffness K and viscosity C, whose forces are those of the velocities half a step ago. Central
// differences are stable where 4 M - dt^2 K - 2 dt C is positive. Thus dt <= 2/omega(dt), where omega^2 is the largest
// eigenvalue of M^-1 (K + 2 C/dt). This omega grows as dt falls. So from a stable dt, 2/omega(dt) is stable too, and at
// least as long. The first dt follows from the sum of the largest eigenvalues of K and of C: x^2 + z x = 1. Where the
// step would fall below kLeastImpactStep of the undamped one, viscosity is reduced instead. The eigenvalue is a convex
// function of the share of viscosity, so that a chord gives a safe share.
struct ImpactStep {
  double left;   // step over the undamped step
  double share;  // share of the viscosity that is kept
};
inline constexpr double kLeastImpactStep = 0.5;
// critical: undamped step, s. rate: largest eigenvalue of M^-1 C, 1/s. eigenvalue(share, dt): of M^-1 (K + 2 share
// C/dt), 1/s2.
ImpactStep step_under_impacts(double critical, double rate, const std::function<double(double, double)>& eigenvalue);

// Impact damping of a model.
struct ImpactDamping {
  std::vector<std::array<double, 2>> viscosity;  // over stiffness, s: on the lattice, by joint family
  double of_zones = 0.0;                         // viscosity over stiffness of zones, s
  double in_use = 0.0;                           // share of critical damping for a block that lands on an edge
};

}  // namespace quoin
