// Openings of walls of half units, and their lintels.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scene/reader.h"

namespace quoin {

// Size of the wall of the openings; 0: its own keys are at fault.
struct Lattice {
  int half_units = 0, courses = 0;
  double half_unit = 0.0;  // m
};

// Reads all tables `opening` of a wall. Openings that do not fit are faults of the context.
std::vector<WallSpec::Opening> read_openings(reader::Table& wall, const Lattice& lattice,
                                             const std::map<std::string, BlockMaterial>& materials);

// Reads all tables `changed` of a wall with these openings: units that are missing or of another material.
std::vector<WallSpec::Changed> read_changed(reader::Table& wall, const Lattice& lattice, const WallSpec& spec,
                                            const std::map<std::string, BlockMaterial>& materials);

}  // namespace quoin
