// The check that a run is slow enough, on rows with prescribed shares of dynamic force and kinetic energy.
#include "results/quasi_static.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace quoin {
namespace {

using ::testing::HasSubstr;

Stage stage_to(double displacement, double ramp_time) {
  Stage stage;
  stage.name = "shear";
  stage.displacement = displacement;
  stage.ramp_time = ramp_time;
  return stage;
}

Scene scene_of(std::vector<Stage> stages) {
  Scene scene;
  scene.stages = std::move(stages);
  return scene;
}

// Returns the rows of a spring of 1e6 N/m extended to `end` in 1 s: force up to 1e6 end, work 0.5e6 end^2.
std::vector<HistoryRow> pulled_spring(double end, int count = 101) {
  std::vector<HistoryRow> rows(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    HistoryRow& row = rows[static_cast<std::size_t>(i)];
    row.time = static_cast<double>(i) / (count - 1);
    row.displacement = end * row.time;
    row.resistance = 1e6 * row.displacement;
  }
  return rows;
}

TEST(QuasiStatic, HoldsWhereInertiaIsSmall) {
  auto rows = pulled_spring(0.01);
  for (HistoryRow& row : rows) row.dynamic_force = 100.0;  // of 10 kN
  rows[50].kinetic_energy = 0.5;                           // of 50 J
  const QuasiStatic check = check_quasi_static(rows, scene_of({stage_to(0.01, 0.1)}));
  EXPECT_TRUE(check.quasi_static()) << check.reason();
  EXPECT_NEAR(check.dynamic_force_ratio.value(), 0.01, 1e-12);
  EXPECT_NEAR(check.kinetic_energy_ratio.value(), 0.01, 1e-12);
  EXPECT_NEAR(check.overshoot_ratio, 0.0, 1e-12);
  EXPECT_EQ(check.warning(), "");
}

// A block that is driven fast over rough ground lands on its edge: the peak is that of the blow, a few rows of many.
TEST(QuasiStatic, InertiaAtThePeakAlone) {
  auto rows = pulled_spring(0.01);
  rows.back().monitor_inertia = 1200.0;  // of 10 kN
  const QuasiStatic check = check_quasi_static(rows, scene_of({stage_to(0.01, 0.1)}));
  EXPECT_NEAR(check.dynamic_force_at_peak.value(), 0.12, 1e-12);
  EXPECT_THAT(check.warning(), HasSubstr("inertia is 12 % of the peak force when that is reached, allowed 10 %"));
  rows.back().monitor_inertia = 0.0;
  rows[50].monitor_inertia = 1200.0;  // not at the peak
  EXPECT_TRUE(check_quasi_static(rows, scene_of({stage_to(0.01, 0.1)})).quasi_static());
}

TEST(QuasiStatic, InertiaAndKineticEnergyAboveWhatIsAllowed) {
  auto rows = pulled_spring(0.01);
  for (HistoryRow& row : rows) row.dynamic_force = 600.0;
  EXPECT_THAT(check_quasi_static(rows, scene_of({stage_to(0.01, 0.1)})).warning(),
              HasSubstr("inertia carries 6.0 % of the peak force (root of the mean square), allowed 5 %"));
  rows = pulled_spring(0.01);
  rows[50].kinetic_energy = 3.0;
  EXPECT_THAT(check_quasi_static(rows, scene_of({stage_to(0.01, 0.1)})).warning(),
              HasSubstr("kinetic energy reaches 6.0 % of the work, allowed 5 %"));
}

// With half of the thickness, forces and work are those of the whole wall, but kinetic energy is that of the half.
TEST(QuasiStatic, KineticEnergyOfHalfAWallCountsTwice) {
  auto rows = pulled_spring(0.01);
  rows[50].kinetic_energy = 2.0;  // of 50 J
  Scene scene = scene_of({stage_to(0.01, 0.1)});
  scene.wall.emplace();
  EXPECT_NEAR(check_quasi_static(rows, scene).kinetic_energy_ratio.value(), 0.04, 1e-12);
  scene.wall->half_thickness = true;
  EXPECT_NEAR(check_quasi_static(rows, scene).kinetic_energy_ratio.value(), 0.08, 1e-12);
  EXPECT_THAT(check_quasi_static(rows, scene).reason(), HasSubstr("kinetic energy reaches 8.0 % of the work"));
}

// Ramps are checked, since the force may be largest in a ramp, and reversals consist of ramps.
TEST(QuasiStatic, RampsCount) {
  auto rows = pulled_spring(0.01);
  for (std::size_t i = 0; i < 50; ++i) rows[i].dynamic_force = 2000.0;
  EXPECT_FALSE(check_quasi_static(rows, scene_of({stage_to(0.01, 0.6)})).quasi_static());
  // A ramp without dynamic force does not compensate later ones: 600 N of 10 kN in the second half, 0 in the first.
  rows = pulled_spring(0.01);
  for (std::size_t i = 50; i < rows.size(); ++i) rows[i].dynamic_force = 600.0;
  EXPECT_NEAR(check_quasi_static(rows, scene_of({stage_to(0.01, 0.5)})).dynamic_force_ratio.value(), 0.06, 1e-12);
}

TEST(QuasiStatic, StageThatEndsInItsRampIsNotVouchedFor) {
  const QuasiStatic check = check_quasi_static(pulled_spring(0.01), scene_of({stage_to(0.01, 1.5)}));
  EXPECT_FALSE(check.quasi_static());
  EXPECT_THAT(check.warning(), HasSubstr("stage 'shear' ended inside its ramp of 1.5 s"));
}

TEST(QuasiStatic, NothingToJudgeByIsNotVouchedFor) {
  Scene scene = scene_of({stage_to(0.01, 0.0)});
  scene.output.monitor = "spring";
  EXPECT_THAT(check_quasi_static({}, scene).warning(), HasSubstr("no stage that drives a body was reached"));
  EXPECT_THAT(check_quasi_static(pulled_spring(0.01, 2), scene).warning(), HasSubstr("2 rows, too few"));
  EXPECT_THAT(check_quasi_static(pulled_spring(0.0), scene).warning(), HasSubstr("did no work"));
  // A scene without motion after the load: no statement that it is quasi-static, and no warning.
  Stage press;
  press.equilibrium_ratio = 1e-3;
  const QuasiStatic pressed = check_quasi_static(pulled_spring(0.01), scene_of({press}));
  EXPECT_FALSE(pressed.quasi_static());
  EXPECT_FALSE(pressed.dynamic_force_ratio.has_value());
  EXPECT_EQ(pressed.warning(), "");
}

// A NaN in a column must not count as small: the maximum of a number and NaN is the number.
TEST(QuasiStatic, WhatIsNoNumberIsNotVouchedFor) {
  for (double HistoryRow::*column :
       {&HistoryRow::kinetic_energy, &HistoryRow::dynamic_force, &HistoryRow::resistance}) {
    auto rows = pulled_spring(0.01);
    rows[50].*column = std::nan("");
    const QuasiStatic check = check_quasi_static(rows, scene_of({stage_to(0.01, 0.1)}));
    EXPECT_FALSE(check.quasi_static());
    EXPECT_THAT(check.warning(), HasSubstr("stage 'shear' has forces or energies that are no numbers"));
  }
}

TEST(QuasiStatic, GoingBeyondTheDisplacementAskedFor) {
  EXPECT_TRUE(check_quasi_static(pulled_spring(0.01005), scene_of({stage_to(0.01, 0.1)})).quasi_static());
  const QuasiStatic check = check_quasi_static(pulled_spring(0.0408), scene_of({stage_to(0.01, 0.1)}));
  EXPECT_NEAR(check.overshoot_ratio, 3.08, 1e-9);
  EXPECT_THAT(check.warning(), HasSubstr("308.0 % beyond"));
}

// A stage with a velocity and a duration, without a displacement at which it ends, is checked too.
TEST(QuasiStatic, StagesOfGivenDurationAreJudged) {
  Stage stage = stage_to(0.01, 0.1);
  stage.displacement.reset();
  stage.duration = 1.0;
  BodyControl top;
  top.velocity = {0.01, 0.0, 0.0};
  stage.controls = {top};
  auto rows = pulled_spring(0.01);
  EXPECT_TRUE(check_quasi_static(rows, scene_of({stage})).quasi_static());
  for (HistoryRow& row : rows) row.dynamic_force = 600.0;
  EXPECT_FALSE(check_quasi_static(rows, scene_of({stage})).quasi_static());
}

}  // namespace
}  // namespace quoin
