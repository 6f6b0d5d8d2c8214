// Soil on faces: its force at each of their points. Equations: README.md.
#pragma once

#include <string>
#include <vector>

#include "members/member.h"
#include "members/placing.h"

namespace quoin::members {

struct FillLaw {
  Vector up, out;                                     // unit: upwards in the soil; level part of the face's normal
  double upright = 0.0, level = 0.0;                  // area of the face seen from above and from the side, m2
  double vertical = 0.0;                              // vertical stress of the soil at the point, Pa
  double at_rest = 0.0, active = 0.0, passive = 0.0;  // horizontal over vertical stress
  double stiffness = 0.0;                             // Pa/m
};

// Energies in J.
struct FillState {
  double pressure = 0.0;  // horizontal, Pa
  double slid = 0.0;      // plastic displacement into the soil, m
  double jack = 0.0;      // displacement that preloads the soil to its pressure at rest, m
  Vector force;           // force on the block, N
  Vector moved;           // displacement of the point since the start, m
  double stored = 0.0, dissipated = 0.0, outside = 0.0;

  // Updates the state. share: share of the soil's weight that acts; now: displacement of the point since the start, m.
  void follow(const FillLaw& law, double share, const Vector& now);
};

// One point of a face under or beside soil.
struct FillPoint {
  int node = 0;
  FillLaw law;
  FillState state;
};

// A [[fill]]: the points of its faces.
struct Fill {
  std::string name;
  std::vector<FillPoint> points;
  double area = 0.0;  // m2

  void pull(std::vector<Node>& nodes, const Surroundings& step);
  Work work() const;
  Vector force() const { return force_of(points); }  // force on its blocks, N
  std::vector<double> columns() const;

  template <class Visit>
  void each_spring(const Visit& visit) const {
    for (const FillPoint& p : points) visit(p.node, kGround, p.law.level * p.law.stiffness);
  }
  template <class Visit>
  void each_number(const Visit& visit) const {
    for (const FillPoint& p : points) visit(p.state.pressure), visit(p.state.slid);
  }
  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& s) {
    for (auto& p : s.points) archive.value(p.state);
  }
};

Fill placed(const FillSpec& spec, Placing& placing);
std::vector<std::string> column_names(const FillSpec& spec);

}  // namespace quoin::members
