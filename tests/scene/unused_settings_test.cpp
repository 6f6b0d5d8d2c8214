// Settings that change nothing are named. Testers found them taken in silence.
#include "scene/unused_settings.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "one_block.h"
#include "scene/damping_text.h"
#include "scene/driven.h"
#include "scene/read_ground.h"
#include "scene/read_scene.h"
#include "scene/stage_warnings.h"

namespace quoin {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

std::string scene_text(const char* rigid, const std::string& more = "") {
  return "default_joint = \"dry\"\n" + kStone +
         fmt::format(R"([[block]]
name = "block"
material = "stone"
box = {{ lower = [0, 0, 0], size = [1, 1, 1] }}
{}
[[stage]]
duration = 0.1
{})",
                     rigid, more);
}

std::string driven(const char* velocity) {
  return fmt::format("[[stage.velocity]]\nblock = \"block\"\nvelocity = {}\n", velocity);
}

// Returns the warning of a stage about this; empty: none.
std::string warning_about(const std::string& about, const Scene& scene, std::size_t stage) {
  for (const StageWarning& warning : stage_warnings(scene, stage))
    if (about == warning.about) return warning.text;
  return "";
}

const char* const kRigid = "";
const char* const kDeformable = "rigid = false\nzone_edge = 0.5";

std::vector<std::string> unused(const std::string& text, const std::vector<std::string>& settings = {}) {
  return unused_settings(read_scene_text(text, "scene.toml", settings));
}

TEST(UnusedSettings, MaterialsAndJointsWithoutBlocks) {
  EXPECT_THAT(unused(scene_text(kRigid)), IsEmpty());
  EXPECT_THAT(unused(scene_text(kRigid, R"([materials.other]
density = 1000
[joints.other]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 5e8
)")),
              ElementsAre(StartsWith("materials.other"), StartsWith("joints.other")));
}

// Each place that takes a material or a joint: units of a wall, lintels, changed units, dry walls, arches, rules.
TEST(UnusedSettings, MaterialsAndJointsOfEveryPlaceAreUsed) {
  const auto table = [](const char* head, const char* name, const char* keys) {
    return fmt::format("[{}.{}]\n{}", head, name, keys);
  };
  const auto materials = [&](std::initializer_list<const char*> names) {
    std::string text;
    for (const char* name : names)
      text += table("materials", name, "density = 2000\nyoung_modulus = 1e10\npoisson_ratio = 0.2\n");
    return text;
  };
  const auto joints = [&](std::initializer_list<const char*> names) {
    std::string text;
    for (const char* name : names)
      text += table("joints", name, "law = \"elastic\"\nnormal_stiffness = 1e9\nshear_stiffness = 5e8\n");
    return text;
  };
  EXPECT_THAT(unused(materials({"of_unit", "of_lintel", "of_change"}) + joints({"bed", "head", "unit", "beam"}) +
                     R"([wall]
courses = 4
units_per_course = 3
unit = [0.2, 0.1, 0.2]
unit_material = "of_unit"
bed_joint = "bed"
head_joint = "head"
unit_joint = "unit"
beam_joint = "beam"
[[wall.opening]]
first_half_unit = 2
half_units = 2
first_course = 1
courses = 1
bearing = 0.1
lintel_material = "of_lintel"
[[wall.changed]]
course = 0
half_unit = 0
material = "of_change"
[[stage]]
kind = "pressure"
name = "press"
pressure = 1e5
)"),
              IsEmpty());
  EXPECT_THAT(unused("default_joint = \"of_default\"\n" + materials({"of_block", "of_wall", "of_arch"}) +
                     joints({"of_default", "of_rule", "of_strip"}) + R"([[block]]
name = "block"
material = "of_block"
box = { lower = [9, 0, 0], size = [1, 1, 1] }
[[dry_wall]]
material = "of_wall"
courses = 1
units_per_course = 2
unit = [0.3, 0.1, 0.2]
[[arch]]
material = "of_arch"
centre = [20, 0, 0]
radius = 2
thickness = 0.4
depth = 0.5
voussoirs = 3
[[joint_rule]]
family = "of_rule"
[[strip]]
joint = "of_strip"
points = [[9, 1, 0.5], [10, 1, 0.5]]
width = 0.1
thickness = 1e-3
young_modulus = 1e11
spacing = 0.1
[[stage]]
duration = 0.1
)"),
              IsEmpty());
}

TEST(UnusedSettings, OfDeformationWhereAllIsRigid) {
  for (const char* setting : {"deformation_inertia=2.0", "unit_inertia=2.0", "internal_forces=zones"}) {
    const std::string key = std::string("solver.") + setting;
    const std::vector<std::string> settings{"solver.damping=block", key};
    EXPECT_THAT(unused(scene_text(kRigid), settings), ElementsAre(StartsWith(key.substr(0, key.find('='))))) << setting;
    EXPECT_THAT(unused(scene_text(kDeformable), settings), IsEmpty()) << setting;
  }
}

TEST(UnusedSettings, PointsOfRigidBlocksWhereAllDeforms) {
  for (const char* setting : {"contact.point_spacing=0.3", "contact.cubic_points=true"}) {
    EXPECT_THAT(unused(scene_text(kDeformable), {setting}), ElementsAre(StartsWith("contact."))) << setting;
    EXPECT_THAT(unused(scene_text(kRigid), {setting}), IsEmpty()) << setting;
  }
}

TEST(UnusedSettings, OfSettlingAndOfChance) {
  EXPECT_THAT(unused(scene_text(kRigid), {"solver.settling_damping=0.3"}),
              ElementsAre(StartsWith("solver.settling_damping")));
  EXPECT_THAT(unused(scene_text(kRigid), {"solver.settling_damping=0.3", "stage.1.equilibrium_ratio=1e-3"}), IsEmpty());
  EXPECT_THAT(unused(scene_text(kRigid), {"random.seed=7"}), ElementsAre(StartsWith("[random]")));
}

// History was bitwise the same with and without these, and nothing was said.
TEST(UnusedSettings, OfJointsInUnitsWhereUnitsAreWhole) {
  const std::string wall = kStone + R"([wall]
courses = 2
units_per_course = 2
unit = [0.25, 0.125, 0.2]
unit_material = "stone"
bed_joint = "dry"
head_joint = "dry"
beam_joint = "dry"
[[damage]]
crack = [[-0.1, 0.1], [0.6, 0.2]]
[[stage]]
kind = "pressure"
name = "press"
pressure = 1e5
)";
  const std::vector<std::string> given{"wall.unit_joint=dry", "damage.1.through_units=true"};
  const auto with = [&](const char* setting) {
    std::vector<std::string> settings = given;
    settings.emplace_back(setting);
    return unused(wall, settings);
  };
  EXPECT_THAT(with("wall.mid_unit_joints=false"),
              ElementsAre(StartsWith("wall.unit_joint: without effect"), StartsWith("damage.1.through_units")));
  EXPECT_THAT(with("wall.mid_unit_joints=true"), IsEmpty());
}

