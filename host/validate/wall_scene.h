// A wall that was tested as a scene: units, joints by the rule, the rig as stages.
#pragma once

#include <string>

#include "properties/from_tests.h"
#include "validate/wall_table.h"

namespace quoin::validate {

struct TestScene {
  std::string text;  // TOML, a scene that `quoin run` takes
  MasonryNumbers numbers;
  double load_height = 0.0;       // m, where the horizontal force acts
  double top_displacement = 0.0;  // displacement of the top of the wall over that of the driven point
  double bed_area = 0.0;          // m2
  int half_units = 0;             // a measure of the cost
};

// cyclic: drifts that grow, by the law cyclic_joint; else pushed one way by fracture_energy. scatter: of a sample.
TestScene scene_of(const WallRow& row, bool cyclic, const ScatterFactor& scatter = {});

// Equilibrium of a rigid wall on its toe, kN: N L/(2 H0), and what its own weight adds.
double rocking_force(const WallRow& row);
double rocking_force_with_weight(const WallRow& row);

TestedMasonry tested_masonry(const WallRow& row);

}  // namespace quoin::validate
