// A tie: law of a bar along its axis. Equations: README.md.
#pragma once

#include <cstdint>
#include <limits>

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

}  // namespace quoin::members