// A spring below the bottom beam of a wall, which stages hold: it had no force, and nothing was said.
TEST(UnusedSettings, SpringsBelowWhatStagesHold) {
  const auto with = [](const char* fixed, const std::string& stage) {
    return unused(scene_text(fixed, stage + R"([[spring]]
name = "soil"
block = "block"
normal = [0, -1, 0]
normal_stiffness = 1e7
friction_angle = 90
)"));
  };
  const char* const kFixed = "fixed = true";
  EXPECT_THAT(with(kFixed, ""), ElementsAre(StartsWith("spring.soil: without effect")));
  EXPECT_THAT(with("", ""), IsEmpty());
  EXPECT_THAT(with(kFixed, driven("[0, \"free\", 0]")), IsEmpty());
  EXPECT_THAT(with(kFixed, driven("[0, -0.001, 0]")), IsEmpty());
}

TEST(UnusedSettings, OfSpringsFloorsAndBeams) {
  const std::string scene = scene_text(kRigid, R"([[spring]]
name = "soil"
block = "block"
normal_stiffness = 1e7
friction_angle = 30
[[floor]]
name = "timber"
corner = [0, 0.5, 0]
along = [1, 0, 0]
across = [0, 0, 1]
spacing = 1
axial_stiffness = [1e7, 1e7]
shear_stiffness = 1e6
mass = 40
connector = { axial_stiffness = 1e6, shear_stiffness = 1e6, friction = 0.5 }
[[beam]]
name = "lintel"
points = [[0, 0.5, 0], [1, 0.5, 0]]
spacing = 0.5
area = 1e-3
young_modulus = 2e11
density = 7850
bedding = "pinned"
friction = 0.3
torsion = 1e-6
poisson_ratio = 0.2
shear_area = [1e-3, 1e-3]
yield_moment = [1, 1]
up = [0, 0, 1]
)");
  const std::vector<std::string> none_of_beam{"spring.soil.friction_angle=90", "floor.timber.connector.friction=0"};
  const auto beam_with = [&](std::vector<std::string> settings) {
    settings.insert(settings.end(), none_of_beam.begin(), none_of_beam.end());
    return unused(scene, settings);
  };
  EXPECT_THAT(unused(scene),
              ElementsAre(StartsWith("spring.soil.friction_angle"), StartsWith("floor.timber.connector.friction"),
                          StartsWith("beam.lintel.friction"), StartsWith("beam.lintel.shear_area"),
                          StartsWith("beam.lintel.yield_moment"), StartsWith("beam.lintel.torsion"),
                          StartsWith("beam.lintel.poisson_ratio"), StartsWith("beam.lintel.up")));
  const std::string bar = "beam.lintel.inertia=[1e-6, 1e-6]", rests = "beam.lintel.bedding=resting";
  EXPECT_THAT(beam_with({bar, rests}), IsEmpty());
  EXPECT_THAT(beam_with({bar}), ElementsAre(StartsWith("beam.lintel.friction")));
  // Torsion turns blocks that hold a cable; a cable along y needs another `up` than the default.
  EXPECT_THAT(beam_with({"beam.lintel.bedding=built_in", "beam.lintel.friction=0.6",
                         "beam.lintel.points=[[0, 0, 0], [0, 1, 0]]"}),
              ElementsAre(StartsWith("beam.lintel.shear_area"), StartsWith("beam.lintel.yield_moment")));
  EXPECT_THAT(unused(scene, {"spring.soil.shear_stiffness=1e6", "floor.timber.connector.pull_out=0.1", bar, rests}),
              IsEmpty());
  EXPECT_THAT(
      unused(scene, {"spring.soil.shear_stiffness=1e6", "floor.timber.connector.shear_strength=1e3", bar, rests}),
      IsEmpty());
}

// --set materials.stne.density made a new material, and the run was that of before.
TEST(UnusedSettings, AMistypedNameIsRefused) {
  for (const char* setting : {"materials.stne.density=9000", "joints.dri.normal_stiffness=1e8"}) {
    try {
      read_scene_text(scene_text(kRigid), "scene.toml", {setting});
      ADD_FAILURE() << setting;
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      EXPECT_THAT(error.what(), AllOf(HasSubstr("--set"), HasSubstr("has no"), HasSubstr("did you mean")));
    }
  }
}

TEST(UnusedSettings, TestsThatNoPropertyFollowsFromAreRefused) {
  try {
    read_scene_text(scene_text(kRigid, "[tests]\nunit = \"clay\"\nblock_height = 0.1\nunit_strength = 20e6\n"),
                    "scene.toml", {});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("tests: no material"), HasSubstr("from_tests")));
  }
}

