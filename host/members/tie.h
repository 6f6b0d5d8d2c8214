// A tie: a bar between blocks, with a law along its axis. Equations: README.md.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "members/member.h"
#include "members/placing.h"

namespace quoin::members {

struct TieLaw {
  double stiffness = 0.0;                                    // E A / L, N/m
  double yield = 0.0;                                        // N
  double hardening = 0.0;                                    // slope of the yield force over plastic elongation, N/m
  double pretension = 0.0;                                   // N
  double rupture = std::numeric_limits<double>::infinity();  // elongation at rupture, pretension included, m
  double slack = 0.0;                                        // m
  bool compression = false;
};

// All but the force is history. Energies in J.
struct TieState {
  double force = 0.0;        // N, tension positive
  double plastic = 0.0;      // plastic elongation, m
  double shortening = 0.0;   // shortening by the jack, m; pretension over stiffness in the end
  std::uint64_t broken = 0;  // 1: it is
  double stored = 0.0, dissipated = 0.0;
  double jack_work = 0.0;

  // Updates the state. elongation: between the ends, since the start, m. jack: share of the pretension, 0 to 1.
  void follow(const TieLaw& law, double elongation, double jack);
};

struct Tie {
  // Nodes of a stop, each with its share of the tie's force.
  using Stop = std::vector<std::pair<int, double>>;
  std::string name;
  std::vector<Stop> stops;  // the first and the last are its ends; it slides through the others
  double length = 0.0;      // length at the start, m
  TieLaw law;
  TieState state;

  void pull(std::vector<Node>& nodes, const Surroundings& step);
  Work work() const { return {state.stored, state.dissipated, state.jack_work}; }
  std::vector<double> columns() const { return {state.force}; }
  std::vector<Line> lines(const std::vector<Node>& nodes) const;

  template <class Visit>
  void each_joint(const Visit& visit) const {
    for (const Stop& stop : stops) {
      for (const auto& [node, share] : stop) visit(stops.front().front().first, node);
    }
  }
  // Its stiffness is k g g', g its direction at each node. It is bounded by k |g_i| sum |g_j| to the ground at each
  // node.
  template <class Visit>
  void each_spring(const Visit& visit) const {
    const std::size_t last = stops.size() - 1;
    if (last == 1 && stops[0].size() == 1 && stops[1].size() == 1)
      return visit(stops[0][0].first, stops[1][0].first, law.stiffness);
    const auto sum = static_cast<double>(2 * last);
    for (std::size_t i = 0; i <= last; ++i) {
      for (const auto& [node, share] : stops[i])
        visit(node, kGround, law.stiffness * sum * share * (i == 0 || i == last ? 1.0 : 2.0));
    }
  }
  template <class Visit>
  void each_number(const Visit& visit) const {
    visit(state.force), visit(state.plastic);
  }
  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& s) {
    archive.value(s.state);
  }
};

// Places of a stop: at the start, and current, m.
Vector start_of(const std::vector<Node>& nodes, const Tie::Stop& stop);
Vector place_of(const std::vector<Node>& nodes, const Tie::Stop& stop);

Tie placed(const TieSpec& spec, Placing& placing);
std::vector<std::string> column_names(const TieSpec& spec);

}  // namespace quoin::members
