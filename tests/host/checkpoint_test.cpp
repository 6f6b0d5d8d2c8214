// A run restored from any of its checkpoints is bitwise identical, in state and history, to the uninterrupted run.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "../scene_of_text.h"
#include "base/archive.h"
#include "base/error.h"
#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "step/simulation.h"
#include "support.h"

namespace quoin {
namespace {

struct Saved {
  std::vector<std::uint8_t> bytes;
  std::size_t rows;
  long step;
};

// Saves states at pauses 1, 2, 3, 5, 8, ... and at the first eight multiples of 61. Saves also at the first and last
// pause of each stage, and at the first pauses after contact detections, up to four.
struct Saver : Observer {
  std::vector<HistoryRow> rows;
  std::vector<Saved> saved;
  long pauses = 0, next = 1, before_next = 1, detections = -1;
  int stage = -1, seen_stage = -1, after_detection = 0, further = 0;
  Saved latest;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  void on_stage_begin(const Simulation&, int index) override { stage = index; }
  void on_pause(const Simulation& simulation, bool) override {
    bool take = ++pauses == next;
    if (take) next += std::exchange(before_next, next);
    if (std::exchange(seen_stage, stage) != stage) take = true;
    if (const blocks::Model* m = simulation.large_motion()) {
      if (detections >= 0 && m->detection.count != detections && after_detection++ < 4) take = true;
      detections = m->detection.count;
    }
    if (pauses % 61 == 0 && further++ < 8) take = true;
    latest = {simulation.save(), rows.size(), simulation.step()};
    if (take) saved.push_back(latest);
  }
  void on_stage_end(const Simulation&, int, const HistoryRow&) override { saved.push_back(latest); }
};

struct Rows : Observer {
  std::vector<HistoryRow> rows;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
};

void expect_same(const HistoryRow& a, const HistoryRow& b) {
  EXPECT_EQ(a.stage, b.stage);
  EXPECT_EQ(a.step, b.step);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.displacement, b.displacement);
  EXPECT_EQ(a.resistance, b.resistance);
  EXPECT_EQ(a.vertical_force, b.vertical_force);
  EXPECT_EQ(a.monitor_displacement, b.monitor_displacement);
  EXPECT_EQ(a.joint_force, b.joint_force);
  EXPECT_EQ(a.dynamic_force, b.dynamic_force);
  EXPECT_EQ(a.unbalanced_ratio, b.unbalanced_ratio);
  EXPECT_EQ(a.kinetic_energy, b.kinetic_energy);
  EXPECT_EQ(a.multiplier, b.multiplier);
  EXPECT_EQ(a.largest_displacement, b.largest_displacement);
  ASSERT_EQ(a.energies.has_value(), b.energies.has_value());
  if (!a.energies) return;
  EXPECT_EQ(a.energies->balance_error(), b.energies->balance_error());
  EXPECT_EQ(a.energies->external, b.energies->external);
  EXPECT_EQ(a.energies->damping, b.energies->damping);
}

// Restores every checkpoint of a run of the scene, with 1 and 4 threads alternately. Returns the number of contact
// detections.
long expect_restores(const Scene& scene) {
  Simulation whole(scene, 1);
  Saver saver;
  whole.run(saver);
  EXPECT_GE(saver.saved.size(), scene.stages.size() + 4);
  for (std::size_t i = 0; i < saver.saved.size(); ++i) {
    const Saved& from = saver.saved[i];
    SCOPED_TRACE("from step " + std::to_string(from.step) + " of " + std::to_string(whole.step()));
    Simulation again(scene, i % 2 == 0 ? 4 : 1);
    again.restore(from.bytes);
    EXPECT_EQ(again.step(), from.step);
    Rows rest;
    again.run(rest);
    EXPECT_EQ(again.hash(), whole.hash());
    EXPECT_EQ(again.step(), whole.step());
    EXPECT_EQ(again.time(), whole.time());
    EXPECT_EQ(condition_counts(again), condition_counts(whole));
    EXPECT_EQ(again.outcome().collapse_multiplier, whole.outcome().collapse_multiplier);
    EXPECT_EQ(again.outcome().base_slip_at_uplift, whole.outcome().base_slip_at_uplift);
    const auto &losses = again.outcome().force_losses, &of_whole = whole.outcome().force_losses;
    EXPECT_EQ(losses.size(), of_whole.size());
    for (std::size_t k = 0; k < std::min(losses.size(), of_whole.size()); ++k) {
      EXPECT_EQ(losses[k].half_cycle, of_whole[k].half_cycle);
      EXPECT_EQ(losses[k].force, of_whole[k].force);
    }
    if (const blocks::Model* m = again.large_motion()) {
      EXPECT_EQ(m->detection.count, whole.large_motion()->detection.count);
      EXPECT_EQ(m->stepping.dt, whole.large_motion()->stepping.dt);
    }
    EXPECT_EQ(rest.rows.size(), saver.rows.size() - from.rows);
    for (std::size_t k = 0; k < std::min(rest.rows.size(), saver.rows.size() - from.rows); ++k)
      expect_same(rest.rows[k], saver.rows[from.rows + k]);
    if (::testing::Test::HasFailure()) break;
  }
  return whole.large_motion() ? whole.large_motion()->detection.count : 0;
}

Scene scene_of(const std::string& name, std::vector<std::string> overrides) {
  return read_scene(name.find('/') != std::string::npos ? name : QUOIN_SCENES "/" + name, overrides);
}

TEST(Checkpoint, WallGoesOnBitForBit) {
  Scene scene = scene_of(QUOIN_HOST_TESTS "/../cli/small_wall.toml", {"stage.shear.displacement=0.0002"});
  expect_restores(scene);
  scene.output.energy = true;
  expect_restores(scene);
}

// Damping by block, another damping in the first stage, and units whose halves separate during the run.
TEST(Checkpoint, WallInLargeMotionGoesOnBitForBit) {
  const Scene scene =
      scene_of(QUOIN_HOST_TESTS "/halves_part.toml", {"solver.large_motion=always", "output.energy=true"});
  Simulation start(scene, 1);
  EXPECT_EQ(start.large_motion()->units.count, 2);
  Observer nobody;
  start.run_stage(nobody), start.run_stage(nobody);
  EXPECT_EQ(start.large_motion()->units.count, 1) << "none came apart";
  start.run(nobody);
  EXPECT_EQ(start.large_motion()->units.count, 2) << "they have not met again";
  expect_restores(scene);
}

// Checkpoints in the middle of half cycles, and after a half cycle that ended by loss of force.
TEST(Checkpoint, CyclesGoOnBitForBit) {
  Scene scene = scene_of(QUOIN_HOST_TESTS "/../cli/small_wall.toml", {});
  Stage& stage = scene.stages.back();
  stage.displacement.reset();
  stage.ramp_time = 0.001;
  stage.cycles = Cycles{{2e-4}, {3}, 0.05, 0.001, 0.98};
  stage.duration = CyclicMotion(*stage.cycles).duration();
  stage.controls.back().in_cycles = 0;
  Stage back = stage;
  back.cycles->amplitudes = {5e-5};
  back.duration = CyclicMotion(*back.cycles).duration();
  scene.stages.push_back(back);
  Simulation whole(scene, 1);
  Rows rows;
  whole.run(rows);
  ASSERT_FALSE(whole.outcome().force_losses.empty());
  expect_restores(scene);
  scene.solver.large_motion = LargeMotion::always;
  expect_restores(scene);
}

TEST(Checkpoint, BuildingGoesOnBitForBit) {
  expect_restores(scene_of(QUOIN_HOST_TESTS "/small_building.toml",
                           {"stage.push.displacement=0.002", "stage.weight.equilibrium_ratio=0.1"}));
}

TEST(Checkpoint, WallGoesOnAfterItsLawWasSwapped) {
  Scene scene = scene_of(QUOIN_HOST_TESTS "/../cli/small_wall.toml", {"stage.shear.displacement=0.0001"});
  Stage more = scene.stages.back();
  more.law_swaps["mortar"] = "coulomb_slip";
  scene.stages.push_back(more);
  expect_restores(scene);
}

// Deformable blocks with unequal gridpoints that slide on each other: feet of points on triangles move in every step.
// The shake after it has a time step of its own, which follows from where they are.
TEST(Checkpoint, SlidingBlocksHaveTheTimeStepOfTheNextStageBitForBit) {
  expect_restores(scene_of_text(R"(
[materials.stone]
young_modulus = 1e9
poisson_ratio = 0.2
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 2e9
shear_stiffness = 1e9
friction_angle = 20.0
[[block]]
name = "base"
material = "stone"
fixed = true
box = { lower = [-1, -1, 0], size = [3, 1, 1] }
[[block]]
name = "low"
material = "stone"
rigid = false
divisions = [1, 1, 1]
box = { lower = [0, 0, 0], size = [1, 0.5, 1] }
[[block]]
name = "top"
material = "stone"
rigid = false
divisions = [2, 1, 2]
box = { lower = [0.1, 0.5, 0], size = [0.7, 0.5, 1] }
[[stage]]
name = "slide"
gravity = [0, -9.81, 0]
duration = 0.2
[[stage.force]]
block = "top"
point = [0.45, 0.75, 0.5]
force = [4000, 0, 0]
[[stage]]
name = "shake"
duration = 0.02
ground_motion = { direction = [1, 0, 0], time = [0, 0.1], acceleration = [0, 3] }
[output]
energy = true
frames = 0
)"));
}

// Pushes and cycles of a building go on from the force of the jack before them.
TEST(Checkpoint, PushesOfABuildingGoOnBitForBit) {
  Scene scene = scene_of(QUOIN_HOST_TESTS "/small_building.toml",
                         {"stage.push.displacement=0.001", "stage.weight.equilibrium_ratio=0.1"});
  scene.stages.push_back(scene.stages.back());
  expect_restores(scene);
}

// A dry arch until it falls: rigid blocks, collapse, contact detection during the run, base slip at uplift.
TEST(Checkpoint, CollapseOfAnArchGoesOnBitForBit) {
  EXPECT_GT(expect_restores(scene_of(
                "arch.toml", {"stage.weight.duration=0.3", "stage.weight.ramp_time=0.2", "stage.push.ramp_time=0.5",
                              "stage.push.collapse.start=0.38", "output.energy=true"})),
            3);
}

// Rigid and deformable blocks with initial velocity, forces, pressures and ground motion, with viscous damping. Loads
// fade between stages, a support is removed, and the time step changes with the contacts.
TEST(Checkpoint, FallingDryWallGoesOnBitForBit) {
  Scene scene = scene_of_text(R"(
[solver]
damping = "viscous"
mass_damping = 1.0
stiffness_damping = 1e-5
[materials.stone]
young_modulus = 1e8
poisson_ratio = 0.2
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 2e10
shear_stiffness = 1e10
friction_angle = 35.0
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-2, -0.5, -1], size = [6, 0.5, 2.2] }
[[dry_wall]]
name = "wall"
material = "stone"
courses = 4
units_per_course = 2
unit = [0.4, 0.2, 0.2]
origin = [0, 0, 0]
[[block]]
name = "soft"
material = "stone"
rigid = false
zone_edge = 0.2
box = { lower = [0.3, 0.8, 0.0], size = [0.2, 0.2, 0.2] }
[[stage]]
name = "weight"
gravity = [0.0, -9.81, 0.0]
ramp_time = 0.01
duration = 0.02
[[stage]]
name = "push"
ramp_time = 0.02
duration = 0.06
[[stage.force]]
block = "soft"
point = [0.4, 1.0, 0.1]
force = [100.0, 0.0, 20.0]
[[stage.pressure]]
block = "wall/3/0"
normal = [-1, 0, 0]
pressure = 3e4
[[stage.velocity]]
block = "wall/0/0"
velocity = [0.0, 0.0, "free"]
[[stage]]
name = "shake"
ramp_time = 0.02
duration = 0.3
solver = { damping = "local", local_damping = 0.1 }
[output]
energy = true
monitor = "wall/3/0"
record_interval = 0.01
)");
  const TimeSeries record{{0.0, 0.05, 0.1, 0.2, 0.3}, {0.0, 12.0, -12.0, 12.0, 0.0}};
  scene.stages.back().ground = GroundMotion{{{{1.0, 0.0, 0.0}, record, RunningIntegral(record)}}, {}, {}, {}};
  EXPECT_GT(expect_restores(scene), 10);
}

