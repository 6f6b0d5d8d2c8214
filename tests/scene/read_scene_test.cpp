// Reader of scenes, and every kind of fault: the message has file:line, key, value and the allowed values.
#include "scene/read_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "scene/driven.h"
#include "scene/quality.h"
#include "scene/stage_warnings.h"
#include "scene/unused_settings.h"

namespace quoin {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// Tests expect the line numbers of this text.
const char* const kScene = R"(title = "small"
[materials.brick]
young_modulus = 16.7e9
poisson_ratio = 0.15
density = 1900
[joints.mortar]
law = "elastic"
normal_stiffness = 82e9
shear_stiffness = 36e9
[wall]
courses = 2
units_per_course = 1.5
unit = [0.2, 0.1, 0.1]
mid_unit_joints = false
unit_material = "brick"
bed_joint = "mortar"
head_joint = "mortar"
beam_joint = "mortar"
[[stage]]
name = "press"
kind = "pressure"
pressure = 1e5
[[stage]]
kind = "shear"
velocity = 0.01
displacement = 0.001
)";

class ReadScene : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("quoin_scene_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
               std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Scene read(const std::string& text, const std::vector<std::string>& overrides = {}) {
    const std::string file = (folder_ / "s.toml").string();
    std::ofstream(file) << text;
    return read_scene(file, overrides);
  }

  // Returns the message for the scene with `from` replaced by `to`.
  std::string fault(const std::string& from, const std::string& to, const std::vector<std::string>& overrides = {}) {
    std::string text = kScene;
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return message(text, overrides);
  }
  std::string message(const std::string& text, const std::vector<std::string>& overrides = {}) {
    try {
      read(text, overrides);
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      return error.what();
    }
    ADD_FAILURE() << "accepted";
    return {};
  }

  std::filesystem::path folder_;
};

TEST_F(ReadScene, FoldersAndMissingFilesAreNoScenes) {
  for (const std::filesystem::path& path : {folder_, folder_ / "none.toml"}) {
    try {
      read_scene(path.string(), {});
      ADD_FAILURE() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      EXPECT_EQ(error.what(), path.string() + ": cannot read it: " +
                                  (path == folder_ ? "it is a folder; give a file" : "no such file"));
    }
  }
}

TEST_F(ReadScene, FillsTheStructs) {
  const Scene s = read(kScene);
  EXPECT_EQ(s.title, "small");
  EXPECT_EQ(s.materials.at("brick").density, 1900);
  EXPECT_EQ(s.quality, "standard");
  EXPECT_EQ(s.solver.deformation_inertia, 64.0);
  EXPECT_EQ(s.solver.unit_inertia, 16.0);
  EXPECT_EQ(s.solver.settling_damping, 0.5);
  EXPECT_FALSE(s.quality_as_is);  // the shear stage has its own velocity
  EXPECT_EQ(s.wall->zones, (std::array<int, 3>{4, 2, 2}));
  const JointFamily& mortar = s.joints.at("mortar");
  ASSERT_EQ(mortar.properties.size(), 2u);
  EXPECT_EQ(mortar.properties[0].id, "normal_stiffness");
  EXPECT_EQ(mortar.properties[0].numbers, std::vector<double>{82e9});
  EXPECT_THAT(mortar.properties[0].source.text, HasSubstr("s.toml:8: joints.mortar.normal_stiffness"));

  ASSERT_EQ(s.stages.size(), 2u);
  const Stage& press = s.stages[0];
  EXPECT_EQ(press.name, "press");
  ASSERT_TRUE(press.equilibrium_ratio);
  const BodyControl& top = press.controls.at(1);
  EXPECT_EQ(top.body, "top_beam");
  EXPECT_EQ(top.kind[1], DofKind::free);
  EXPECT_DOUBLE_EQ(top.force[1], -1e5 * 0.3 * 0.1);  // downwards, on the gross bed area
  const Stage& shear = s.stages[1];
  EXPECT_EQ(shear.controls.at(1).kind[1], DofKind::velocity);  // vertical displacement held
  EXPECT_EQ(shear.controls.at(1).velocity, (Vec3{0.01, 0, 0}));
  EXPECT_EQ(shear.displacement, 0.001);
}

TEST_F(ReadScene, PropertiesMayBeWordsAndTables) {
  const Scene s = read(kScene, {"joints.mortar.softening=exponential", "joints.mortar.softening_table=[[0, 1], [1, 0]]",
                                "joints.mortar.compressive_strength=inf"});
  std::map<std::string, PropertySetting> p;
  for (const auto& setting : s.joints.at("mortar").properties) p[setting.id] = setting;
  EXPECT_EQ(p["softening"].text, "exponential");
  EXPECT_EQ(p["softening_table"].numbers, (std::vector<double>{0, 1, 1, 0}));
  EXPECT_TRUE(std::isinf(p["compressive_strength"].numbers.at(0)));
}

TEST_F(ReadScene, OverridesByNumberAndByName) {
  const Scene s = read(kScene, {"stage.2.velocity=0.5", "stage.press.pressure=3e5", "wall.bond=stack",
                                "solver.damping=none", "output.frames=0"});
  EXPECT_EQ(s.stages[1].controls.at(1).velocity[0], 0.5);
  EXPECT_DOUBLE_EQ(s.stages[0].controls.at(1).force[1], -3e5 * 0.03);
  EXPECT_EQ(s.wall->bond, "stack");
  EXPECT_EQ(s.solver.damping, DampingKind::none);
  EXPECT_EQ(s.output.frames, 0);
}