// Local damping brakes motion at an angle to the axes: a deformable wall at 37 degrees in plan was 12 % too strong.
TEST(DrivenAtAnAngle, IsWarnedOfUnderLocalDamping) {
  const auto warns = [](const char* rigid, const char* velocity, const char* damping) {
    const Scene scene =
        read_scene_text(scene_text(rigid, driven(velocity)), "scene.toml", {std::string("solver.damping=") + damping});
    return !warning_about("angle", scene, 0).empty();
  };
  EXPECT_TRUE(warns(kDeformable, "[0.006, 0, 0.008]", "local"));
  EXPECT_FALSE(warns(kDeformable, "[0.006, 0, 0]", "local"));
  EXPECT_FALSE(warns(kDeformable, "[0.006, 0, 0.008]", "block"));
  EXPECT_FALSE(warns(kRigid, "[0.006, 0, 0.008]", "local"));
}

// A parapet of default zones falls at 0.672 of its weight along z, for 0.444 by hand: 1 + 2/n^2 is 1.5 for n = 2. With
// four zones through the thickness it falls at 0.499. Nothing was said of it.
TEST(OutOfPlane, IsWarnedOfWithFewZonesThroughTheThickness) {
  const auto warning = [](const std::string& keys, const char* direction) {
    const Scene scene = read_scene_text(R"(
[materials.m]
young_modulus = 5e9
poisson_ratio = 0.2
density = 1800.0
[joints.j]
law = "coulomb_slip"
normal_stiffness = 2e10
shear_stiffness = 1e10
tensile_strength = 1e5
cohesion = 2e5
friction_angle = 35.0
[wall]
courses = 2
units_per_course = 2
unit = [0.25, 0.125, 0.2]
unit_material = "m"
bed_joint = "j"
head_joint = "j"
beam_joint = "j"
unit_joint = "j"
top_beam = false
)" + keys + R"(
[[stage]]
kind = "custom"
name = "tilt"
ramp_time = 0.5
gravity = [0, -9.81, 0]
collapse = { direction = )" + direction + ", start = 0.2, rate = 0.2 }\n",
                                        "scene.toml", {});
    return warning_about("thickness", scene, 0);
  };
  EXPECT_THAT(warning("", "[0, 0, 1]"), AllOf(HasSubstr("have 2 zones"), HasSubstr("are 1.5 times too stiff")));
  EXPECT_THAT(warning("zones = [2, 1, 1]", "[0, 0, 1]"),
              AllOf(HasSubstr("have 1 zone through"), HasSubstr("are 3 times")));
  EXPECT_THAT(warning("zones = [2, 1, 3]", "[0, 0, 1]"), HasSubstr("are 1.22 times"));
  EXPECT_EQ(warning("half_thickness = true", "[0, 0, 1]"), "") << "4 zones";
  EXPECT_EQ(warning("", "[1, 0, 0]"), "");
  EXPECT_EQ(warning("zones = [2, 1, 4]", "[0, 0, 1]"), "");
  EXPECT_EQ(warning("rigid_units = true", "[0, 0, 1]"), "");
}

