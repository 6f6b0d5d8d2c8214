// Cyclic displacements: on the lattice, in large motion, of blocks of any shape, and through a whiffletree.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "../scene_of_text.h"
#include "support.h"

namespace quoin {
namespace {

// The small wall. Its second stage has cycles of 0.1 and 0.2 mm: 1.4 mm in total at 0.05 m/s, and 5 ramps.
Scene wall(std::vector<std::string> more = {}) {
  std::ifstream stream(QUOIN_HOST_TESTS "/../cli/small_wall.toml");
  std::string text((std::istreambuf_iterator<char>(stream)), {});
  const std::size_t stage = text.find("[[stage]]\nname = \"shear\""), output = text.find("[output]");
  text.replace(stage, output - stage,
               "[[stage]]\nname = \"cycles\"\nkind = \"cycles\"\namplitudes = [1e-4, 2e-4]\nvelocity = 0.05\n"
               "ramp_time = 0.001\nrecord_interval = 1\n\n");
  return scene_of_text(text, more);
}

struct RowsOfStage : Observer {
  std::vector<HistoryRow> rows;  // rows of the stage with cycles
  int stage;
  int promotions = 0;
  explicit RowsOfStage(int of_stage) : stage(of_stage) {}
  void on_row(const HistoryRow& row) override {
    if (row.stage == stage) rows.push_back(row);
  }
  void on_promotion(const Simulation&) override { ++promotions; }
};

// The displacement of every step is that of the closed form, so the amplitudes are exact to 1e-9 m between two steps.
// The acceleration is at most that of the smooth step, 15/8 v/r.
void expect_closed_form(const std::vector<HistoryRow>& rows, const Stage& stage, double start) {
  const CyclicMotion motion(*stage.cycles);
  double largest = 0.0, least = 0.0, before = 0.0;
  const double dt = rows[1].time - rows[0].time;
  for (std::size_t i = 1; i + 1 < rows.size(); ++i) {  // the last row is two steps after the one before it
    const double time = rows[i].time - start - dt;     // a row has the displacement at the time of its forces
    ASSERT_NEAR(rows[i].displacement, motion.position(time), 1e-13) << i;
    largest = std::max(largest, rows[i].displacement), least = std::min(least, rows[i].displacement);
    const double velocity = (rows[i].displacement - rows[i - 1].displacement) / dt;
    ASSERT_LE(std::abs(velocity - before),
              std::abs(stage.cycles->velocity) * 15 / 8 / stage.ramp_time * dt * 1.01 + 1e-9)
        << i;
    before = velocity;
  }
  const double amplitude = stage.cycles->amplitudes.back();
  EXPECT_NEAR(largest, amplitude, 1e-9);
  EXPECT_NEAR(least, -amplitude, 1e-9);
  EXPECT_NEAR(rows.back().displacement, 0.0, 1e-9);
}

double start_of(const std::vector<HistoryRow>& rows) { return 2 * rows[0].time - rows[1].time; }

TEST(Cycles, OfAWallReachTheirAmplitudes) {
  for (const char* vertical : {"held", "pressure"}) {
    const Scene scene = wall({std::string("stage.cycles.vertical=") + vertical});
    Simulation s(scene);
    RowsOfStage rows(1);
    s.run(rows);
    EXPECT_FALSE(s.large_motion());
    expect_closed_form(rows.rows, scene.stages[1], start_of(rows.rows));
    EXPECT_NEAR(rows.rows.back().time - start_of(rows.rows), *scene.stages[1].duration,
                2 * s.time_step_report().time_step);
    EXPECT_TRUE(s.outcome().force_losses.empty());
  }
}

TEST(Cycles, InLargeMotionReachTheirAmplitudes) {
  const Scene scene = wall({"solver.large_motion=always", "stage.cycles.vertical=pressure"});
  Simulation s(scene);
  RowsOfStage rows(1);
  s.run(rows);
  ASSERT_TRUE(s.large_motion());
  expect_closed_form(rows.rows, scene.stages[1], start_of(rows.rows));
}

// From the lattice to large motion in the middle of a cycle.
TEST(Cycles, GoOnThroughAPromotion) {
  const Scene scene = wall({"solver.rotation_bound=1e-4", "stage.cycles.vertical=pressure"});
  Simulation s(scene);
  RowsOfStage rows(1);
  s.run(rows);
  EXPECT_EQ(rows.promotions, 1);
  const CyclicMotion motion(*scene.stages[1].cycles);
  double largest = 0.0, least = 0.0;
  for (const HistoryRow& row : rows.rows)
    largest = std::max(largest, row.displacement), least = std::min(least, row.displacement);
  EXPECT_NEAR(largest, 2e-4, 1e-9);
  EXPECT_NEAR(least, -2e-4, 1e-9);
  EXPECT_NEAR(rows.rows.back().displacement, 0.0, 1e-9);
}

// A beam that moves at the end of the previous stage: its velocity is continuous.
TEST(Cycles, TakeOverWhatStillMoves) {
  Scene scene = wall();
  Stage shear = scene.stages[1];
  shear.cycles.reset();
  shear.controls[1].in_cycles = -1;
  shear.duration = 1e-3;
  scene.stages.insert(scene.stages.begin() + 1, shear);
  Simulation s(scene);
  RowsOfStage rows(2);
  s.run(rows);
  const double dt = rows.rows[1].time - rows.rows[0].time;
  EXPECT_NEAR(rows.rows[0].displacement, 0.0, 1e-15);
  EXPECT_NEAR(rows.rows[1].displacement, CyclicMotion(*scene.stages[2].cycles).position(dt, 0.05), 1e-11);
  double largest = 0.0;
  for (const HistoryRow& row : rows.rows) largest = std::max(largest, row.displacement);
  EXPECT_NEAR(largest, 2e-4, 1e-9);
  EXPECT_NEAR(rows.rows.back().displacement, 0.0, 1e-9);
}

// Three cycles of 0.1 mm of a joint that softens: the second half cycle in a direction has a smaller force than the
// first.
TEST(Cycles, StopWhereAHalfCycleLosesForce) {
  const std::vector<std::string> more{"stage.cycles.amplitudes=[2e-4]", "stage.cycles.cycles=3"};
  const auto run = [&](const std::string& fraction) {
    std::vector<std::string> settings = more;
    if (!fraction.empty()) settings.push_back("stage.cycles.stop_at_force_loss=" + fraction);
    auto s = std::make_unique<Simulation>(wall(settings));
    RowsOfStage rows(1);
    s->run(rows);
    return std::pair{std::move(s), rows.rows};
  };
  const auto [whole, rows] = run("");
  const CyclicMotion motion(*whole->scene().stages[1].cycles);
  double largest[7] = {};
  for (const HistoryRow& row : rows) {
    const int h = motion.half_cycle(row.time - start_of(rows));
    largest[h] = std::max(largest[h], h % 2 == 0 ? row.resistance : -row.resistance);
  }
  const double kept = largest[2] / largest[0];
  ASSERT_LT(kept, 0.95);
  ASSERT_GT(largest[1], 0.0);
  // Forces are checked every 20 steps at most, so the largest one may be missed by a little.
  EXPECT_TRUE(run(std::to_string(0.97 * std::min({kept, largest[3] / largest[1], largest[4] / largest[0],
                                                  largest[5] / largest[1]})))
                  .first->outcome()
                  .force_losses.empty());
  const auto [stopped, fewer] = run(std::to_string(std::min(1.0, 1.03 * kept)));
  ASSERT_EQ(stopped->outcome().force_losses.size(), 1u);
  const StopAtForceLoss& stop = stopped->outcome().force_losses[0];
  EXPECT_EQ(stop.stage, 1);
  EXPECT_EQ(stop.half_cycle, 2);
  EXPECT_NEAR(stop.largest, largest[0], 0.01 * largest[0]);
  EXPECT_NEAR(stop.force, largest[2], 0.01 * largest[0]);
  EXPECT_LT(fewer.size(), rows.size());
  // The run ends within 20 steps of the reversal at +0.2 mm.
  EXPECT_NEAR(fewer.back().displacement, 2e-4, 5e-6);
}

// An elastic joint loses no force. A half cycle of the cube has some 60 steps: a check every 20 of them read 0 to 0.96
// of the largest force, and ended the stage.
TEST(Cycles, OfFewStepsLoseNoForceInAnElasticJoint) {
  const Scene scene = scene_of_text(R"([materials.stone]
density = 2000
[joints.elastic]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 1e9
[[block]]
material = "stone"
fixed = true
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[block]]
name = "moved"
material = "stone"
box = { lower = [0, 1, 0], size = [1, 1, 1] }
[output]
monitor = "moved"
[[stage]]
kind = "cycles"
block = "moved"
amplitudes = [5e-4]
cycles = 6
cycle_velocity = 0.05
ramp_time = 0.002
stop_at_force_loss = 0.98
)");
  Simulation s(scene);
  RowsOfStage rows(0);
  s.run(rows);
  EXPECT_LT(*scene.stages[0].duration / s.time_step_report().time_step, 13 * 100.0);
  EXPECT_TRUE(s.outcome().force_losses.empty());
  EXPECT_NEAR(rows.rows.back().displacement, 0.0, 1e-9);
}

const char* const kBlocks = R"([materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 5e8
friction_angle = 30
[[block]]
name = "foot"
material = "stone"
fixed = true
box = { lower = [0, 0, 0], size = [1, 0.2, 1] }
[[block]]
name = "head"
material = "stone"
box = { lower = [0, 0.2, 0], size = [1, 0.2, 1] }
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
ramp_time = 0.05
duration = 0.1
[[stage.velocity]]
block = "head"
velocity = [0.0, "free", 0.0]
[[stage]]
name = "cycles"
kind = "cycles"
block = "head"
amplitudes = [1e-4, 3e-4]
cycle_velocity = 0.01
ramp_time = 0.01
record_interval = 1
[[stage.velocity]]
block = "head"
velocity = [0.0, "free", 0.0]
)";