TEST_F(ReadScene, OverridesOfNamesWithADotAreInQuotes) {
  std::string text = kScene;
  for (size_t at; (at = text.find("\"mortar\"")) != std::string::npos;) text.replace(at, 8, "\"lime.1\"");
  text.replace(text.find("[joints.mortar]"), 15, "[joints.\"lime.1\"]");
  for (const std::string key : {R"(joints."lime.1".normal_stiffness)", "joints.'lime.1'.normal_stiffness"}) {
    const std::vector<PropertySetting> properties = read(text, {key + "=5e9"}).joints.at("lime.1").properties;
    const auto found = std::ranges::find(properties, "normal_stiffness", &PropertySetting::id);
    ASSERT_NE(found, properties.end()) << key;
    EXPECT_EQ(found->numbers, std::vector{5e9}) << key;
  }
  EXPECT_THAT(message(kScene, {R"(joints."mortar.normal_stiffness=5e9)"}), HasSubstr("no key or no value"));
  EXPECT_THAT(message(kScene, {R"(joints."mortar"x.normal_stiffness=5e9)"}), HasSubstr("no key or no value"));
}

TEST_F(ReadScene, QualityGivesDefaultsThatKeysOverride) {
  const Scene reference = read(kScene, {"solver.quality=reference"});
  EXPECT_EQ(reference.solver.damping, DampingKind::local);
  EXPECT_EQ(reference.solver.deformation_inertia, 1.0);
  EXPECT_EQ(reference.solver.time_step_fraction, 0.4);
  const Scene local = read(kScene, {"solver.damping=local"});
  EXPECT_EQ(local.solver.deformation_inertia, 1.0);
  EXPECT_EQ(local.solver.local_damping, 0.8);
  EXPECT_FALSE(local.solver.settling_damping);
  for (const std::string other : {"solver.damping=local", "solver.selective_time_step=1e-5"}) {
    for (const std::string factor : {"solver.deformation_inertia", "solver.unit_inertia"})
      EXPECT_THAT(message(kScene, {other, factor + "=4"}), HasSubstr(factor + " = 4")) << other;
  }
  EXPECT_THAT(message(kScene, {"solver.quality=best"}), HasSubstr("fast, standard, reference"));
  EXPECT_THROW(quality_named("best"), Error);
}

TEST_F(ReadScene, NodalTimeStepOnlyWhereInertiaIsTrue) {
  EXPECT_EQ(read(kScene).solver.critical_time_step, CriticalTimeStep::assembled);
  const std::string nodal = "solver.critical_time_step=nodal";
  EXPECT_EQ(read(kScene, {nodal, "solver.damping=local"}).solver.critical_time_step, CriticalTimeStep::nodal);
  EXPECT_EQ(read(kScene, {nodal, "solver.quality=reference"}).solver.critical_time_step, CriticalTimeStep::nodal);
  for (const char* other : {"solver.quality=standard", "solver.selective_time_step=1e-5"})
    EXPECT_THAT(message(kScene, {nodal, other}), HasSubstr("solver.critical_time_step = 'nodal'")) << other;
  EXPECT_THAT(message(kScene, {"solver.critical_time_step=eq3"}), HasSubstr("assembled"));
}

// Two steps of 10 s ended a stage of 0.02 s, and 1e300 gave NaN, in silence.
TEST_F(ReadScene, SelectiveTimeStepsAreShorterThanTheirStages) {
  const std::string step = "solver.selective_time_step=", duration = "stage.1.duration=0.02";
  EXPECT_THAT(message(kScene, {step + "10"}), HasSubstr("a number, 0 to 1, s"));
  EXPECT_THAT(message(kScene, {step + "1e300"}), HasSubstr("a number, 0 to 1, s"));
  EXPECT_THAT(
      message(kScene, {step + "3e-3", duration}),
      AllOf(HasSubstr("stage.1: solver.selective_time_step = 0.003 s"), HasSubstr("a tenth"), HasSubstr("0.02 s")));
  EXPECT_EQ(read(kScene, {step + "2e-3", duration}).solver.selective_time_step, 2e-3);
}

TEST_F(ReadScene, DensitiesOfBeamsEndWhereThoseOfMaterialsDo) {
  EXPECT_THAT(message(kScene, {"wall.beam_density=1e10"}), HasSubstr("more than 0 and at most 1000000000"));
}

TEST_F(ReadScene, UnknownKey) {
  EXPECT_THAT(fault("courses = 2", "courses = 2\ncurses = 3"),
              AllOf(HasSubstr("s.toml:12: wall.curses = 3"), HasSubstr("unknown key"),
                    HasSubstr("did you mean 'courses'?"), HasSubstr("units_per_course")));
  EXPECT_THAT(fault("title", "titel"), HasSubstr("s.toml:1: titel = "));
}

TEST_F(ReadScene, WrongType) {
  EXPECT_THAT(fault("density = 1900", "density = \"heavy\""),
              AllOf(HasSubstr("s.toml:5: materials.brick.density = 'heavy'"), HasSubstr("wrong type, text"),
                    HasSubstr("more than 0"), HasSubstr("kg/m3")));
  EXPECT_THAT(fault("courses = 2", "courses = 2.5"), HasSubstr("wall.courses = 2.5: wrong type"));
  EXPECT_THAT(fault("[0.2, 0.1, 0.1]", "[0.2, 0.1]"), HasSubstr("a list of 3 numbers"));
  EXPECT_THAT(fault("normal_stiffness = 82e9", "normal_stiffness = true"),
              HasSubstr("s.toml:8: joints.mortar.normal_stiffness = true: wrong type"));
  EXPECT_THAT(fault("[wall]\n", "[wall]\nopening = 3\n"), HasSubstr("wall.opening = 3: wrong type"));
}

TEST_F(ReadScene, OutOfRange) {
  EXPECT_THAT(fault("courses = 2", "courses = -2"),
              AllOf(HasSubstr("s.toml:11: wall.courses = -2"), HasSubstr("1 to 10000")));
  EXPECT_THAT(fault("= 0.15", "= 0.6"), HasSubstr("0 to 0.49"));
  EXPECT_THAT(fault("pressure = 1e5", "pressure = nan"), HasSubstr("stage.1.pressure = nan"));
  EXPECT_THAT(fault("= 1.5", "= 1.3"), HasSubstr("multiple of 0.5"));
  EXPECT_THAT(message(kScene, {"solver.time_step_fraction=1.5"}),
              AllOf(HasSubstr("--set: solver.time_step_fraction = 1.5"), HasSubstr("more than 0 and at most 1")));
  for (const char* value : {"-0.01", "1.01", "nan"})
    EXPECT_THAT(
        message(kScene, {std::string("output.frames_at_damage=") + value}),
        AllOf(HasSubstr(std::string("--set: output.frames_at_damage = ") + value), HasSubstr("a number, 0 to 1")));
}

// 2^53 + 1 is halfway between two doubles and rounds to the even one, 2^53, as in strtod.
TEST_F(ReadScene, IntegersThatNoDoubleEqualsAreRounded) {
  const double rounded = 9007199254740992.0;
  const Scene s =
      read(kScene, {"stage.press.pressure=9007199254740993", "stage.1.gravity=[0, -9007199254740993, 0]",
                    "joints.mortar.normal_stiffness=9007199254740993",
                    "joints.mortar.softening_table=[[0, 9007199254740993], [1, 0]]", "solver.mass_scaling=1000000000"});
  EXPECT_DOUBLE_EQ(s.stages[0].controls.at(1).force[1], -rounded * 0.03);
  EXPECT_EQ(s.stages[0].gravity, (Vec3{0, -rounded, 0}));
  EXPECT_EQ(s.solver.mass_scaling, 1e9);
  std::map<std::string, PropertySetting> p;
  for (const auto& setting : s.joints.at("mortar").properties) p[setting.id] = setting;
  EXPECT_EQ(p["normal_stiffness"].numbers, std::vector<double>{rounded});
  EXPECT_EQ(p["softening_table"].numbers, (std::vector<double>{0, rounded, 1, 0}));
  const Scene custom = read(std::string(kScene) +
                            "[[stage]]\nkind = \"custom\"\nduration = 0.1\n[[stage.control]]\nbody = \"top_beam\"\n"
                            "velocity = [9007199254740993, \"free\", 0]\nforce = [0, -9007199254740993, 0]\n");
  EXPECT_EQ(custom.stages[2].controls.at(0).velocity[0], rounded);
  EXPECT_EQ(custom.stages[2].controls.at(0).force[1], -rounded);
}

TEST_F(ReadScene, IntegersThatNoDoubleEqualsKeepToTheRange) {
  EXPECT_THAT(fault("density = 1900", "density = -9007199254740993"),
              AllOf(HasSubstr("s.toml:5: materials.brick.density = -9007199254740993"), HasSubstr("more than 0")));
  EXPECT_THAT(fault("pressure = 1e5", "pressure = -9007199254740993"), HasSubstr("0 or more"));
  EXPECT_THAT(fault("courses = 2", "courses = 9007199254740993"), HasSubstr("1 to 10000"));
  EXPECT_THAT(fault("courses = 2", "courses = 9223372036854775807"), HasSubstr("1 to 10000"));
  EXPECT_THAT(fault("[0.2, 0.1, 0.1]", "[0.2, 9007199254740993, 0.1]"), HasSubstr("more than 0 and at most 100"));
  EXPECT_THAT(message(kScene, {"wall.zones=[4, -9007199254740993, 2]"}),
              AllOf(HasSubstr("--set: wall.zones"), HasSubstr("1 to 64")));
  EXPECT_THAT(fault("courses = 2", "courses = 92233720368547758070"), HasSubstr("not valid TOML"));
}

TEST_F(ReadScene, PropertiesThatAreNoNumbers) {
  EXPECT_THAT(fault("82e9", "nan"), HasSubstr("s.toml:8: joints.mortar.normal_stiffness = nan"));
  for (const char* table : {"[[0, 1], [nan, 0]]", "[0, 1, 1, nan]"}) {
    EXPECT_THAT(message(kScene, {std::string("joints.mortar.softening_table=") + table}),
                AllOf(HasSubstr("--set: joints.mortar.softening_table"), HasSubstr("nan")));
  }
  // As a flat list these would be [0, 1, 1, 0].
  EXPECT_THAT(message(kScene, {"joints.mortar.softening_table=[[0], [1, 1, 0]]"}), HasSubstr("a list of pairs"));
}

TEST_F(ReadScene, AnOverrideByAnAmbiguousNameIsRefused) {
  const std::string twice = std::string(kScene) + "[[stage]]\nname = \"press\"\nkind = \"pressure\"\npressure = 1\n";
  EXPECT_THAT(message(twice, {"stage.press.pressure=3e5"}),
              AllOf(HasSubstr("'press' fits elements 1 and 3"), HasSubstr("use the number")));
  EXPECT_NO_THROW(read(twice, {"stage.3.pressure=3e5"}));
}

TEST(ReadBuilding, WallsAndFloorsHaveNamesOfTheirOwn) {
  const auto fault = [](const std::string& setting) -> std::string {
    try {
      read_scene(QUOIN_SCENES "/pavia_window.toml", {setting});
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(fault("building.wall.2.name=B"), HasSubstr("building.wall.2: a second wall 'B'"));
  EXPECT_THAT(fault("building.floor.1.course=-1"),
              HasSubstr("building.floor.1.course = -1: allowed: an integer, 0 to 39"));
  // Wall B has 28 half units.
  for (const char* list : {"[28]", "[-1]"})
    EXPECT_THAT(fault(std::string("building.floor.1.half_units=") + list),
                HasSubstr("a list of integers, each 0 to 27"));
  EXPECT_THAT(fault("building.floor.2.name=floor_1"),
              HasSubstr("building.floor.2.name = 'floor_1': allowed: a name that"));
}

// The default monitor of a stage with ground motion is a beam of the last floor, so a floor without beams is refused.
TEST(ReadBuilding, FloorWithoutBeamsIsNamedWhereTheGroundMoves) {
  try {
    read_scene(QUOIN_SCENES "/pavia_floors.toml", {"building.floor.2.half_units=[]"});
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("building.floor.2.half_units = []: wrong type, a list; allowed: a list of integers"));
  }
}

// Defaults are those of host/scenes/README.md.
TEST_F(ReadScene, WhatIsLeftOutIsAsThePageSays) {
  const Scene s = read(std::string(kScene) +
                       "[[wall.opening]]\nfirst_half_unit = 1\nhalf_units = 1\nfirst_course = 0\n"
                       "courses = 1\n[[damage]]\ncrack = [[0, 0], [0.1, 0.1]]\n");
  const SolverSettings& solver = s.solver;
  EXPECT_EQ(solver.time_step_fraction, 0.86);
  EXPECT_EQ(solver.critical_time_step, CriticalTimeStep::assembled);
  EXPECT_EQ(solver.mass_scaling, 1.0);
  EXPECT_EQ(solver.selective_time_step, 0.0);
  EXPECT_EQ(solver.internal_forces, InternalForces::automatic);
  EXPECT_TRUE(solver.skip_resting_bodies);
  EXPECT_EQ(solver.damping, DampingKind::block);
  EXPECT_EQ(solver.local_damping, 0.3);
  EXPECT_EQ(solver.deformation_damping, 0.2);
  EXPECT_EQ(solver.mass_damping, 0.0);
  EXPECT_EQ(solver.stiffness_damping, 0.0);
  EXPECT_EQ(solver.large_motion, LargeMotion::automatic);
  EXPECT_EQ(solver.kernels, Kernels::automatic);
  EXPECT_EQ(solver.motion_bound.rotation, 0.013);
  EXPECT_EQ(solver.motion_bound.sliding, 0.03);
  EXPECT_TRUE(solver.motion_bound.stop);
  const SolverSettings viscous = read(kScene, {"solver.damping=viscous"}).solver;  // the brackets
  EXPECT_EQ(viscous.time_step_fraction, 0.6);
  EXPECT_EQ(viscous.deformation_inertia, 1.0);
  EXPECT_EQ(viscous.unit_inertia, 1.0);
  EXPECT_EQ(viscous.local_damping, 0.8);
  EXPECT_FALSE(viscous.settling_damping);

  const WallSpec& wall = *s.wall;
  EXPECT_EQ(wall.bond, "running");
  EXPECT_EQ(wall.first_course, "whole");
  EXPECT_FALSE(wall.rigid_units);
  EXPECT_TRUE(wall.bottom_beam && wall.top_beam);
  EXPECT_TRUE(wall.bottom_beam_cuts.empty());
  EXPECT_EQ(wall.beam_height, 0.1);
  EXPECT_EQ(wall.beam_density, 7850.0);
  EXPECT_FALSE(wall.half_thickness);
  EXPECT_EQ(wall.openings.at(0).bearing, 0);
  EXPECT_EQ(wall.openings.at(0).lintel_material, "");
  EXPECT_TRUE(WallSpec{}.mid_unit_joints);

  EXPECT_EQ(s.random.seed, 1u);
  EXPECT_EQ(s.random.sample, 1u);
  const Damage& damage = s.damage.at(0);
  EXPECT_TRUE(damage.joints.empty());
  EXPECT_LT(damage.from[0], -1e9);
  EXPECT_GT(damage.to[2], 1e9);
  EXPECT_EQ(damage.crack_along, 0);
  EXPECT_FALSE(damage.through_units || damage.xi);
  EXPECT_EQ(damage.slip, 0.0);
  EXPECT_FALSE(damage.opening);

  for (const Stage& stage : s.stages) {
    EXPECT_EQ(stage.gravity, (Vec3{0, 0, 0}));
    EXPECT_EQ(stage.record_interval, 0);
    EXPECT_FALSE(stage.duration);
    EXPECT_TRUE(stage.law_swaps.empty());
  }
  const Stage &press = s.stages[0], &shear = s.stages[1];
  EXPECT_EQ(press.ramp_time, 0.005);
  EXPECT_EQ(press.equilibrium_ratio, 1e-3);
  EXPECT_EQ(press.max_steps, 1000000);
  EXPECT_EQ(shear.ramp_time, 0.05);
  EXPECT_FALSE(shear.equilibrium_ratio);
  EXPECT_EQ(shear.max_steps, std::numeric_limits<long>::max());
  EXPECT_EQ(shear.monitor, "top_beam");
  EXPECT_EQ(shear.direction, 0);
  EXPECT_EQ(shear.name, "shear");

  EXPECT_EQ(s.output.frames, 20);
  EXPECT_EQ(s.output.frames_at_damage, 0.0);
  EXPECT_TRUE(s.output.plots);
  EXPECT_FALSE(s.output.energy || s.output.end_state);
  EXPECT_EQ(s.start, "");
}

TEST(ReadBuilding, WhatIsLeftOutIsAsThePageSays) {
  const std::string scene = QUOIN_SCENES "/pavia_door.toml";
  std::ifstream file(scene);
  std::string text, line;
  for (; std::getline(file, line); text += line + "\n") {
    for (const char* key : {"zones", "beam_height", "beam_density", "rigid_beams", "gravity", "equilibrium_ratio"}) {
      if (line.starts_with(key)) line.clear();
    }
  }
  const Scene s = read_scene_text(text, scene, {});
  EXPECT_EQ(s.building->zones, (std::array<int, 3>{4, 2, 2}));
  EXPECT_EQ(s.building->beam_height, 0.1);
  EXPECT_EQ(s.building->beam_density, 7850.0);
  for (const BuildingSpec::Floor& floor : s.building->floors) EXPECT_TRUE(floor.rigid);
  for (const Stage& stage : s.stages) EXPECT_EQ(stage.gravity, (Vec3{0, -9.81, 0})) << stage.name;
}

// A wall of 3 half units.
TEST_F(ReadScene, CutsOfTheBeamAreInsideTheWallAndGrow) {
  const auto cuts = [&](const std::string& list) { return std::vector<std::string>{"wall.bottom_beam_cuts=" + list}; };
  EXPECT_EQ(read(kScene, cuts("[1, 2]")).wall->bottom_beam_cuts, (std::vector<int>{1, 2}));
  for (const char* wrong : {"[1.5]", "[0]"})
    EXPECT_THAT(message(kScene, cuts(wrong)), HasSubstr("a list of integers, each 1 to 20000, half units")) << wrong;
  for (const char* wrong : {"[2, 1]", "[1, 1]", "[3]"})
    EXPECT_THAT(message(kScene, cuts(wrong)), HasSubstr("half units that grow, 1 to 2")) << wrong;
}

TEST_F(ReadScene, KeysOfBeamsWithoutABeamAreNamed) {
  const auto names = Contains(HasSubstr("the wall has no beam"));
  for (const char* key : {"wall.beam_height=0.2", "wall.beam_density=7000"}) {
    Scene scene = read(kScene, {key, "wall.bottom_beam=false"});
    EXPECT_THAT(unused_settings(scene), Not(names));
    scene.wall->top_beam = false;
    EXPECT_THAT(unused_settings(scene), names);
  }
}

// A wall of 2 courses of 1.5 units: 3 half units.
TEST_F(ReadScene, ChangedUnitsAreInTheWall) {
  const auto changed = [](int course, int half_unit) {
    return std::string(kScene) +
           fmt::format("[[wall.changed]]\ncourse = {}\nhalf_unit = {}\nmissing = true\n", course, half_unit);
  };
  EXPECT_EQ(read(changed(1, 2)).wall->changed.at(0).half_unit, 2);
  EXPECT_THAT(message(changed(0, 3)),
              AllOf(HasSubstr("wall.changed.1.half_unit = 3"), HasSubstr("an integer, 0 to 2")));
  EXPECT_THAT(message(changed(2, 0)), AllOf(HasSubstr("wall.changed.1.course = 2"), HasSubstr("an integer, 0 to 1"),
                                            Not(HasSubstr("unknown key"))));
  // Course 0 begins with a whole unit, course 1 with half of one.
  const auto again = [&](int course, int half_unit, int other) {
    return changed(course, half_unit) +
           fmt::format("[[wall.changed]]\ncourse = {}\nhalf_unit = {}\nmaterial = \"brick\"\n", course, other);
  };
  EXPECT_EQ(read(again(0, 1, 2)).wall->changed.size(), 2u);
  EXPECT_EQ(read(again(1, 0, 1)).wall->changed.size(), 2u);
  for (const int first : {0, 1})
    EXPECT_THAT(message(again(0, first, 1)),
                AllOf(HasSubstr("wall.changed.2.half_unit = 1: allowed: each unit once"),
                      HasSubstr(fmt::format("with half_unit = {}; remove one of the two", first))));
}

TEST_F(ReadScene, RestNeedsNoTopBeam) {
  const std::string head = kScene;
  const std::string text = head.substr(0, head.find("[[stage]]")) + "[[stage]]\nkind = \"rest\"\n";
  const Scene s = read(text, {"wall.top_beam=false"});
  ASSERT_EQ(s.stages.at(0).controls.size(), 1u);
  EXPECT_EQ(s.stages[0].controls[0].body, "bottom_beam");
  EXPECT_THAT(message(text + "pressure = 1e5\n", {"wall.top_beam=false"}),
              HasSubstr("stage.1.kind = 'rest': allowed: pressure and shear need a top beam"));
}

TEST_F(ReadScene, CracksRunAlongXOrZ) {
  const auto along = [&](const std::string& key) {
    return read(std::string(kScene) + "[[damage]]\ncrack = [[0, 0], [0.1, 0.1]]\n" + key).damage.at(0).crack_along;
  };
  EXPECT_EQ(along("along = \"x\"\n"), 0);
  EXPECT_EQ(along("along = \"z\"\n"), 2);
}

TEST_F(ReadScene, MissingKeysAndNames) {
  EXPECT_THAT(fault("courses = 2\n", ""),
              AllOf(HasSubstr("s.toml:10: wall.courses: missing"), HasSubstr("1 to 10000")));
  EXPECT_THAT(fault("= \"brick\"", "= \"brik\""),
              AllOf(HasSubstr("s.toml:15: wall.unit_material = 'brik'"), HasSubstr("did you mean 'brick'?")));
  EXPECT_THAT(fault("mid_unit_joints = false\n", ""), HasSubstr("wall.unit_joint: missing"));
  EXPECT_THAT(fault("displacement = 0.001\n", ""), HasSubstr("stage.2.displacement: missing"));
  EXPECT_THAT(fault("kind = \"shear\"", "kind = \"custom\""), HasSubstr("stage.2.velocity = 0.01: unknown key"));
}

TEST_F(ReadScene, EveryFaultAtOnce) {
  const std::string text =
      fault("courses = 2", "courses = -2", {"wall.bond=stak", "materials.brick.density=-1", "sage.1.pressure=3"});
  EXPECT_THAT(text, AllOf(HasSubstr("wall.courses"), HasSubstr("did you mean 'stack'?"), HasSubstr("density = -1"),
                          HasSubstr("did you mean 'stage'?")));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3) << text;
}

TEST_F(ReadScene, OpeningsStayInsideTheWall) {
  const std::string opening =
      "[[wall.opening]]\nfirst_half_unit = 2\nhalf_units = 2\nfirst_course = 0\ncourses = 1\n[[stage]]\nname = "
      "\"press\"";
  EXPECT_THAT(fault("[[stage]]\nname = \"press\"", opening),
              AllOf(HasSubstr("s.toml:21: wall.opening.1.half_units = 2"), HasSubstr("1 to 1")));
}

TEST_F(ReadScene, LintelsAreWholeHalfUnitsLong) {
  // 3 courses of 8 half units of 0.1 m.
  const std::vector<std::string> wall = {"wall.courses=3", "wall.units_per_course=4"};
  const auto with = [&](const std::string& openings) {
    auto settings = wall;
    settings.push_back("wall.opening=[" + openings + "]");
    return settings;
  };
  const std::string place = "{first_half_unit = 3, half_units = 2, first_course = 0, courses = 1, ";
  const Scene s = read(kScene, with(place + "bearing = 0.2, lintel_material = \"brick\"}"));
  EXPECT_EQ(s.wall->openings.at(0).bearing, 2);
  EXPECT_EQ(s.wall->openings[0].lintel_material, "brick");
  EXPECT_EQ(read(kScene, with(place + "bearing = 0}")).wall->openings.at(0).bearing, 0);
  EXPECT_EQ(read(kScene, with(place + "bearing = 0.10001}")).wall->openings.at(0).bearing, 1);

  EXPECT_THAT(message(kScene, with(place + "bearing = 0.125}")),
              AllOf(HasSubstr("wall.opening.1.bearing = 0.125"), HasSubstr("whole half units of 0.1 m"),
                    HasSubstr("0.1 or 0.2")));
  EXPECT_THAT(message(kScene, with(place + "bearing = -0.1}")), HasSubstr("0 or more, m of lintel"));
  EXPECT_THAT(message(kScene, with(place + "bearing = 1e300}")), HasSubstr("at most the length of the wall, 0.8 m"));
  EXPECT_THAT(message(kScene, with(place + "lintel_material = \"brick\"}")), HasSubstr("give bearing > 0 too"));
  EXPECT_THAT(message(kScene, with(place + "bearing = 0.1, lintel_material = \"brik\"}")),
              HasSubstr("did you mean 'brick'?"));
}

TEST_F(ReadScene, LintelsNeedRoom) {
  const auto opening = [](int half_unit, int half_units, int course, int courses, const char* bearing) {
    return fmt::format("{{first_half_unit = {}, half_units = {}, first_course = {}, courses = {}, bearing = {}}}",
                       half_unit, half_units, course, courses, bearing);
  };
  const auto fault_of = [&](const std::vector<std::string>& openings) {
    return message(kScene, {"wall.courses=6", "wall.units_per_course=5",
                            fmt::format("wall.opening=[{}]", fmt::join(openings, ", "))});
  };
  EXPECT_THAT(fault_of({opening(2, 2, 1, 5, "0.1")}),
              AllOf(HasSubstr("wall.opening.1.bearing = 0.1"), HasSubstr("ends with course 5, the top of the wall")));
  EXPECT_THAT(fault_of({opening(1, 2, 1, 2, "0.2")}),
              AllOf(HasSubstr("at most 0.1 m"), HasSubstr("1 half units of 0.1 m left of the opening and 7 right")));
  EXPECT_THAT(fault_of({opening(1, 2, 1, 2, "0.1"), opening(3, 2, 3, 2, "0")}),
              AllOf(HasSubstr("half units 0 to 3 of course 3, runs into opening 2")));
  EXPECT_THAT(fault_of({opening(1, 2, 1, 2, "0.1"), opening(3, 2, 2, 1, "0")}),
              AllOf(HasSubstr("borne by masonry"), HasSubstr("lies opening 2")));
  EXPECT_THAT(fault_of({opening(1, 2, 1, 2, "0.1"), opening(4, 2, 1, 2, "0.1")}),
              AllOf(HasSubstr("wall.opening.2.bearing"), HasSubstr("half units 3 to 6 of course 3, runs into that of "
                                                                   "opening 1")));
  // All faults together.
  const std::string both = fault_of({opening(1, 2, 1, 2, "0.2"), opening(4, 2, 1, 5, "0.1")});
  EXPECT_THAT(both, AllOf(HasSubstr("wall.opening.1.bearing"), HasSubstr("wall.opening.2.bearing")));
}

TEST_F(ReadScene, BeamsLieBesideLintels) {
  const std::string scene = QUOIN_SCENES "/pavia_door.toml";
  const auto lintel_course = [&] {
    const Scene s = read_scene(scene);
    return s.building->walls.at(0).openings.at(0).lintel_course();
  }();
  try {
    read_scene(scene, {fmt::format("building.floor.1.course={}", lintel_course)});
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::bad_input);
    EXPECT_THAT(error.what(), AllOf(HasSubstr("building.floor.1.half_units"), HasSubstr("half units beside lintels")));
  }
}

TEST_F(ReadScene, StagesThatNeverEndAreRefused) {
  const std::string stages = std::string(kScene) + "[[stage]]\nkind = \"custom\"\n";
  EXPECT_THAT(message(stages), AllOf(HasSubstr("s.toml:27: stage.3"), HasSubstr("never ends")));
  EXPECT_THAT(fault("velocity = 0.01", "velocity = 0"), HasSubstr("never reach its displacement"));
}

// A shear stage with vertical = "pressure" keeps the force of the first stage, 1e5 Pa on 0.3 x 0.1 m; otherwise it
// fixes the height.
TEST_F(ReadScene, ShearKeepsTheForceOrTheHeight) {
  for (const bool free : {false, true}) {
    const Scene s = read(kScene, {std::string("stage.2.vertical=") + (free ? "pressure" : "held")});
    const auto& press = s.stages[0].controls;
    const auto top = [](const std::vector<BodyControl>& controls) {
      for (const BodyControl& c : controls)
        if (c.body == "top_beam") return c;
      return BodyControl{};
    };
    EXPECT_NEAR(top(press).force[1], -3000.0, 1e-9);
    EXPECT_EQ(top(press).kind[1], DofKind::free);
    EXPECT_EQ(top(s.stages[1].controls).kind[1] == DofKind::free, free);
    EXPECT_NEAR(top(s.stages[1].controls).force[1], free ? -3000.0 : 0.0, 1e-9);
    EXPECT_EQ(top(s.stages[1].controls).velocity[0], 0.01);
  }
}

TEST(ReadBuilding, RampsAreThoseOfTheSceneOrTheDefault) {
  const std::string scene = QUOIN_SCENES "/pavia_door.toml";
  const auto ramps = [&](const std::vector<std::string>& overrides) {
    std::vector<double> list;
    for (const Stage& s : read_scene(scene, overrides).stages) list.push_back(s.ramp_time);
    return list;
  };
  EXPECT_EQ(ramps({}), (std::vector<double>{0.05, 0.05}));
  EXPECT_EQ(ramps({"stage.1.ramp_time=0.3", "stage.2.ramp_time=0.2"}), (std::vector<double>{0.3, 0.2}));
}

TEST_F(ReadScene, MassScalingHasItsBounds) {
  EXPECT_EQ(read(kScene, {"solver.quality=reference", "solver.mass_scaling=1e9"}).solver.mass_scaling, 1e9);
  for (const char* wrong : {"1.01e9", "0.99"})
    EXPECT_THAT(message(kScene, {"solver.quality=reference", std::string("solver.mass_scaling=") + wrong}),
                HasSubstr("solver.mass_scaling"));
}

TEST_F(ReadScene, CustomStages) {
  const Scene s =
      read(std::string(kScene) +
           "[[stage]]\nkind = \"custom\"\nduration = 0.1\n[[stage.control]]\nbody = \"top_beam\"\nvelocity = "
           "[0, \"free\", 0]\nforce = [0, -5, 0]\n");
  EXPECT_EQ(s.stages[2].controls.at(0).kind[1], DofKind::free);
  EXPECT_EQ(s.stages[2].controls[0].force[1], -5);
  ASSERT_EQ(s.stages[2].controls.size(), 2u);
  EXPECT_EQ(s.stages[2].controls[1].body, "bottom_beam");
  EXPECT_EQ(prescribed_by(s.stages[2].controls[1]), kAllPrescribed);
  EXPECT_THAT(message(std::string(kScene) + "[[stage]]\nkind = \"custom\"\nduration = 0.1\n[[stage.control]]\nbody = "
                                            "\"roof\"\nforce = [1, 0, 0]\n"),
              AllOf(HasSubstr("stage.3.control.1.body = 'roof'"), HasSubstr("top_beam"), HasSubstr("control.1.force")));
}

// A stage of controls alone ends the pressure of the stage before, with a warning. There is none where the beam is
// named, or where the stage goes on with the pressure.
TEST_F(ReadScene, LoadsThatAStageEndsAreWarnedOf) {
  const auto warned = [&](const std::string& control) {
    const Scene s = read(std::string(kScene) + "[[stage]]\nkind = \"custom\"\nduration = 0.1\n" + control);
    Scene pressed = s;
    pressed.stages = {s.stages[0], s.stages[2]};
    for (const StageWarning& warning : stage_warnings(pressed, 1))
      if (std::string("loads") == warning.about) return warning.text;
    return std::string();
  };
  const Scene s = read(kScene);
  const auto top = std::ranges::find(s.stages[0].controls, "top_beam", &BodyControl::body);
  ASSERT_NE(top, s.stages[0].controls.end());
  ASSERT_LT(top->force[1], 0.0);
  EXPECT_THAT(
      warned("[[stage.control]]\nbody = \"bottom_beam\"\n"),
      AllOf(HasSubstr("top_beam: "), HasSubstr(fmt::format("{:g}", top->force[1])), HasSubstr("force = [0, -")));
  EXPECT_EQ(warned("[[stage.control]]\nbody = \"top_beam\"\n"), "");
  EXPECT_EQ(warned(""), "");
}

// Rigid units need no elastic moduli, and stages can move their outer courses.
TEST_F(ReadScene, RigidUnits) {
  std::string text = kScene;
  text.replace(text.find("young_modulus"), std::string("young_modulus = 16.7e9\npoisson_ratio = 0.15\n").size(), "");
  EXPECT_THAT(message(text), HasSubstr("materials.brick.young_modulus: missing"));
  const std::string moved = text + "[[stage]]\nkind = \"custom\"\nduration = 0.1\nmonitor = \"bottom_course\"\n";
  const Scene s = read(moved, {"wall.rigid_units=true"});
  EXPECT_TRUE(s.wall->rigid_units);
  EXPECT_EQ(s.stages[2].monitor, "bottom_course");
  const Scene cycles =
      read(text + "[[stage]]\nkind = \"cycles\"\nbody = \"top_course\"\namplitudes = [1e-3]\nvelocity = 0.1\n",
           {"wall.rigid_units=true", "wall.bottom_beam=false"});
  EXPECT_EQ(cycles.stages[2].controls.at(1).body, "bottom_course");
  EXPECT_EQ(prescribed_by(cycles.stages[2].controls[1]), kAllPrescribed);
  EXPECT_THAT(message(moved, {"wall.rigid_units=true", "wall.zones=[1,1,1]"}),
              AllOf(HasSubstr("wall.zones"), HasSubstr("only with deformable units")));
}

TEST_F(ReadScene, SyntaxAndMissingFile) {
  EXPECT_THAT(fault("density = 1900", "density = "), AllOf(HasSubstr("s.toml:5:"), HasSubstr("not valid TOML")));
  try {
    read_scene((folder_ / "none.toml").string());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::bad_input);
    EXPECT_THAT(error.what(), HasSubstr("none.toml: cannot read"));
  }
}