// Walls of a building bend out of plane where a stage acts across one of them.
TEST(OutOfPlane, OfABuildingIsWarnedOfAcrossItsWallsAlone) {
  const auto warns = [](const char* axis, const char* direction) {
    const Scene scene = read_scene_text(fmt::format(R"(
[materials.m]
young_modulus = 5e9
poisson_ratio = 0.2
density = 1800.0
[joints.j]
law = "elastic"
normal_stiffness = 2e10
shear_stiffness = 1e10
[building]
courses = 4
course_height = 0.25
thickness = 0.25
zones = [1, 1, 1]
unit_material = "m"
bed_joint = "j"
head_joint = "j"
unit_joint = "j"
beam_joint = "j"
[[building.wall]]
name = "A"
axis = "{}"
start = [0, 0]
half_units = 6
half_unit = 0.25
[[stage]]
name = "shake"
duration = 0.8
gravity = [0, -9.81, 0]
ramp_time = 0.1
ground_motion = {{ direction = {}, time = [0, 0.4, 0.8], acceleration = [0, 2, 2] }}
)",
                                                    axis, direction),
                                        "scene.toml", {});
    return !warning_about("thickness", scene, 0).empty();
  };
  EXPECT_TRUE(warns("x", "[0, 0, 1]"));
  EXPECT_FALSE(warns("x", "[1, 0, 0]"));
  EXPECT_TRUE(warns("z", "[1, 0, 0]"));
  EXPECT_FALSE(warns("z", "[0, 0, 1]"));
}

// Gravity is 0 unless it is written: a dry block under an earthquake had a base shear of 0 in silence. Weight that
// comes at once made 24.2 kN of a weight of 19.6.
TEST(Weight, UnderGroundMotionIsWarnedOfWhereThereIsNoneOrItComesAtOnce) {
  const auto weight = [](const char* before, const char* now) {
    const std::string stages = fmt::format(
        "[[stage]]\nname = \"rest\"\nduration = 0.1\n{}\n[[stage]]\nname = \"shake\"\nduration = 0.8\n{}\n"
        "ground_motion = {{ direction = [1, 0, 0], time = [0, 0.4, 0.8], acceleration = [0, 2, 2] }}\n",
        before, now);
    return warning_about("weight", read_scene_text(scene_text(kRigid, stages), "scene.toml", {}), 2);
  };
  const char* const kDown = "gravity = [0, -9.81, 0]";
  EXPECT_THAT(weight("", ""), HasSubstr("has no weight"));
  EXPECT_THAT(weight("", kDown), HasSubstr("comes at once"));
  EXPECT_EQ(weight(kDown, kDown), "");
  EXPECT_EQ(weight("", (std::string(kDown) + "\nramp_time = 0.2").c_str()), "");
}

