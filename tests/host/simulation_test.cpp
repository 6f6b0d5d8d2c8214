#include <gtest/gtest.h>

#include <cmath>

#include "model/world_results.h"
#include "scene/quality.h"
#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

struct Recorder : Observer {
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  void on_frame(const Simulation&, int, int) override { ++frames; }
  void on_stage_begin(const Simulation&, int) override { ++stages; }
  std::vector<HistoryRow> rows;
  int frames = 0, stages = 0;
};

// Returns the paper's test on a smaller wall: pressed to equilibrium, then sheared at constant height.
Scene sheared_wall(double displacement, int courses = 6, double units = 2.5) {
  Scene scene = wall_scene(courses, units);
  Stage press;
  press.name = "press";
  BodyControl bottom;
  bottom.body = "bottom_beam";
  BodyControl top;
  top.body = "top_beam";
  top.kind[1] = DofKind::free;
  top.force[1] = -0.3e6 * bed_area(*scene.wall);
  press.controls = {bottom, top};
  press.ramp_time = 0.002;
  press.equilibrium_ratio = 1e-4;
  press.max_steps = 200000;
  press.monitor = "top_beam";
  press.direction = 1;
  Stage shear = press;
  shear.name = "shear";
  shear.equilibrium_ratio.reset();
  top.kind[1] = DofKind::velocity;
  top.force[1] = 0.0;
  top.velocity[0] = 0.1;
  shear.controls = {bottom, top};
  shear.displacement = displacement;
  shear.direction = 0;
  scene.stages = {press, shear};
  return scene;
}

// Bricks and joints in series: delta = sigma (L/E + sum 1/kn), and the resistance is the force on the beam.
TEST(Simulation, PressedColumnIsASeriesOfSprings) {
  Scene scene = wall_scene(4, 0.5);
  scene.materials["brick"].poisson_ratio = 0.0;
  Scene stages = sheared_wall(1e-4);
  stages.stages.pop_back();
  scene.stages = stages.stages;
  const double force = 0.3e6 * bed_area(*scene.wall);
  scene.stages[0].controls[1].force[1] = -force;
  scene.stages[0].equilibrium_ratio = 1e-7;
  Simulation simulation(scene, assemble(scene), 1);
  Recorder recorder;
  simulation.run(recorder);
  const HistoryRow& last = recorder.rows.back();
  EXPECT_NEAR(last.vertical_force, force, 1e-5 * force);
  EXPECT_NEAR(last.resistance, -force, 1e-5 * force);  // the joints push the beam up
  EXPECT_NEAR(last.displacement, -0.3e6 * (0.25 / kYoung + 5 / kNormal), 1e-5 * 0.3e6 * (0.25 / kYoung + 5 / kNormal));
  EXPECT_LE(last.unbalanced_ratio, 1e-7);
  for (const auto& stress : block_stress(simulation, 1)) EXPECT_NEAR(stress[1], -0.3e6, 10.0);
  const auto counts = condition_counts(simulation);
  EXPECT_EQ(counts[static_cast<std::size_t>(Condition::elastic)], simulation.model().point_count);
}

