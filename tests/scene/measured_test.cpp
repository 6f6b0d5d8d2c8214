// What the errors of the qualities speak of: the walls that they were measured on, and no others.
#include "scene/measured.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/read_scene.h"

namespace quoin {
namespace {

using ::testing::HasSubstr;

std::string outside(const std::string& scene, const std::vector<std::string>& overrides = {}) {
  return outside_measured(read_scene(std::string(QUOIN_SCENES) + "/" + scene + ".toml", overrides));
}

// The walls of benchmarks/error_against_cost.
TEST(Measured, WallsThatWereMeasuredAreInside) {
  for (const char* scene : {"solid_wall_030", "solid_wall_121", "solid_wall_212", "hollow_wall", "wall_2m_60",
                            "wall_2m_144", "wall_2m_240", "wall_2m_576", "ispra_isp1", "ispra_isp3"}) {
    EXPECT_EQ(outside(scene), "") << scene;
    EXPECT_EQ(outside(scene, {"solver.quality=fast"}), "") << scene;
    EXPECT_EQ(outside(scene, {"solver.quality=reference"}), "") << scene;
  }
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{"stage.shear.vertical=pressure"},
        {"wall.bond=stack"},
        {"wall.courses=32"},
        {"joints.mortar.tensile_strength=0.4e6", "joints.mortar.cohesion=0.6e6",
         "joints.mortar.fracture_energy_tension=30", "joints.mortar.fracture_energy_shear=250",
         "joints.mortar.compressive_strength=10e6", "joints.mortar.fracture_energy_compression=16000"},
        {"joints.mortar.normal_stiffness=164e9", "joints.mortar.shear_stiffness=72e9",
         "materials.brick.young_modulus=33.4e9"}})
    EXPECT_EQ(outside("solid_wall_121", overrides), "") << overrides[0];
}

TEST(Measured, OutsideTheFirstReasonIsNamed) {
  const struct {
    std::vector<std::string> overrides;
    const char* reason;
  } cases[] = {{{"solver.local_damping=0.4"}, "settings of quality standard changed"},
               {{"stage.shear.velocity=0.5"}, "settings of quality standard changed"},
               {{"wall.unit=[66, 0.0625, 0.1]"}, "wall.unit length = 66, measured from 0.22 to 0.66"},
               {{"wall.zones=[2, 1, 1]"}, "wall.zones"},
               {{"wall.courses=3"}, "wall.courses = 3"},
               {{"materials.brick.density=19"}, "materials.brick.density = 19"},
               {{"joints.mortar.law=elastic"}, "joints.mortar.law = elastic"},
               {{"joints.unit.law=coulomb_slip"}, "joints.unit.law = coulomb_slip"},
               {{"joints.mortar.cohesion=5e6"}, "joints.mortar.cohesion = 5e+06"},
               {{"joints.mortar.softening=exponential"}, "joints.mortar.softening"},
               {{"joints.mortar.friction_angle_residual=10"}, "joints.mortar.friction_angle_residual"},
               {{"joints.mortar.initial_state=dry"}, "initial_state"},
               {{"stage.precompression.pressure=1"}, "stage.precompression.pressure"},
               {{"stage.precompression.equilibrium_ratio=0.5"}, "equilibrium_ratio"},
               {{"stage.shear.ramp_time=0"}, "stage.shear.ramp_time = 0"},
               {{"stage.shear.displacement=1e-6"}, "displacement over the height"},
               {{"stage.shear.law=elastic"}, "stage.shear.law"},
               {{"stage.shear.gravity=[0.0, -9.81, 0.0]"}, "gravity"}};
  for (const auto& c : cases) EXPECT_THAT(outside("solid_wall_121", c.overrides), HasSubstr(c.reason));
  EXPECT_THAT(outside("hollow_wall", {"wall.opening.1.bearing=0.11"}), HasSubstr("measured without lintels"));
  EXPECT_THAT(outside("hollow_wall", {"wall.opening.1.half_units=4"}), HasSubstr("4 half units by 6 courses"));
  EXPECT_THAT(outside("hollow_wall", {"wall.opening.1.courses=7"}), HasSubstr("2 half units by 7 courses"));
  EXPECT_THAT(outside("pavia_door"), HasSubstr("building"));
  EXPECT_THAT(outside("cyclic_wall_121"), HasSubstr("settings of quality standard changed"));
}

}  // namespace
}  // namespace quoin