// The default gamma of stages that move rigid blocks is 0.1, whatever stages stand between them. A table that leaves
// damping out does not change it, and damping of a stage's own holds from there on.
TEST(DefaultDamping, OfStagesThatMoveRigidBlocksIsThatOfTheStage) {
  const auto gammas = [](const char* of_second) {
    const std::string still = "[[stage]]\nduration = 0.1\n", drive = driven("[0.01, 0, 0]");
    const Scene scene = read_scene_text(scene_text(kRigid, still + drive + of_second + still + still + drive + still),
                                        "scene.toml", {});
    std::vector<double> found;
    for (std::size_t i = 0; i < scene.stages.size(); ++i) found.push_back(scene.solver_in(i).local_damping);
    return found;
  };
  EXPECT_THAT(gammas(""), testing::ElementsAre(0.8, 0.1, 0.8, 0.1, 0.8));
  EXPECT_THAT(gammas("[stage.solver]\ntime_step_fraction = 0.3\n"), testing::ElementsAre(0.8, 0.1, 0.8, 0.1, 0.8));
  EXPECT_THAT(gammas("[stage.solver]\nlocal_damping = 0.1\n"), testing::ElementsAre(0.8, 0.1, 0.1, 0.1, 0.1));
  EXPECT_THAT(gammas("[stage.solver]\nlocal_damping = 0.5\n"), testing::ElementsAre(0.8, 0.5, 0.5, 0.5, 0.5));
}

// Viscous damping has no default coefficient: it damped nothing in silence.
TEST(Viscous, DampingWithoutCoefficientsIsWarnedOf) {
  const auto viscous = [](const std::vector<std::string>& settings) {
    return warning_about("viscous", read_scene_text(scene_text(kRigid, driven("[0.01, 0, 0]")), "scene.toml", settings),
                         0);
  };
  EXPECT_THAT(viscous({"solver.damping=viscous"}), HasSubstr("nothing is damped"));
  EXPECT_EQ(viscous({"solver.damping=viscous", "solver.mass_damping=1"}), "");
  EXPECT_EQ(viscous({"solver.damping=viscous", "solver.stiffness_damping=1e-6"}), "");
  EXPECT_EQ(viscous({"solver.damping=none"}), "");
}

// A cube of 23544 N lay on its base with 6.1 N, as its stage ended in the ramp of gravity. A smooth ramp has
// 10 t^3 - 15 t^4 + 6 t^5 at the share t of its time: 0.5 in the middle, and 10/64 - 15/256 + 6/1024 = 0.1035 at 1/4.
TEST(Ramp, ThatTheDurationCutsShortIsWarnedOf) {
  const auto cut = [](const std::vector<std::string>& settings, const std::string& more = "") {
    return warning_about("short_ramp", read_scene_text(scene_text(kRigid, more), "scene.toml", settings),
                         more.empty() ? 0 : 1);
  };
  const std::string weight = "stage.1.gravity=[0, -9.81, 0]";
  EXPECT_THAT(cut({weight, "stage.1.ramp_time=0.4"}), AllOf(HasSubstr("10 % of"), HasSubstr("0.4 s")));
  EXPECT_THAT(cut({"stage.1.ramp_time=0.2", "stage.1.velocity=[{block='block', velocity=[0.01, 0, 0]}]"}),
              HasSubstr("50 % of"));
  EXPECT_EQ(cut({weight, "stage.1.ramp_time=0.1"}), "");
  EXPECT_EQ(cut({weight}), "");
  EXPECT_EQ(cut({weight, "stage.1.ramp_time=0.4", "stage.1.equilibrium_ratio=1e-3"}), "");
  EXPECT_EQ(cut({"stage.1.ramp_time=0.4", "stage.1.displacement=1e-3", "stage.1.monitor=block"}), "");
  EXPECT_EQ(cut({},
                "[[stage]]\nkind = \"cycles\"\nblock = \"block\"\ndirection = \"x\"\namplitudes = [1e-4]\n"
                "cycle_velocity = 0.01\nramp_time = 0.5\n"),
            "");
}

