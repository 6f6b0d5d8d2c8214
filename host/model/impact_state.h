// Impact damping in large motion.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "model/maxwell.h"

namespace quoin::blocks {

struct Contact;
struct Family;
struct World;

// Impact damping. That of the settings is chosen when they change, the share in use with the time step. PairPlace has
// the viscosity of each pair.
struct ImpactState {
  // Of the settings: squared frequencies of landing by family, then by block, normal to the joint and along it, 1/s2.
  std::vector<std::array<double, 2>> landing;
  double zone_beta = 0.0;  // of the settings: stiffness-proportional damping of zones, s
  double share = 1.0;      // damping in use over that of the settings
  double stable_dt = 0.0;  // largest stable step under this damping, s
  std::array<MaxwellElement, kMaxwellElements> maxwell{};
};

void choose_impact_damping(World& w);
// Viscosity over stiffness for a pair with points, normal to the joint and along it, s.
std::array<double, 2> viscosity_of_pair(const World& w, const Contact& c);
// Stiffness of a contact point, as drawn for it, normal to the joint and along it, Pa/m.
std::array<double, 2> stiffness_of_point(const Family& f, size_t point);
// Viscosity in use over stiffness by contact point, family after family, s. One process.
std::vector<std::array<double, 2>> impact_viscosities(const World& w);
// Share of critical that the time step leaves of solver.impact_damping; 0: damping is not that of impacts.
double impact_damping_in_use(const World& w);

}  // namespace quoin::blocks