// A wall with four times the stiffness, mass and load has the same motion. Forces are four times as large; their ratio
// is equal.
TEST(Simulation, UnbalancedRatioHasNoUnit) {
  for (const Kernels kernels : {Kernels::lattice, Kernels::general}) {
    const auto rows_of = [&](double times) {
      Scene scene = wall_scene(4, 0.5);
      scene.solver.kernels = kernels;
      scene.materials["brick"].young_modulus *= times;
      scene.materials["brick"].density *= times;
      scene.wall->beam_density *= times;
      for (const auto& [name, stiffness] : {std::pair{"mortar", kNormal}, {"unit", 1000e9}}) {
        scene.joints[name] = elastic_family(stiffness * times, stiffness * times);
        scene.joints[name].name = name;
      }
      Stage press = sheared_wall(1e-4).stages[0];
      press.equilibrium_ratio.reset();
      press.duration = 1e-3;
      press.record_interval = 5;
      press.controls[1].force[1] = -0.3e6 * times * bed_area(*scene.wall);
      scene.stages = {press};
      Simulation simulation(scene, 1);
      Recorder recorder;
      simulation.run(recorder);
      return recorder.rows;
    };
    const auto once = rows_of(1.0), more = rows_of(4.0);
    ASSERT_EQ(once.size(), more.size());
    ASSERT_GT(once.size(), 3u);
    int loaded = 0;
    for (std::size_t i = 0; i < once.size(); ++i) {
      EXPECT_NEAR(more[i].vertical_force, 4 * once[i].vertical_force, 1e-9 * std::abs(more[i].vertical_force));
      EXPECT_NEAR(more[i].displacement, once[i].displacement, 1e-9 * std::abs(once[i].displacement));
      if (!std::isfinite(once[i].unbalanced_ratio) || once[i].unbalanced_ratio == 0.0) continue;
      EXPECT_NEAR(more[i].unbalanced_ratio, once[i].unbalanced_ratio, 1e-9 * once[i].unbalanced_ratio) << i;
      ++loaded;
    }
    EXPECT_GT(loaded, 3);
  }
}

// Recording of energies, unbalanced force, kinetic energy and flags at every step does not change the motion.
TEST(Simulation, RecordingChangesNoBit) {
  std::vector<LaneVector<double>> displacement;
  for (const auto& [energy, every_step] : {std::pair{false, false}, std::pair{true, false}, std::pair{false, true}}) {
    Scene scene = sheared_wall(0.1e-3, 3, 2);
    scene.solver = quality_named("standard").solver;
    scene.output.energy = energy;
    scene.stages.erase(scene.stages.begin());
    Simulation simulation(scene, assemble(scene), 1);
    if (every_step) {
      for (int i = 0; i < 1000; ++i) simulation.advance(1, true);
    } else {
      simulation.advance(1000, false);
    }
    EXPECT_GT(condition_counts(simulation)[static_cast<std::size_t>(Condition::softening)], 0);
    displacement.push_back(lattice_displacement(simulation));
  }
  EXPECT_EQ(displacement[1], displacement[0]);
  EXPECT_EQ(displacement[2], displacement[0]);
}

// Two stages: a body that comes to rest at the end of a ramp, and one that moves again after rest.
TEST(Simulation, SkippingBodiesAtRestChangesNoBit) {
  std::vector<std::uint64_t> hashes;
  std::vector<double> last;
  for (const bool skip : {true, false}) {
    Scene scene = sheared_wall(0.2e-3, 5, 2);
    scene.solver.skip_resting_bodies = skip;
    Stage back = scene.stages.back(), hold = back;
    hold.name = "hold";
    for (BodyControl& control : hold.controls) control.velocity = {0.0, 0.0, 0.0};
    hold.displacement.reset();
    hold.duration = 3e-3;
    hold.ramp_time = 1e-3;
    back.name = "back";
    back.displacement.reset();
    back.duration = 3e-3;
    scene.stages.push_back(hold);
    scene.stages.push_back(back);
    Simulation simulation(scene, assemble(scene), 2);
    Recorder recorder;
    simulation.run(recorder);
    hashes.push_back(simulation.hash());
    last.push_back(recorder.rows.back().resistance);
    EXPECT_GT(recorder.rows.back().displacement, 0.0);
  }
  EXPECT_EQ(hashes[1], hashes[0]);
  EXPECT_EQ(last[1], last[0]);
}

TEST(Simulation, ThreadsDoNotChangeABit) {
  std::uint64_t expected = 0;
  for (int threads : {1, 2, 3, 4}) {
    const Scene scene = sheared_wall(0.2e-3, 5, 2);
    Simulation simulation(scene, assemble(scene), threads);
    Recorder recorder;
    simulation.run(recorder);
    if (threads == 1) {
      expected = simulation.hash();
      EXPECT_EQ(recorder.stages, 2);
      EXPECT_GT(recorder.rows.size(), 500u);
      EXPECT_NEAR(recorder.rows.back().displacement, 0.2e-3, 1e-6);
      EXPECT_GT(recorder.rows.back().resistance, 1e3);
      const auto counts = condition_counts(simulation);
      EXPECT_LT(counts[static_cast<std::size_t>(Condition::elastic)],
                simulation.model().point_count);  // something has cracked
    }
    EXPECT_EQ(simulation.hash(), expected) << threads;
  }
}

