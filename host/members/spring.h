// Bedding of faces on the ground: a spring and dashpot at each of their points. Equations: README.md.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "members/member.h"
#include "members/placing.h"

namespace quoin::members {

// Law for the area of one point.
struct SpringLaw {
  double normal = 0.0, shear = 0.0;                           // N/m
  double normal_dashpot = 0.0, shear_dashpot = 0.0;           // N s/m
  double friction = std::numeric_limits<double>::infinity();  // largest shear over normal force
  std::uint64_t tension = 0;                                  // 1: it takes tension
};

// Energies in J.
struct SpringState {
  Vector moved;  // displacement of the point relative to the ground since the start, m
  Vector slid;   // slip along the face, a part of `moved`, m
  Vector force;  // force on the block, N
  double stored = 0.0, dissipated = 0.0;

  // Updates the state. out: outward normal of the block at the start, unit. now: displacement of the point relative to
  // the ground since the start, m. dt: time since the last call, s.
  void follow(const SpringLaw& law, const Vector& out, const Vector& now, double dt);
};

// One point of a face on springs.
struct SpringPoint {
  int node = 0;
  double area = 0.0;  // m2
  Vector out;         // outward normal of the block at the start, unit
  SpringLaw law;
  SpringState state;
};

// A [[spring]]: the points of its faces.
struct Bed {
  std::string name;
  std::vector<SpringPoint> points;
  double area = 0.0;           // m2
  double ground_work = 0.0;    // J
  double reckoned_step = 0.0;  // critical time step for which dashpots are reckoned, s

  void pull(std::vector<Node>& nodes, const Surroundings& step);
  Work work() const;
  Vector force() const { return force_of(points); }  // force on its blocks, N
  std::vector<double> columns() const;
  bool has_dashpots() const;

  template <class Visit>  // with 2/dt of dashpots
  void each_spring(const Visit& visit) const {
    const double rate = reckoned_step > 0.0 ? 2.0 / reckoned_step : 0.0;
    for (const SpringPoint& p : points)
      visit(p.node, kGround,
            std::max(p.law.normal + rate * p.law.normal_dashpot, p.law.shear + rate * p.law.shear_dashpot));
  }
  template <class Visit>
  void each_number(const Visit& visit) const {
    for (const SpringPoint& p : points) visit(p.state.slid.x), visit(p.state.slid.y), visit(p.state.slid.z);
  }
  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& s) {
    archive.values(s.ground_work, s.reckoned_step);
    for (auto& p : s.points) archive.value(p.state);
  }
};

Bed placed(const SpringSpec& spec, Placing& placing);
std::vector<std::string> column_names(const SpringSpec& spec);

}  // namespace quoin::members
