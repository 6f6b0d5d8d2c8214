// Scene of a tested wall: units, joints by properties/from_tests.h, the test rig as stages.
#pragma once

#include <string>

#include "properties/from_tests.h"
#include "validate/wall_table.h"

namespace quoin::validate {

struct TestScene {
  std::string text;  // TOML, input of `quoin run`
  MasonryNumbers numbers;
  double load_height = 0.0;       // m, where the horizontal force acts
  double top_displacement = 0.0;  // displacement of the top of the wall over that of the driven point
  double bed_area = 0.0;          // m2
  int half_units = 0;             // measure of the cost
};

// cyclic: growing drifts, with the law cyclic_joint; otherwise pushed one way, with fracture_energy. scatter: of a
// random sample.
TestScene scene_of(const WallRow& row, bool cyclic, const ScatterFactor& scatter = {});

// Peak force of a rigid wall that rocks on its toe, kN: N L/(2 H0); in the second function with the wall's own weight.
double rocking_force(const WallRow& row);
double rocking_force_with_weight(const WallRow& row);

TestedMasonry tested_masonry(const WallRow& row);

}  // namespace quoin::validate
