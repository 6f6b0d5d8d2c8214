// A bar across a joint: elastic-plastic along its axis and in shear. Equations: README.md.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "members/member.h"
#include "members/placing.h"

namespace quoin::members {

struct DowelLaw {
  double axial = 0.0, shear = 0.0;              // N/m
  double yield_force = 0.0, yield_shear = 0.0;  // N
};

// Energies in J.
struct DowelState {
  double drawn = 0.0;  // plastic elongation, m
  Vector slid;         // plastic slip across the bar, m
  double force = 0.0;  // N, tension positive
  Vector shear;        // force on the first block, N
  double stored = 0.0, dissipated = 0.0;

  // Updates the state. along: unit vector of the bar; apart: motion of the second block relative to the first, m; both
  // in the frame of the first block.
  void follow(const DowelLaw& law, const Vector& along, const Vector& apart);
};

struct Dowel {
  std::string name;
  int first = 0, second = 0;  // nodes, at one place at the start
  Vector along;               // unit, from the first to the second
  double drawn_length = 0.0;  // length in drawings, m
  DowelLaw law;
  DowelState state;

  void pull(std::vector<Node>& nodes, const Surroundings& step);
  Work work() const { return {state.stored, state.dissipated, 0.0}; }
  std::vector<double> columns() const { return {state.force, norm(state.shear)}; }
  std::vector<Line> lines(const std::vector<Node>& nodes) const;

  template <class Visit>
  void each_joint(const Visit& visit) const {
    visit(first, second);
  }
  template <class Visit>
  void each_spring(const Visit& visit) const {
    visit(first, second, std::max(law.axial, law.shear));
  }
  template <class Visit>
  void each_number(const Visit& visit) const {
    visit(state.force), visit(state.drawn), visit(norm(state.slid));
  }
  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& s) {
    archive.value(s.state);
  }
};

Dowel placed(const DowelSpec& spec, Placing& placing);
std::vector<std::string> column_names(const DowelSpec& spec);

}  // namespace quoin::members