TEST(Checkpoint, OfAnotherSceneOrCutShortIsRefusedAndLeavesTheStateAlone) {
  for (const char* name : {"arch.toml", QUOIN_HOST_TESTS "/../cli/small_wall.toml"}) {
    const Scene scene = scene_of(name, {});
    Simulation first(scene, 1), second(scene, 1);
    first.advance(200);
    second.advance(100);
    auto bytes = first.save();
    const std::uint64_t before = second.hash();
    for (const std::size_t size : {bytes.size() - 1, bytes.size() / 2, bytes.size() / 20, std::size_t{10}}) {
      EXPECT_THROW(second.restore({bytes.begin(), bytes.begin() + static_cast<long>(size)}), Error) << size;
      EXPECT_EQ(second.hash(), before);
    }
    bytes.push_back(0);
    EXPECT_THROW(second.restore(bytes), Error);
    second.advance(100);
    EXPECT_EQ(second.hash(), first.hash());  // a refused restore changes nothing
  }
  Simulation arch(scene_of("arch.toml", {}), 1), longer(scene_of("arch.toml", {"arch.1.voussoirs=8"}), 1);
  arch.advance(10);
  EXPECT_THROW(longer.restore(arch.save()), Error);
}

// A counter of a checkpoint that no run can have, as a history row due 2^62 steps ago, must not cause an endless loop.
TEST(Checkpoint, CountersThatNoRunComesToAreRefused) {
  constexpr long kInterval = 987'654'321;  // a rare number, whose bytes locate the interval in the checkpoint
  const Scene scene =
      scene_of(QUOIN_HOST_TESTS "/../cli/small_wall.toml", {"stage.1.record_interval=" + std::to_string(kInterval)});
  Simulation simulation(scene, 1);
  Observer nobody;
  simulation.run_stage(nobody, 5);
  const auto bytes = simulation.save();
  std::vector<std::size_t> found;
  for (std::size_t at = 0; at + sizeof(long) <= bytes.size(); ++at) {
    if (std::memcmp(&bytes[at], &kInterval, sizeof(long)) == 0) found.push_back(at);
  }
  ASSERT_FALSE(found.empty());
  const std::size_t interval = found.back(), next = interval - sizeof(long);  // consecutive in the checkpoint
  for (const auto& [at, value] :
       {std::pair{interval, 0L}, {interval, -1L}, {interval, 1L << 62}, {next, -(1L << 62)}}) {
    auto forged = bytes;
    std::memcpy(&forged[at], &value, sizeof value);
    EXPECT_THROW(simulation.restore(forged), Error) << at << " " << value;
  }
  simulation.restore(bytes);
  simulation.run_stage(nobody, 5);
}

