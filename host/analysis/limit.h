// Limit analysis of assemblies of rigid blocks by the static theorem. The result is the largest load multiplier for
// which contact forces are in equilibrium and within strength.
//
// Livesley (1978): a linear programme for pyramids in place of friction cones, a second-order cone programme for the
// cones. Flow is associated: sliding dilates by the friction angle. The multiplier is an upper bound of those without
// dilation, far above them where a bonded wall cannot dilate.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <limits>
#include <optional>
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
  Wrench dead, live;  // constant loads, and loads that are multiplied
};

// A contact point. Signs as in the laws: sigma > 0 is tension, n points from block a to block b.
struct LimitPoint {
  int a = 0, b = 0;
  geometry::Vector position;                                  // m
  geometry::Vector n, s, t;                                   // unit
  double friction = 0.0;                                      // tan(phi), >= 0
  double tension = 0.0;                                       // largest force along n, N, >= 0
  double cohesion = 0.0;                                      // shear strength without normal force, N, >= 0
  double crushing = std::numeric_limits<double>::infinity();  // largest compressive force, N, > 0
  double area = 1.0;                                          // m2, > 0; stiffness is proportional to it
  double live_cohesion = 0.0;                                 // cohesion added by a multiplier of 1, N
  int family = -1;                                            // joint family of a scene; -1: none
  // Whether it is a dowel's. Without dilation its normal force is the smallest with which joints are in equilibrium.
  bool bar = false;
};

// Force of a member: one number within bounds, which acts on all of its places at once.
struct LimitForce {
  struct Place {
    int block = 0;
    geometry::Vector at;         // m
    geometry::Vector way, turn;  // force and moment on the block for a unit of the number
  };
  std::vector<Place> places;
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  // Force of a strained member before the loads (pretension); none: a reaction. Without dilation a member keeps the
  // nearest force to it with which joints are in equilibrium.
  std::optional<double> start{};
};

struct LimitProblem {
  std::vector<LimitBlock> blocks;
  std::vector<LimitPoint> points;
  std::vector<LimitForce> forces{};  // forces of members
};

// Whether it has members that can be strained.
bool has_members(const LimitProblem& problem);

inline constexpr int kFacets = 32;  // facets by default, and where whole cones have no solution

struct LimitSettings {
  // Number of facets of the pyramid inside the friction cone. A shear force between two of its edges is too small by up
  // to 1 - cos(pi/facets): 0.5 % of friction with 32. Edges lie along s and t where 4 divides the number, which is
  // exact for plane problems. 0: the whole cone, by cone_limit.h; where that finds no solution, pyramids of 32 facets.
  int facets = kFacets;
  bool facet_on_axis = false;  // whether the normal of the first facet, not its edge, lies along s
  // Whether to return the centre of all forces that give the multiplier, not a vertex: it changes little when strengths
  // do. With pyramids it has fewer digits. It permits negative friction.
  bool interior = false;
  // Compression at each point, N, or empty. Of all forces that give the multiplier, the result is nearest to these, and
  // members' forces to their starts, with the least shear. It takes whole cones, and permits negative friction. The
  // result is not_converged where cone_limit.h finds none. With members it may lose 2e-5 of the multiplier.
  std::vector<double> near{};
  double most =
      std::numeric_limits<double>::infinity();  // bound of the multiplier; a multiplier at the bound has no mechanism
  // Called after each step of an interior point method, from several threads at once. What it throws ends the analysis.
  // Empty: not.
  std::function<void(const std::string& step)> progress{};
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();

  void report(const std::string& step) const {
    if (progress) progress(step);
  }
  bool is_late() const { return std::chrono::steady_clock::now() > deadline; }
};

// The same settings, whose reports begin with the phase.
LimitSettings in_phase(LimitSettings settings, const std::string& phase);

enum class LimitStatus {
  solved,
  no_equilibrium,  // no forces carry the dead loads
  unbounded,       // no multiple of the live loads makes a mechanism
  not_converged,   // the solver stopped, or its solution has residuals
  late             // the deadline was reached
};

struct LimitResult {
  LimitStatus status = LimitStatus::not_converged;
  double multiplier = 0.0;
  double gap = 0.0;  // (upper - lower bound)/max(1, |multiplier|) of the programme
  int facets = 0;    // facets of the friction cones; 0: whole cones
  // Force on block a along n, s, t at each point, N: n > 0 is tension.
  std::vector<std::array<double, 3>> force;
  std::vector<double> member_force;  // by LimitProblem::forces
  // Mechanism: virtual velocity of the centre, and spin, of each block. They are scaled so that the largest velocity of
  // a centre or contact point is 1 (m/s, rad/s).
  std::vector<Wrench> velocity;  // force: velocity, moment: spin
  // Blocks out of balance (no_equilibrium), or blocks under a live load that makes no mechanism (unbounded); ascending.
  std::vector<int> blocks_concerned;
};

// Throws Error(bad_input) for indices out of range, values that are not finite, strengths below 0, no live load, fewer
// than 4 facets.
LimitResult limit_multiplier(const LimitProblem& problem, const LimitSettings& settings = {});

// Throws Error(numerical) where the solver ended without an answer: with residuals, or at the deadline.
void require_answer(const LimitResult& result);

// Units in programmes.
struct LimitUnits {
  double force = 1.0;       // N: the mean load of a free block, or the least strength of a point where that is far more
  double length = 1.0;      // m: the mean arm of a contact point
  double multiplier = 1.0;  // 1, or where live loads are far below that force, the multiplier that makes them equal
};
LimitUnits units_of(const LimitProblem& problem);

// Blocks that no chain of contact points and members connects to a fixed one; indices, ascending.
std::vector<int> unconnected_blocks(const LimitProblem& problem, const std::vector<int>& supports = {});

}  // namespace quoin