TEST(Simulation, MeasuringDoesNotChangeABit) {
  Scene scene = sheared_wall(0.2e-3, 4, 2);
  std::uint64_t expected = 0;
  for (long interval : {7L, 1000L}) {
    for (bool energy : {false, true}) {
      scene.stages[0].record_interval = scene.stages[1].record_interval = interval;
      scene.output.energy = energy;
      Simulation simulation(scene, assemble(scene), 1);
      simulation.advance(8000);
      std::vector<double> all;
      std::uint64_t hash = 0xcbf29ce484222325u;
      for (double u : lattice_displacement(simulation))
        hash = (hash ^ std::bit_cast<std::uint64_t>(u)) * 0x100000001b3u;
      for (double v : lattice_velocity(simulation)) hash = (hash ^ std::bit_cast<std::uint64_t>(v)) * 0x100000001b3u;
      if (expected == 0) expected = hash;
      EXPECT_EQ(hash, expected);
    }
  }
}

// A run may stop before a row, at a row or at a frame. The resumed run continues history and frames without a
// difference.
TEST(Simulation, StoppedRunsAreKeptWhereverTheyStop) {
  struct Stopper : Recorder {
    void on_row(const HistoryRow& row) override {
      Recorder::on_row(row);
      if (row.step >= stop_after && row.stage == 1) simulation->request_stop();
    }
    bool wants_pause(bool last) override { return last; }
    void on_pause(const Simulation& s, bool last) override {
      EXPECT_TRUE(last);
      kept.push_back(s.save());
      rows_kept = rows, frames_kept = frames;
    }
    Simulation* simulation = nullptr;
    long stop_after = 0;
    std::vector<std::vector<std::uint8_t>> kept;
    std::vector<HistoryRow> rows_kept;
    int frames_kept = 0;
  };
  int due = 0, at_frames = 0;
  for (const long interval : {1L, 7L}) {
    Scene scene = sheared_wall(0.02e-3, 3, 2);
    scene.stages[1].record_interval = interval;
    scene.output.frames = 60;
    Simulation whole(scene, assemble(scene), 1);
    Recorder all;
    whole.run(all);
    const long first_step = all.rows.back().step - 60;
    for (long stop_after = first_step; stop_after < first_step + 12; ++stop_after) {
      Simulation first(scene, assemble(scene), 1);
      Stopper stopper;
      stopper.simulation = &first;
      stopper.stop_after = stop_after;
      EXPECT_THROW(first.run(stopper), Error);
      ASSERT_EQ(stopper.kept.size(), 1u) << "step " << first.step() << ", a row every " << interval;
      due += stopper.rows_kept.size() == stopper.rows.size() ? 1 : 0;
      at_frames += stopper.frames_kept > 0 ? 1 : 0;
      Simulation second(scene, assemble(scene), 1);
      second.restore(stopper.kept[0]);
      Recorder rest;
      second.run(rest);
      EXPECT_EQ(second.hash(), whole.hash());
      EXPECT_EQ(stopper.frames_kept + rest.frames, all.frames);
      std::vector<HistoryRow> rows = stopper.rows_kept;
      rows.insert(rows.end(), rest.rows.begin(), rest.rows.end());
      ASSERT_EQ(rows.size(), all.rows.size());
      for (std::size_t i = 0; i < rows.size(); ++i) {
        EXPECT_EQ(rows[i].step, all.rows[i].step);
        EXPECT_EQ(rows[i].resistance, all.rows[i].resistance);
      }
    }
  }
  EXPECT_GE(due, 12) << "with a row every step";
  EXPECT_GE(at_frames, 12);
}