// A stage that shakes the ground for 0.1 s, after one at rest.
std::string shaken(const std::string& keys) {
  return "[[stage]]\nname = \"shake\"\nduration = 0.1\ngravity = [0, -9.81, 0]\nramp_time = 0.1\n" + keys +
         "ground_motion = { direction = [1, 0, 0], time = [0, 0.1], acceleration = [0, 2] }\n";
}

std::string warning_of_last(const std::string& about, const std::string& text,
                            const std::vector<std::string>& settings = {}) {
  const Scene scene = read_scene_text(text, "scene.toml", settings);
  return warning_about(about, scene, scene.stages.size() - 1);
}

// Damping in space, raised inertia and soil under ground motion, by the names and values of what the scene has.
TEST(GroundMotion, IsWarnedOfWithWhatFalsifiesIt) {
  const std::string fill =
      "[[fill]]\nname = \"loam\"\nblock = \"block\"\nunit_weight = 18e3\nfriction_angle = 30\nstiffness = 1e7\n"
      "towards = [1, 0, 0]\nsurface = [0, 1, 0]\n";
  const std::string still = "[[stage]]\nduration = 0.1\ngravity = [0, -9.81, 0]\n";
  const struct {
    const char *about, *solver, *text;
  } cases[] = {{"damping", "{damping='local'}", "local damping (gamma 0.8)"},
               {"damping", "{damping='block'}", "damping by block (gamma 0.8)"},
               {"damping", "{damping='viscous', stiffness_damping=1e-6}", ""},
               {"damping", "{damping='viscous', mass_damping=3}", "mass damping (3 1/s)"},
               {"damping", "{damping='none'}", ""},
               {"inertia", "{mass_scaling=1}", ""},
               {"inertia", "{mass_scaling=2.5}", "mass_scaling = 2.5 raises"},
               {"inertia", "{selective_time_step=2e-5}", "selective_time_step = 2e-05 s raises"}};
  for (const auto& [about, solver, text] : cases) {
    // Only what the stage repeats is taken where the ground moves.
    const std::vector<std::string> settings{std::string("solver=") + solver, std::string("stage.2.solver=") + solver};
    const std::string found = warning_of_last(about, scene_text(kRigid, shaken("")), settings);
    EXPECT_THAT(found, *text ? HasSubstr(text) : testing::Matcher<std::string>(IsEmpty())) << solver;
    EXPECT_EQ(warning_of_last(about, scene_text(kRigid, still), {settings[0]}), "") << solver;
  }
  EXPECT_THAT(warning_of_last("soil", scene_text(kRigid, fill + shaken(""))), HasSubstr("[[fill]] 'loam'"));
  EXPECT_EQ(warning_of_last("soil", scene_text(kRigid, fill + still)), "");
  EXPECT_EQ(warning_of_last("soil", scene_text(kRigid, shaken(""))), "");
}

// 2 m/s2 from 0.2 to 0.6 s give 0.8 m/s, and 0.6 m/s by 0.5 s.
TEST(GroundMotion, TextOfARecordHasItsTimesAndVelocities) {
  const Scene scene = read_scene_text(
      scene_text(kRigid, "ground_motion = { direction = [1, 0, 0], time = [0.2, 0.6], acceleration = [2, 2] }\n"),
      "scene.toml", {});
  const GroundMotion& ground = *scene.stages[0].ground;
  const std::string text = "record of 0.4 s along (1, 0, 0), which ends at 0.8 m/s and begins at 0.2 s";
  EXPECT_EQ(ground_text(ground, std::nullopt), text);
  EXPECT_EQ(ground_text(ground, 0.6), text);
  EXPECT_EQ(ground_text(ground, 0.5), text + ", cut at the end of the stage, after 0.5 s, at 0.6 m/s");
  EXPECT_EQ(ground_text(ground, 0.2), text + ", after the end of the stage");
  for (const auto& [factor, converts] : {std::pair{9.81, true},
                                         {9.8, true},
                                         {1.0029 * 9.80665, true},
                                         {1.0031 * 9.80665, false},
                                         {0.9969 * 9.80665, false}})
    EXPECT_EQ(converts_from_g(factor), converts) << factor;
}