// A dry block of 400 kg slides back and forth on another one: friction mu N in every half cycle, 0.577 x 3924 N.
TEST(Cycles, OfABlockReachTheirAmplitudesInEveryKindOfMotion) {
  for (const char* how : {"solver.kernels=lattice", "solver.kernels=general", "solver.large_motion=always"}) {
    SCOPED_TRACE(how);
    const Scene scene = scene_of_text(kBlocks, {how});
    Simulation s(scene);
    RowsOfStage rows(1);
    s.run(rows);
    EXPECT_EQ(s.large_motion() == nullptr, how == std::string("solver.kernels=lattice"));
    expect_closed_form(rows.rows, scene.stages[1], start_of(rows.rows));
    double largest = 0.0;
    for (const HistoryRow& row : rows.rows) largest = std::max(largest, std::abs(row.resistance));
    EXPECT_NEAR(largest, std::tan(M_PI / 6) * 400 * 9.81, 0.02 * 2265);
  }
}

// u is the end of the whiffletree's spring: the mean displacement of the floors plus the extension F/K.
TEST(Cycles, OfAWhiffletreeReachTheirAmplitudes) {
  std::ifstream stream(QUOIN_HOST_TESTS "/small_building.toml");
  std::string text((std::istreambuf_iterator<char>(stream)), {});
  text.resize(text.find("[[stage]]\nname = \"push\""));
  text +=
      "[[stage]]\nname = \"cycles\"\nkind = \"cycles\"\namplitudes = [2e-4, 5e-4]\nvelocity = 0.01\nstiffness = 1e8\n"
      "ramp_time = 0.02\nrecord_interval = 1\n";
  const Scene scene = scene_of_text(text, {"stage.weight.equilibrium_ratio=0.1"});
  ASSERT_TRUE(scene.stages[1].whiffletree);
  Simulation s(scene);
  RowsOfStage rows(1);
  s.run(rows);
  // One floor: the base shear is the force of the whiffletree, except for inertia and damping.
  const CyclicMotion motion(*scene.stages[1].cycles);
  double miss = 0.0, largest = 0.0, least = 0.0;
  const double start = start_of(rows.rows);
  for (const HistoryRow& row : rows.rows) {
    const double u = row.displacement + row.resistance / 1e8;
    miss = std::max(miss, std::abs(u - motion.position(row.time - start)));
    largest = std::max(largest, u), least = std::min(least, u);
  }
  EXPECT_LT(miss, 0.05 * 5e-4);
  EXPECT_NEAR(largest, 5e-4, 0.05 * 5e-4);
  EXPECT_NEAR(least, -5e-4, 0.05 * 5e-4);
}

}  // namespace
}  // namespace quoin