TEST(Simulation, RestoredRunsGoOnBitForBit) {
  const Scene scene = sheared_wall(0.3e-3, 4, 2);
  struct Stopper : Recorder {
    Simulation* simulation = nullptr;
    std::size_t stop_at = 0;
    void on_row(const HistoryRow& row) override {
      Recorder::on_row(row);
      if (rows.size() == stop_at) simulation->request_stop();
    }
  };
  Simulation whole(scene, assemble(scene), 1);
  Recorder all;
  whole.run(all);

  Simulation first(scene, assemble(scene), 1);
  Stopper stopper;
  stopper.simulation = &first;
  stopper.stop_at = all.rows.size() / 2;
  try {
    first.run(stopper);
    FAIL() << "not interrupted";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::interrupted);
  }
  Simulation second(scene, assemble(scene), 2);
  second.restore(first.save());
  EXPECT_EQ(second.hash(), first.hash());
  Recorder rest;
  second.run(rest);
  EXPECT_EQ(second.hash(), whole.hash());
  EXPECT_EQ(second.step(), whole.step());

  auto bytes = first.save();
  bytes.resize(bytes.size() / 2);
  const std::uint64_t before = second.hash();
  EXPECT_THROW(second.restore(bytes), Error);
  EXPECT_EQ(second.hash(), before);
  const Scene other = sheared_wall(0.3e-3, 3, 2);
  Simulation unlike(other, assemble(other), 1);
  EXPECT_THROW(unlike.restore(first.save()), Error);
}

TEST(Simulation, EnergyBalanceOfACrackingWallCloses) {
  Scene scene = sheared_wall(0.5e-3, 4, 2);
  scene.output.energy = true;
  Simulation simulation(scene, assemble(scene), 1);
  Recorder recorder;
  simulation.run(recorder);
  const Energies e = *recorder.rows.back().energies;
  EXPECT_GT(e.dissipated[0] + e.dissipated[1] + e.dissipated[2], 0.0);
  EXPECT_LT(std::abs(e.balance_error()), 2e-3 * e.external);
  RecordProperty("error", std::to_string(e.balance_error() / e.external));
}

TEST(Simulation, HalfOfTheThicknessGivesTheWholeForce) {
  double force[2];
  for (bool half : {false, true}) {
    Scene scene = sheared_wall(0.1e-3, 4, 2);
    scene.wall->half_thickness = half;
    if (half) scene.stages[0].controls[1].force[1] *= 0.5;
    Simulation simulation(scene, assemble(scene), 1);
    Recorder recorder;
    simulation.run(recorder);
    force[half ? 1 : 0] = recorder.rows.back().resistance;
  }
  // The two halves of a brick are mirror images except for the diagonals of their hexahedra.
  EXPECT_NEAR(force[1], force[0], 0.01 * std::abs(force[0]));
}

TEST(Simulation, ReportsMissingEquilibriumAndUnknownBodies) {
  Scene scene = sheared_wall(1e-4, 2, 1);
  scene.stages[0].max_steps = 50;
  Simulation hasty(scene, assemble(scene), 1);
  Recorder recorder;
  try {
    hasty.run(recorder);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::numerical);
    EXPECT_NE(std::string(error.what()).find("unbalanced force ratio"), std::string::npos) << error.what();
  }
  scene.stages[0].controls[0].body = "botom_beam";
  Simulation misspelt(scene, assemble(scene), 1);
  EXPECT_THROW(misspelt.run(recorder), Error);
}

TEST(Simulation, NotANumberStopsWithPlaceAndValues) {
  Scene scene = sheared_wall(1e-4, 2, 1);
  Simulation simulation(scene, assemble(scene), 1);
  simulation.advance(10);
  lattice_displacement(simulation)[dof(simulation.model(), 0, 14, 1)] = NAN;
  try {
    simulation.advance(5);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::numerical);
    EXPECT_NE(std::string(error.what()).find("joint"), std::string::npos) << error.what();
  }
}