// Any load that changes at once leaves vibrations, which damping in space brakes.
TEST(Release, OfLoadsAtOnceIsWarnedOf) {
  const auto released = [](const std::string& keys, const std::vector<std::string>& settings = {}) {
    return warning_of_last("release", scene_text(kDeformable, "[[stage]]\nname = \"now\"\nduration = 0.1\n" + keys),
                           settings);
  };
  const std::string weight = "gravity = [0, -9.81, 0]\n",
                    force = "[[stage.force]]\nblock = \"block\"\npoint = [0.5, 1, 0.5]\nforce = [1, 0, 0]\n";
  for (const std::string& load : {weight, force,
                                  std::string("[[stage.pressure]]\nblock = \"block\"\nnormal = [1, 0, 0]\npressure = "
                                              "1\n"),
                                  std::string("[[stage.velocity]]\nblock = \"block\"\nvelocity = [0, \"free\", 0]\n")})
    EXPECT_THAT(released(load), AllOf(HasSubstr("stage 'now'"), HasSubstr("local damping (gamma 0.8)"))) << load;
  EXPECT_EQ(released(""), "");
  EXPECT_EQ(released("ramp_time = 0.05\n" + weight), "");
  EXPECT_EQ(released("equilibrium_ratio = 1e-3\n" + weight), "");
  EXPECT_EQ(released(weight, {"solver.damping=none"}), "");
  EXPECT_EQ(warning_of_last("release", scene_text(kDeformable, weight)), "") << "the first stage settles";
}

// Eq. 1 at gridpoints drags rigid blocks that move where gamma is above 0.1, and carries collapses of deformable ones.
TEST(Drag, OfBlocksThatMoveIsWarnedOf) {
  const auto of = [](const char* about, const char* block, const std::string& stage, const char* solver) {
    return warning_of_last(about, scene_text(block, stage), {std::string("solver=") + solver});
  };
  const std::string drives = driven("[0.01, 0, 0]"), collapse = "collapse = { direction = [1, 0, 0] }\n";
  const char *const kAtLimit = "{local_damping=0.1}", *const kAbove = "{local_damping=0.11}";
  EXPECT_THAT(of("drag", kRigid, drives, kAbove), HasSubstr("(gamma 0.11)"));
  EXPECT_THAT(of("drag", kRigid, collapse, kAbove), HasSubstr("(gamma 0.11)"));
  EXPECT_EQ(of("drag", kRigid, drives, kAtLimit), "");
  EXPECT_EQ(of("drag", kRigid, "", kAbove), "");
  EXPECT_EQ(of("drag", kRigid, drives, "{damping='block', local_damping=0.8}"), "");
  EXPECT_EQ(of("drag", kDeformable, drives, kAbove), "");
  EXPECT_THAT(of("collapse", kDeformable, collapse, kAtLimit), HasSubstr("(gamma 0.1)"));
  EXPECT_EQ(of("collapse", kDeformable, collapse, "{damping='block'}"), "");
  EXPECT_EQ(of("collapse", kDeformable, drives, kAtLimit), "");
  EXPECT_EQ(of("collapse", kRigid, collapse, kAtLimit), "");
  // Motion counts as along an axis up to 5 % across it.
  EXPECT_EQ(of("angle", kDeformable, driven("[0, 0.01, -0.00049]"), kAtLimit), "");
  EXPECT_THAT(of("angle", kDeformable, driven("[0, 0.01, -0.00051]"), kAtLimit), HasSubstr("'block' at an angle"));
}

// A smooth ramp s = 10 t^3 - 15 t^4 + 6 t^5 takes a velocity v to 0 over v T/2. On its way to -v it is farthest at
// T/2, at v T (1/2 - 2 S) = 11/32 v T. S = 5/64 is the integral of s up to 1/2. A way above 5 % of the smaller
// displacement is warned of.
TEST(Ramp, ThatABodyGoesOnInIsWarnedOf) {
  const auto on = [](const char* velocity, const char* ramp, double asked_before, double asked) {
    const std::string ends = "monitor = \"block\"\ndisplacement = ";
    return warning_of_last(
        "ramp",
        scene_text(kRigid, fmt::format("{}{}\n{}[[stage]]\nname = \"back\"\n{}{}\nramp_time = {}\n{}", ends,
                                       asked_before, driven("[0, 0, 0.01]"), ends, asked, ramp, driven(velocity))));
  };
  EXPECT_THAT(on("[0, 0, 0]", "0.2", 0.0199, 1.0), HasSubstr("from 0.01 to 0 m/s along z over its ramp_time of 0.2 s, "
                                                             "in which it goes on by 1 mm before it stands still"));
  EXPECT_THAT(on("[0, 0, -0.01]", "0.32", 1.0, 0.0219), HasSubstr("goes on by 1.1 mm before it turns back"));
  EXPECT_EQ(on("[0, 0, 0]", "0.2", 0.0201, 1.0), "");
  EXPECT_EQ(on("[0, 0, -0.01]", "0.32", 1.0, 0.0221), "");
  EXPECT_EQ(on("[0, 0, 0.02]", "0.2", 0.001, 0.001), "") << "the same way";
  EXPECT_EQ(on("[0, 0, \"free\"]", "0.2", 0.001, 0.001), "");
  EXPECT_EQ(on("[0, 0, 0]", "0.0", 0.001, 0.001), "");
}

