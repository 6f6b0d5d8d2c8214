// Range of the measured errors of the qualities: the walls of the measurements are inside, other walls are not.
#include "scene/measured.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/read_scene.h"

namespace quoin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

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

// The ranges of the table of host/scenes/README.md: their ends are inside, 2 % beyond is not.
TEST(Measured, RangesAreThoseOfTheTable) {
  const struct {
    const char* key;  // key of the scene; for lengths of units the index in wall.unit
    double low, high;
    const char* named;
  } ranges[] = {
      {"wall.unit=[{}, 0.0625, 0.1]", 0.22, 0.66, "wall.unit length"},
      {"wall.unit=[0.22, {}, 0.1]", 0.0625, 0.2, "wall.unit height"},
      {"wall.unit=[0.22, 0.0625, {}]", 0.1, 0.25, "wall.unit thickness"},
      {"materials.brick.young_modulus={}", 2.4e9, 33.4e9, "young_modulus"},
      {"materials.brick.poisson_ratio={}", 0.15, 0.2, "poisson_ratio"},
      {"materials.brick.density={}", 1750, 1900, "density"},
      {"joints.mortar.normal_stiffness={}", 20e9, 164e9, "joints.mortar.normal_stiffness"},
      {"joints.mortar.shear_stiffness={}", 8e9, 72e9, "joints.mortar.shear_stiffness"},
      {"joints.mortar.tensile_strength={}", 0.05e6, 0.4e6, "joints.mortar.tensile_strength"},
      {"joints.mortar.cohesion={}", 0.15e6, 0.6e6, "joints.mortar.cohesion"},
      {"joints.mortar.friction_angle={}", 30, 35, "joints.mortar.friction_angle"},
      {"joints.mortar.compressive_strength={}", 5e6, 10e6, "joints.mortar.compressive_strength"},
      {"joints.mortar.fracture_energy_tension={}", 5, 30, "joints.mortar.fracture_energy_tension"},
      {"joints.mortar.fracture_energy_shear={}", 20, 250, "joints.mortar.fracture_energy_shear"},
      {"joints.mortar.fracture_energy_compression={}", 8e3, 16e3, "joints.mortar.fracture_energy_compression"},
      {"joints.unit.normal_stiffness={}", 120e9, 1000e9, "joints.unit.normal_stiffness"},
      {"joints.unit.shear_stiffness={}", 50e9, 1000e9, "joints.unit.shear_stiffness"},
      {"joints.unit.tensile_strength={}", 1e6, 2e6, "joints.unit.tensile_strength"},
      {"joints.unit.cohesion={}", 1.5e6, 3e6, "joints.unit.cohesion"},
      {"joints.unit.friction_angle={}", 35, 35, "joints.unit.friction_angle"},
      {"joints.unit.compressive_strength={}", 12e6, 15e6, "joints.unit.compressive_strength"},
      {"joints.unit.fracture_energy_tension={}", 80, 80, "joints.unit.fracture_energy_tension"},
      {"joints.unit.fracture_energy_shear={}", 125, 550, "joints.unit.fracture_energy_shear"},
      {"joints.unit.fracture_energy_compression={}", 19e3, 21e3, "joints.unit.fracture_energy_compression"},
      {"wall.courses={}", 9, 32, "wall.courses"},
      {"wall.units_per_course={}", 2.5, 9, "wall.units_per_course"}};
  for (const auto& r : ranges) {
    const std::string key = r.key;
    const auto reason = [&](double value) {
      const std::string number = std::string(key).find("courses") == std::string::npos ? fmt::format("{:.6f}", value)
                                                                                       : fmt::format("{:g}", value);
      return outside("solid_wall_121", {fmt::format(fmt::runtime(key), number)});
    };
    const bool whole = key.starts_with("wall.courses"), halves = key.starts_with("wall.units_per");
    const double beyond = whole ? 1.0 : halves ? 0.5 : 0.0;
    for (const double inside : {r.low, r.high})
      EXPECT_THAT(reason(inside), Not(HasSubstr(std::string(r.named) + " =")));
    for (const double out : {beyond > 0 ? r.low - beyond : 0.98 * r.low, beyond > 0 ? r.high + beyond : 1.02 * r.high})
      EXPECT_THAT(reason(out),
                  HasSubstr(fmt::format("{} = {:g}, measured from {:g} to {:g}", r.named, out, r.low, r.high)))
          << out;
  }
  // 0.3 to 2.12 MPa on the whole bed; 0.25 to 2 % of the height of 16 courses of 62.5 mm.
  EXPECT_EQ(outside("solid_wall_121", {"stage.precompression.pressure=0.3e6"}), "");
  EXPECT_EQ(outside("solid_wall_121", {"stage.precompression.pressure=2.12e6"}), "");
  EXPECT_THAT(outside("solid_wall_121", {"stage.precompression.pressure=0.29e6"}), HasSubstr("pressure = 290000,"));
  EXPECT_THAT(outside("solid_wall_121", {"stage.precompression.pressure=2.16e6"}), HasSubstr("pressure = 2.16e+06,"));
  EXPECT_EQ(outside("solid_wall_121", {"stage.shear.displacement=0.0025"}), "");
  EXPECT_EQ(outside("solid_wall_121", {"stage.shear.displacement=0.02"}), "");
  EXPECT_THAT(outside("solid_wall_121", {"stage.shear.displacement=0.0024"}), HasSubstr("wall = 0.0024, measured"));
  EXPECT_THAT(outside("solid_wall_121", {"stage.shear.displacement=0.021"}), HasSubstr("wall = 0.021, measured"));
}

}  // namespace
}  // namespace quoin