TEST_F(ReadScene, BadOverrides) {
  EXPECT_THAT(message(kScene, {"wall.courses"}), HasSubstr("dotted.key=value"));
  EXPECT_THAT(message(kScene, {"stage.9.velocity=1"}), AllOf(HasSubstr("--set stage.9"), HasSubstr("which has 2")));
  EXPECT_THAT(message(kScene, {"title.x=1"}), HasSubstr("title is not a table"));
  for (const char* place : {"0", "4", "one"})
    EXPECT_THAT(message(kScene, {fmt::format("wall.unit.{}=0.3", place)}),
                HasSubstr(fmt::format("'{}' is no element of the list wall.unit, which has 3; count from 1;", place)));
  EXPECT_THAT(message(kScene, {"stage.push={ kind = 'shear' }"}),
              HasSubstr("which has 2 ('press', 'shear'); count from 1 or use its name;"));
}

TEST_F(ReadScene, OverridesReplaceElementsOfLists) {
  EXPECT_EQ(read(kScene, {"wall.unit.1=0.3"}).wall->unit, (Vec3{0.3, 0.1, 0.1}));
  EXPECT_EQ(read(kScene, {"wall.zones=[4, 2, 2]", "wall.zones.3=6"}).wall->zones, (std::array{4, 2, 6}));
  EXPECT_THAT(message(kScene, {"wall.zones=[4, 2, 2]", "wall.zones.3=1.5"}),
              AllOf(HasSubstr("--set: wall.zones = [ 4, 2, 1.5 ]"), HasSubstr("a list of 3 integers")));
  EXPECT_THAT(message(kScene, {"wall.unit.2=high"}), HasSubstr("--set: wall.unit = [ 0.2, 'high', 0.1 ]: wrong type"));
  const std::string stage = "{ name = 'push', kind = 'shear', velocity = 0.01, displacement = 0.002 }";
  for (const char* place : {"2", "shear"}) {
    const Scene s = read(kScene, {fmt::format("stage.{}={}", place, stage)});
    EXPECT_EQ(s.stages.at(1).name, "push");
    EXPECT_EQ(s.stages.at(1).displacement, 0.002);
  }
  EXPECT_THAT(message(kScene, {"stage.2={ kind = 'shear' }"}), HasSubstr("--set: stage.2"));
  const std::string forced =
      std::string(kScene) +
      "[[stage]]\nname = \"p\"\nduration = 0.1\n[[stage.force]]\nblock = \"top_beam\"\npoint = [0, 0.3, 0]\n"
      "force = [1, 2, 3]\n";
  EXPECT_EQ(read(forced, {"stage.p.force.1.force.1=2000"}).stages.at(2).forces.at(0).force, (Vec3{2000, 2, 3}));
}

TEST(DidYouMean, SuggestsOnlyWhatIsNear) {
  EXPECT_EQ(did_you_mean("cohesoin", {"cohesion", "tensile_strength"}), ", did you mean 'cohesion'?");
  EXPECT_EQ(did_you_mean("weather", {"cohesion", "law"}), "");
}

}  // namespace
}  // namespace quoin