// At constant speed the remaining time is that of the remaining steps. The run stops at the third report.
TEST(Simulation, ProgressTellsTheTimeThatIsLeft) {
  struct Watcher : Observer {
    Simulation* simulation = nullptr;
    std::vector<Progress> reports;
    void on_progress(const Progress& progress) override {
      reports.push_back(progress);
      if (reports.size() == 3) simulation->request_stop();
    }
  } watcher;
  Scene scene = sheared_wall(1e-4, 2, 1);
  scene.stages.erase(scene.stages.begin());
  scene.stages[0].displacement.reset();
  scene.stages[0].controls[1].velocity[0] = 1e-6;
  scene.stages[0].duration = 10.0;
  Simulation simulation(scene, assemble(scene), 1);
  watcher.simulation = &simulation;
  EXPECT_THROW(simulation.run(watcher), Error);
  ASSERT_EQ(watcher.reports.size(), 3u);
  const double steps = 10.0 / simulation.time_step_report().time_step;
  for (const Progress& p : watcher.reports) {
    const double done = static_cast<double>(p.step) / steps;
    EXPECT_NEAR(p.fraction, done, 1e-9);
    EXPECT_NEAR(p.seconds_left * p.steps_per_second, steps - static_cast<double>(p.step), 1e-6 * steps);
  }
}

// Returns a stone of 1 x 0.5 x 1 m beside the ground, with the general kernels. more: the rest of the block and a
// stage.
Scene stone_scene(const std::string& more) {
  return read_scene_text(
      "[solver]\nkernels = \"general\"\ndamping = \"none\"\n"
      "[materials.stone]\nyoung_modulus = 1e10\npoisson_ratio = 0.2\ndensity = 2000\n"
      "[joints.glue]\nlaw = \"elastic\"\nnormal_stiffness = 1e9\nshear_stiffness = 1e9\n"
      "[[block]]\nname = \"ground\"\nmaterial = \"stone\"\nfixed = true\n"
      "box = { lower = [0, -1, 0], size = [1, 1, 1] }\n"
      "[[block]]\nname = \"stone\"\nmaterial = \"stone\"\nbox = { lower = [0, 0, 0], size = [1, 0.5, 1] }\n" +
          more,
      "stone.toml", {});
}

// A falling stone of 1000 kg, at rest half a step before the start: m v^2/2 with v = g t of half a step before.
TEST(Simulation, KineticEnergyOfAFallingStoneIsThatOfItsVelocity) {
  Simulation simulation(stone_scene("position = [0, 5, 0]\n[[stage]]\ngravity = [0, -9.81, 0]\nduration = 1\n"));
  ASSERT_TRUE(simulation.large_motion());
  simulation.advance(50);
  const double mass = 2000 * 0.5, speed = std::abs(block_velocity(simulation, 1)[0][1]);
  EXPECT_NEAR(speed, 9.81 * simulation.time(), 1e-9 * speed);
  EXPECT_NEAR(kinetic_energy_of_all(*simulation.large_motion()), mass * speed * speed / 2, 1e-9 * mass * speed * speed);
}

// A collapse stage that does not collapse ends at the limit: frames divide the range from the start to the limit.
TEST(Simulation, FramesOfACollapseDivideTheWayToItsLimit) {
  struct Frames : Observer {
    std::vector<double> multiplier;
    void on_frame(const Simulation& simulation, int, int) override {
      multiplier.push_back(simulation.measure().multiplier);
    }
  } frames;
  Simulation simulation(
      stone_scene("[output]\nframes = 4\n[[stage]]\ngravity = [0, -9.81, 0]\nramp_time = 0.01\n"
                  "collapse = { direction = [1, 0, 0], start = 0.2, rate = 10, limit = 0.6 }\n"));
  simulation.run(frames);
  EXPECT_FALSE(simulation.outcome().collapse_multiplier.has_value());
  ASSERT_EQ(frames.multiplier.size(), 5u) << "and one of the start";
  // The frame has the state one step after its multiplier is passed.
  const double late = 2 * 10 * simulation.time_step_report().time_step;
  for (std::size_t i = 1; i < 4; ++i) EXPECT_NEAR(frames.multiplier[i], 0.2 + 0.1 * static_cast<double>(i), late) << i;
}

TEST(Simulation, StableStepsOnlyAreNotPromisedAboveOne) {
  Scene scene = sheared_wall(1e-4, 2, 1);
  scene.solver.time_step_fraction = 1.1;
  Simulation simulation(scene, assemble(scene), 1);
  Recorder recorder;
  EXPECT_THROW(simulation.run(recorder), Error);
}

}  // namespace
}  // namespace quoin
