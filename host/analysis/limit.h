// Limit analysis of assemblies of rigid blocks by the static theorem. It is the largest multiplier of loads for which
// contact forces exist that are in equilibrium and within strength everywhere.
//
// Livesley (1978): a linear programme where friction cones are pyramids, a second-order cone programme where they are
// whole. Flow is associated: sliding lifts by the friction
// angle. The multiplier is an upper bound of those without dilation, far above them where a bonded wall cannot dilate.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "geometry/vector.h"

namespace quoin {

// Force and moment about the centre of a block, N and N m.
struct Wrench {
  geometry::Vector force, moment;
};

struct LimitBlock {
  geometry::Vector centre;  // reference point of wrenches and velocities, m
  bool fixed = false;
  Wrench dead, live;  // constant loads, and those that are multiplied
};

// A contact point. Tractions as in the laws: sigma > 0 is tension, n from block a to block b.
struct LimitPoint {
  int a = 0, b = 0;
  geometry::Vector position;                                  // m
  geometry::Vector n, s, t;                                   // unit
  double friction = 0.0;                                      // tan(phi), >= 0
  double tension = 0.0;                                       // largest force along n, N, >= 0
  double cohesion = 0.0;                                      // shear strength without normal force, N, >= 0
  double crushing = std::numeric_limits<double>::infinity();  // largest compression, N, > 0
  double area = 1.0;                                          // m2, > 0; stiffness of joints is in proportion
  double live_cohesion = 0.0;                                 // cohesion added by a multiplier of 1, N
};

// What a member carries: one number between two bounds, which acts on all of its places at once.
struct LimitForce {
  struct Place {
    int block = 0;
    geometry::Vector at;         // m
    geometry::Vector way, turn;  // force and moment on the block of a unit
  };
  std::vector<Place> places;
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
};

struct LimitProblem {
  std::vector<LimitBlock> blocks;
  std::vector<LimitPoint> points;
  std::vector<LimitForce> forces{};  // forces of members
};

struct LimitSettings {
  // Facets of the pyramid inside the friction cone. A shear force between two of its edges is at most 1 -
  // cos(pi/facets) too weak: 0.5 % of friction with 32. Edges lie along s and t where 4 divides it: exact for plane
  // problems. With 0 the whole cone, by cone_limit.h, and pyramids of 32 facets where that finds nothing.
  int facets = 32;
  bool facet_on_axis = false;  // the normal of the first facet, and not its edge, lies along s
  // The middle of all forces that give the multiplier, and not a corner of them: it moves little when strengths do. To
  // fewer digits, with pyramids. Friction may be below 0 then.
  bool interior = false;
  // Compression at each point, N, or none: of all forces that give the multiplier those nearest to these, with the
  // least shear. With whole cones alone, and with friction below 0, too; not_converged where cone_limit.h finds none.
  std::vector<double> near{};
  double most =
      std::numeric_limits<double>::infinity();  // bound of the multiplier; where it is reached, no mechanism is sought
};

enum class LimitStatus {
  solved,
  no_equilibrium,  // the dead loads alone cannot be carried
  unbounded,       // no multiple of the live loads moves anything
  not_converged    // the solver stopped, or its solution leaves residuals
};

struct LimitResult {
  LimitStatus status = LimitStatus::not_converged;
  double multiplier = 0.0;
  double gap = 0.0;  // (upper - lower bound)/max(1, |multiplier|) of the programme
  int facets = 0;    // facets of the friction cones; 0: whole cones
  // On block a along n, s, t at each point, N: n > 0 is tension.
  std::vector<std::array<double, 3>> force;
  std::vector<double> member_force;  // by LimitProblem::forces
  // Mechanism: virtual velocity of the centre and spin of each block. The largest velocity of a centre or contact point
  // is 1 (m/s, rad/s).
  std::vector<Wrench> velocity;  // force: velocity, moment: spin
  // Blocks that cannot be held (no_equilibrium), or on which the load acts that moves nothing (unbounded); ascending.
  std::vector<int> blocks_concerned;
};

// Throws Error(bad_input): indices out of range, values that are not finite, strengths below 0, no live load, facets
// < 4.
LimitResult limit_multiplier(const LimitProblem& problem, const LimitSettings& settings = {});

// What programmes count forces and lengths in: the mean load of a block, N, and the mean arm of a contact point, m.
std::pair<double, double> scales_of(const LimitProblem& problem);

// Blocks that no chain of contact points and members joins to a fixed one; indices, ascending.
std::vector<int> unconnected_blocks(const LimitProblem& problem);

}  // namespace quoin
