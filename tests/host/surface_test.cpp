// What files and pictures say of joints.
#include "results/surface.h"

#include <gtest/gtest.h>

#include "support.h"

namespace quoin {
namespace {

// A joint that is pulled open for the first time carries (1 - damage) of its tensile strength, whatever the shape of
// softening.
TEST(Surfaces, DamageIsTheShareOfTheStrengthThatIsLost) {
  const std::vector<PropertySetting> table{{"softening", {}, "table", {}},
                                           {"softening_table", {0.0, 1.0, 0.3, 0.5, 1.0, 0.0}, "", {}}};
  for (const std::vector<PropertySetting>& shape :
       {std::vector<PropertySetting>{}, {{"softening", {}, "exponential", {}}}, table}) {
    JointFamily family = mortar_family();
    family.properties.insert(family.properties.end(), shape.begin(), shape.end());
    const Assembly assembly = brick_grid({2, 1, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1}, family);
    Simulation simulation(bare_scene(), assembly);
    for (int n = 0; n < 12; ++n) simulation.displacement()[dof(simulation.model(), 1, n, 0)] = 30e-6;
    simulation.advance(1);
    for (const JointPoint& p : Surfaces(simulation).joint_points(simulation)) {
      EXPECT_NEAR(p.damage_tension, 1.0 - p.contact.traction[0] / 0.2e6, 1e-9) << shape.size();
      EXPECT_GT(p.damage_tension, 0.1);
      EXPECT_LT(p.damage_tension, 0.9);
    }
  }
}

// The brittle law has lost all at once, or nothing; a law that never fails loses nothing.
TEST(Surfaces, DamageOfLawsWithoutSofteningIsAllOrNothing) {
  for (const char* law : {"coulomb_slip", "elastic"}) {
    JointFamily family = elastic_family();
    family.law = law;
    if (family.law == "coulomb_slip") {
      for (const auto& [id, value] : {std::pair{"tensile_strength", 0.2e6}, {"cohesion", 0.3e6}})
        family.properties.push_back({id, {value}, "", {}});
    }
    const Assembly assembly = brick_grid({2, 1, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1}, family);
    Simulation simulation(bare_scene(), assembly);
    for (int n = 0; n < 12; ++n) simulation.displacement()[dof(simulation.model(), 1, n, 0)] = 30e-6;
    simulation.advance(1);
    const auto damage = simulation.damage();
    const double expected = family.law == "coulomb_slip" ? 1.0 : 0.0;
    ASSERT_GT(simulation.point_count(), 0);
    for (std::size_t i = 0; i < damage[0].size(); ++i) {
      EXPECT_EQ(damage[QUOIN_DAMAGE_TENSION][i], expected) << law;
      EXPECT_EQ(damage[QUOIN_DAMAGE_COHESION][i], expected) << law;
      EXPECT_EQ(damage[QUOIN_DAMAGE_CRUSHING][i], 0.0) << law;
    }
  }
}

}  // namespace
}  // namespace quoin
