// The test rig: a dry wall with a free top rotation rocks at N L/(2 H0), for any height of the force.
#include <gmock/gmock.h>

#include "program.h"
#include "validate/wall_scene.h"
#include "walls.h"

namespace {

using namespace quoin::validate;
using Rig = Cli;

class Rocking : public Cli, public ::testing::WithParamInterface<const char*> {};

// The toe has a width, since blocks and joints deform, so the lever arm is a little shorter than half of the length. A
// force above the equilibrium of the rigid wall is dynamic: tolerance 3 %.
TEST_P(Rocking, ForceFollowsFromTheShearSpan) {
  auto wall = dry_wall();
  wall["shear_span_over_height"] = GetParam();
  write_walls(folder_ / "walls.csv", {wall});
  const WallRow row = read_wall_table((folder_ / "walls.csv").string()).rows.at(0);
  const bool held = std::string(GetParam()) == "0.5";
  // Slow, since a stiff wall vibrates at uplift.
  ASSERT_EQ(quoin({"validate", "--walls", (folder_ / "walls.csv").string(), "--out", out(), "--jobs", "1", "--set",
                   "joints.bed.normal_stiffness=1e11", "--set", "joints.bed.shear_stiffness=4e10", "--set",
                   held ? "stage.shear.velocity=0.002" : "stage.shear.control.2.velocity=[0.004, \"free\", 0]"}),
            0)
      << error_;
  const std::string csv = read_all(folder_ / "out" / "validation.csv");
  const std::string values = csv.substr(csv.find("1,test,dry,") + 11);
  const double peak = std::stod(values), rigid = rocking_force_with_weight(row);
  EXPECT_LT(peak, 1.03 * rigid);
  EXPECT_GT(peak, 0.94 * rigid);
  // Rocking, or a hybrid mode that begins with rocking: dry head joints open where blocks lift off along a stair.
  EXPECT_THAT(csv, ::testing::AnyOf(::testing::HasSubstr(",F,F\n"), ::testing::HasSubstr(",H-FS,F\n")));
}
INSTANTIATE_TEST_SUITE_P(Spans, Rocking, ::testing::Values("0.5", "0.75", "1", "1.5"));

// Bricks of 240 x 115 x 55 mm in mortar of 10 mm: steps of 250 and 65 mm. Half units, and the unit in the scene, m.
TEST(Layout, IsThatOfUnitsAndTheirJoints) {
  WallRow single;
  single.length = 2.0, single.height = 1.3, single.thickness = 0.115, single.axial_stress = 0.5;
  single.unit_length = 240, single.unit_width = 115, single.unit_height = 55;
  const auto expect = [](const WallRow& row, int half_units, const std::string& unit) {
    const TestScene scene = scene_of(row, false);
    EXPECT_EQ(scene.half_units, half_units) << unit;
    EXPECT_THAT(scene.text, ::testing::HasSubstr("\nunit = [" + unit + "]\n"));
  };
  const auto with = [&](double WallRow::*number, double value) {
    WallRow row = single;
    row.*number = value;
    return row;
  };
  expect(single, 20 * 16, "0.25, 0.065, 0.115");
  expect(with(&WallRow::thickness, 0.17), 20 * 16, "0.25, 0.065, 0.17");        // below 1.5 widths
  expect(with(&WallRow::thickness, 0.24), 20 * 21, "0.19047619, 0.065, 0.24");  // headers: steps of 187.5 mm
  expect(with(&WallRow::length, 5.0), 10 * 20, "0.5, 0.13, 0.115");             // 800 half units: two for one
  expect(with(&WallRow::length, 4.375), 20 * 35, "0.25, 0.065, 0.115");         // 700
  expect(with(&WallRow::height, 0.05), 2 * 16, "0.25, 0.025, 0.115");           // two courses at least
  expect(with(&WallRow::length, 0.1), 20 * 2, "0.1, 0.065, 0.115");             // one unit at least
  WallRow row = single;
  row.courses = 19;
  expect(row, 19 * 16, "0.25, 0.0684210526, 0.115");
  row = single, row.bed_joints = "TL";  // 2 mm: steps of 242 and 57 mm
  expect(row, 23 * 17, "0.235294118, 0.0565217391, 0.115");
  row.head_joints = "GP";
  expect(row, 23 * 16, "0.25, 0.0565217391, 0.115");
  row = single, row.bed_joints = row.head_joints = "DRY";
  expect(row, 24 * 17, "0.235294118, 0.0541666667, 0.115");
  // Only "U" was without a joint: "UNFILLED", which the table allows too, had 10 mm.
  for (const char* unfilled : {"U", "u", "UNFILLED", "D"}) {
    row = single, row.head_joints = unfilled;
    expect(row, 20 * 17, "0.235294118, 0.065, 0.115");
  }
  row = single, row.unit_length = row.unit_width = row.unit_height = {};  // 250 and 65 mm, without joints
  expect(row, 17 * 15, "0.266666667, 0.0764705882, 0.115");
}

// host/validate/README.md, "The rig": beam of 7850 x 9.81 x 0.1 = 7700.85 Pa; 1 % of the height, over H/H0.
TEST(Stages, AreThoseOfTheRig) {
  WallRow row;
  row.length = 2.0, row.height = 1.5, row.thickness = 0.25, row.axial_stress = 0.5;
  const auto has = [&](bool cyclic, std::initializer_list<const char*> texts) {
    for (const char* text : texts) EXPECT_THAT(scene_of(row, cyclic).text, ::testing::HasSubstr(text));
  };
  has(false,
      {"\npressure = 492299 ", "\ngravity = [0, -9.81, 0]\n", "\ndisplacement = 0.015\nvertical = \"pressure\"\n",
       "law = \"fracture_energy\"", "\nbeam_height = 0.1\nbeam_density = 7850\n", "\nzones = [4, 2, 2]\n"});
  has(true, {"\namplitudes = [0.0015, 0.003, 0.0045, 0.0075, 0.012]\nvelocity = 0.01\nramp_time = 0.05\n",
             "law = \"cyclic_joint\"", "\nresidual_opening = 0.3\n", "\ncompressive_peak_closure = 9e-5\n"});
  EXPECT_EQ(scene_of(row, false).load_height, 1.5);
  row.shear_span = 1.2;  // turns: half of the wall under half of 250 kN less the beam's weight
  EXPECT_NEAR(scene_of(row, false).load_height, 1.8, 1e-12);
  EXPECT_NEAR(scene_of(row, false).top_displacement, 1 / 1.2, 1e-12);
  has(false, {"\nload_height = 1.8 ", "\nramp_time = 0.05\ndisplacement = 0.018\n",
              "\nrotation_held = false\nvelocity = [0.02, \"free\", 0]\nforce = [0, -123074.78"});
  has(true, {"\namplitudes = [0.0018, ", "\nbody = \"top_beam\"\n", "\nvelocity = [0, \"free\", 0]\n"});
  row.axial_stress = 0.0;
  has(false, {"\npressure = 0 "});
}

// The table of codes in host/validate/README.md.
TEST(Codes, NameUnitsAndJoints) {
  using quoin::JointKind, quoin::UnitKind;
  WallRow row;
  row.length = row.height = 1.0, row.thickness = 0.1;
  for (const auto& [code, kind] : {std::pair("CS-B", UnitKind::calcium_silicate),
                                   {"V-AAC", UnitKind::aerated_concrete},
                                   {"st", UnitKind::stone},
                                   {"C", UnitKind::concrete},
                                   {"LAC-1", UnitKind::concrete},
                                   {"LWC", UnitKind::concrete},
                                   {"SB", UnitKind::clay},
                                   {"", UnitKind::clay},
                                   {"H", UnitKind::hollow_clay},
                                   {"V1", UnitKind::hollow_clay},
                                   {"P", UnitKind::hollow_clay}}) {
    row.unit_type = code;
    EXPECT_EQ(tested_masonry(row).unit, kind) << code;
  }
  for (const auto& [code, kind] : {std::pair("GP", JointKind::mortar),
                                   {"F", JointKind::mortar},
                                   {"", JointKind::mortar},
                                   {"TL", JointKind::thin},
                                   {"TF", JointKind::thin},
                                   {"DRY", JointKind::dry},
                                   {"d", JointKind::dry}}) {
    row.bed_joints = code;
    EXPECT_EQ(tested_masonry(row).bed, kind) << code;
    EXPECT_EQ(tested_masonry(row).head, kind) << code;  // blank: as the bed
  }
  row.unit_strength = 20, row.unit_strength_normalised = 18, row.mortar_strength = 6, row.masonry_strength = 7;
  row.cohesion = 0.2, row.friction = 0.6, row.axial_stress = 1.5;
  const quoin::TestedMasonry t = tested_masonry(row);
  EXPECT_EQ(*t.unit_strength, 20e6);
  EXPECT_EQ(*t.unit_strength_normalised, 18e6);
  EXPECT_EQ(*t.mortar_strength, 6e6);
  EXPECT_EQ(*t.masonry_strength, 7e6);
  EXPECT_EQ(*t.cohesion, 0.2e6);
  EXPECT_EQ(*t.friction, 0.6);
  EXPECT_EQ(t.axial_stress, 1.5e6);
}

TEST_F(Rig, ALoadHeightIsRefusedWhereItWouldBeLost) {
  EXPECT_EQ(quoin({"check", small_, "--set", "wall.load_height=0.2"}), 3);
  EXPECT_THAT(error_, ::testing::HasSubstr("wall.load_height"));
  EXPECT_THAT(error_, ::testing::HasSubstr("large_motion"));
  EXPECT_EQ(quoin({"check", small_, "--set", "wall.load_height=0.2", "--set", "solver.large_motion=never"}), 0)
      << error_;
}

}  // namespace