#ifdef __GLIBC__
// Bytes between the members of structs are undefined. The same run wrote another file each time, and a run from its end
// was then "of another state".
TEST(Checkpoint, HasNoUndefinedBytes) {
  const std::string tests = QUOIN_HOST_TESTS "/", scenes = QUOIN_SCENES "/";
  for (const std::string& file :
       {tests + "all_members.toml", tests + "halves_part.toml", tests + "thrown_stone.toml",
        tests + "small_building.toml", tests + "shaken_wall.toml", scenes + "arch.toml", scenes + "mixed.toml"}) {
    std::vector<std::uint8_t> saved[2];
    for (int i = 0; i < 2; ++i) {
      mallopt(M_PERTURB, i == 0 ? 0x11 : 0xee);  // of memory before its first use
      Simulation simulation(read_scene(file), 1);
      simulation.advance(100);
      saved[i] = simulation.save();
    }
    mallopt(M_PERTURB, 0);
    const auto first = std::ranges::mismatch(saved[0], saved[1]).in1;
    EXPECT_EQ(first - saved[0].begin(), std::ssize(saved[0])) << file;
  }
}
#endif

// Bytes other than 0 and 1 are refused, since loading them as a bool is undefined behaviour.
TEST(Checkpoint, FlagsAreTrueOrFalse) {
  for (int byte = 0; byte < 256; ++byte) {
    const std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(byte)};
    BytesInMemory source(bytes);
    ArchiveReader reader{source};
    bool flag = byte == 0;
    if (byte < 2) {
      reader.value(flag);
      EXPECT_EQ(flag, byte == 1);
    } else {
      EXPECT_THROW(reader.value(flag), Error) << byte;
    }
  }
}

}  // namespace
}  // namespace quoin