// A stage measures along what it drives: beside x it was not, so that a slow push along z counted as one without work.
TEST(DefaultDirection, IsThatOfTheDrive) {
  const auto direction = [](const char* velocity, const std::vector<std::string>& settings) {
    return read_scene_text(scene_text(kRigid, driven(velocity)), "scene.toml", settings).stages[0].direction;
  };
  EXPECT_EQ(direction("[0, 0, 0.01]", {}), 2);
  EXPECT_EQ(direction("[0, 0.01, 0]", {}), 1);
  EXPECT_EQ(direction("[0.01, 0, 0]", {}), 0);
  EXPECT_EQ(direction("[0.01, 0, 0.01]", {}), 0);
  EXPECT_EQ(direction("[0, 0, 0.01]", {"stage.1.direction=x"}), 0);
  EXPECT_EQ(direction("[0, 0, 0.01]", {"stage.1.displacement=0.001", "stage.1.monitor=block"}), 2);
  EXPECT_EQ(direction("[0, 0, 0.01]", {"stage.1.displacement=0.001", "output.monitor=block"}), 2);
}

// The peak of a push by a force along z was that of what it does along x: 0.13 kN for 12.29.
TEST(DefaultDirection, IsThatOfForcesWhereTheseActAlone) {
  const auto direction = [](const char* force, const std::string& more) {
    const std::string stage = fmt::format("[[stage.force]]\nblock = \"block\"\npoint = [0, 1, 0]\nforce = {}\n", force);
    return read_scene_text(scene_text(kRigid, stage + more), "scene.toml").stages[0].direction;
  };
  EXPECT_EQ(direction("[0, 0, 5]", ""), 2);
  EXPECT_EQ(direction("[0, -5, 0]", ""), 0) << "a load";
  EXPECT_EQ(direction("[0, -5, 5]", ""), 2);
  EXPECT_EQ(direction("[5, 0, 5]", ""), 0);
  EXPECT_EQ(direction("[0, 0, 5]", driven("[0.01, 0, 0]")), 0);
}

// The displacement of a stage is that of its monitor, of buildings that of the last floor.
TEST(DefaultDirection, IsThatOfTheMonitorWhereItEndsTheStage) {
  const std::string other =
      "[[block]]\nname = \"other\"\nmaterial = \"stone\"\nfixed = true\n"
      "box = { lower = [5, 0, 0], size = [1, 1, 1] }\n";
  const std::string stage = "displacement = 0.001\n" + driven("[0.01, 0, 0]") +
                            "[[stage.velocity]]\nblock = \"other\"\nvelocity = [0, 0, -0.01]\n";
  const auto direction = [&](const char* monitor) {
    const std::string text = scene_text(kRigid, stage + other);
    return read_scene_text(text, "scene.toml", {std::string("output.monitor=") + monitor}).stages[0].direction;
  };
  EXPECT_EQ(direction("block"), 0);
  EXPECT_EQ(direction("other"), 2);
  Scene building;
  building.building.emplace();
  BuildingSpec::Floor& floor = building.building->floors.emplace_back();
  floor.name = "roof", floor.half_units = {0, 1};
  Stage pushed;
  pushed.roof = building.building->floors[0].bodies();
  pushed.displacement = 1e-3;
  pushed.controls.resize(2);
  for (std::size_t i = 0; i < 2; ++i)
    pushed.controls[i].body = pushed.roof.at(i), pushed.controls[i].velocity = {0.0, 0.0, 0.01};
  EXPECT_EQ(default_direction(pushed, building), 2);
  pushed.controls[0].body = pushed.controls[1].body = "bottom_beam";
  EXPECT_EQ(default_direction(pushed, building), 0);
}

}  // namespace
}  // namespace quoin
