// A model on several ranks is bitwise identical to one process, for all kinds of blocks and events. Ranks are threads
// here; in tests/mpi they are processes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdlib>

#include "base/error.h"
#include "scene/read_scene.h"
#include "step/collect.h"
#include "step/large_motion.h"
#include "step/rank_sums.h"
#include "step/results.h"
#include "step/simulation.h"
#include "support.h"
#include "thread_ranks.h"

namespace quoin {
namespace {

using Overrides = std::vector<std::string>;

struct Case {
  const char* name;
  std::string scene;
  Overrides overrides;
  enum { nothing, promotion, detection, parting, added_mass } has = nothing;
};

// Its frames follow damage, which all ranks find together.
Scene scene_of(const Case& of) {
  Scene scene = read_scene(of.scene, of.overrides);
  scene.output.frames_at_damage = 1e-4;
  return scene;
}

// Results that are compared bit by bit.
struct Found {
  std::vector<std::uint64_t> rows;
  std::vector<double> blocks, points;
  std::uint64_t start_hash = 0, hash = 0;
  long steps = 0;
  double time_step = 0.0, added_mass = 0.0;
};

struct Rows : Observer {
  std::vector<std::uint64_t> bits;
  const Simulation* simulation = nullptr;
  int units = 0;        // number of units whose halves are connected
  bool parted = false;  // the halves of a unit have separated
  void on_law_swap(const LawSwap& swap) override {
    for (const double x : {double(swap.points), double(swap.limited), swap.stored_before, swap.energy_jump})
      bits.push_back(std::bit_cast<std::uint64_t>(x));
  }
  void on_row(const HistoryRow& row) override {
    if (const blocks::Model* m = simulation ? simulation->large_motion() : nullptr)
      parted |= std::exchange(units, m->units.count) > m->units.count;
    for (const double x :
         {row.time, row.displacement, row.resistance, row.vertical_force, row.dynamic_force, row.unbalanced_ratio,
          row.kinetic_energy, row.multiplier, row.largest_displacement, row.monitor_displacement[0], row.joint_force[0],
          row.joint_force[1], row.ground_displacement[0], row.ground_displacement[2], row.monitor_relative[0]})
      bits.push_back(std::bit_cast<std::uint64_t>(x));
    for (const Vec3& all : {row.base_force, row.overturning_moment, row.reaction_sum.force, row.reaction_sum.moment})
      for (const double x : all) bits.push_back(std::bit_cast<std::uint64_t>(x));
    for (const double x : row.added) bits.push_back(std::bit_cast<std::uint64_t>(x));
    if (!row.energies) return;
    const Energies& e = *row.energies;
    for (const double x : {e.kinetic, e.strain, e.contact_stored, e.dissipated[0], e.dissipated[1], e.dissipated[2],
                           e.dissipated[3], e.external, e.damping, e.detection, e.members_stored, e.members_dissipated})
      bits.push_back(std::bit_cast<std::uint64_t>(x));
  }
};

Found found_in(const Simulation& simulation, const Rows& rows, std::uint64_t start_hash) {
  Found found{rows.bits,
              {},
              {},
              start_hash,
              simulation.hash(),
              simulation.step(),
              simulation.time_step_report().time_step,
              simulation.time_step_report().added_mass};
  for (int b = 0; b < simulation.block_count(); ++b) {
    for (const Vec3& u : block_displacement(simulation, b)) found.blocks.insert(found.blocks.end(), u.begin(), u.end());
    for (const Vec3& v : block_velocity(simulation, b)) found.blocks.insert(found.blocks.end(), v.begin(), v.end());
  }
  for (const ContactPoint& p : contact_points(simulation)) {
    found.points.insert(found.points.end(), p.traction.begin(), p.traction.end());
    found.points.insert(found.points.end(), p.jump.begin(), p.jump.end());
    found.points.push_back(p.flags);
  }
  return found;
}

Found alone(const Case& of) {
  Simulation simulation(scene_of(of));
  Rows rows;
  rows.simulation = &simulation;
  const std::uint64_t start = simulation.hash();
  simulation.run(rows);
  EXPECT_EQ(simulation.outcome().promotion.has_value(), of.has == Case::promotion);
  if (of.has == Case::detection) {
    EXPECT_GT(simulation.large_motion()->detection.count, 2);
  }
  EXPECT_EQ(rows.parted, of.has == Case::parting);
  EXPECT_EQ(simulation.time_step_report().added_mass > 1e-3 * simulation.time_step_report().model_mass,
            of.has == Case::added_mass);
  return found_in(simulation, rows, start);
}

class ManyRanks : public ::testing::TestWithParam<Case> {};

TEST_P(ManyRanks, HaveTheBitsOfOneProcess) {
  const Case& of = GetParam();
  const Found one = alone(of);
  ASSERT_GT(one.rows.size(), 30u);
  ASSERT_GT(one.points.size(), 30u);
  for (const int count : {1, 2, 3, 4}) {
    Found first;
    std::atomic<int> have_blocks = 0;
    const long messages = on_ranks(count, [&](Ranks& ranks) {
      Simulation simulation(scene_of(of), 1, &ranks);
      bool owns = false;
      for (int b = 0; b < simulation.block_count(); ++b) owns |= owns_block(simulation, b);
      have_blocks += owns ? 1 : 0;
      Rows rows;
      const std::uint64_t start = simulation.hash();  // that of rank 0 identifies a checkpoint
      simulation.run(rows);
      gather_at_first(simulation);
      if (ranks.rank() == 0) first = found_in(simulation, rows, start);
    });
    EXPECT_GE(have_blocks, std::min(count, 2)) << "small models leave some without";
    if (count > 1) {
      EXPECT_GE(messages, one.steps) << "nothing went to and fro";
    }
    EXPECT_EQ(first.rows, one.rows) << count;
    EXPECT_EQ(first.blocks, one.blocks) << count;
    EXPECT_EQ(first.points, one.points) << count;
    EXPECT_EQ(first.start_hash, one.start_hash) << count;
    EXPECT_EQ(first.hash, one.hash) << count;
    EXPECT_EQ(first.steps, one.steps) << count;
    EXPECT_EQ(first.time_step, one.time_step) << count;
    EXPECT_EQ(first.added_mass, one.added_mass) << count;
  }
}

const std::string kTests = QUOIN_HOST_TESTS "/../", kScenes = QUOIN_SCENES "/";
INSTANTIATE_TEST_SUITE_P(
    Scenes, ManyRanks,
    ::testing::Values(
        Case{"Wall",
             kTests + "cli/small_wall.toml",
             {"output.energy=true", "stage.precompression.duration=0.004", "stage.shear.displacement=0.00003"}},
        Case{"Building",
             kTests + "host/small_building.toml",
             {"stage.push.displacement=0.00005", "stage.push.record_interval=100"}},
        Case{"LeavesFixedFrames", kTests + "host/tilting_boxes.toml", {}},
        Case{"RigidUnits", kScenes + "cube_wall_10.toml", {"stage.1.displacement=0.00005"}},
        // A body of its own beside those in lanes.
        Case{"RigidUnitsUnderABeam",
             kScenes + "cube_wall_10.toml",
             {"wall.top_beam=true", "wall.beam_joint=mortar", "stage.1.displacement=0.00001"}},
        Case{
            "LawSwaps",
            kTests + "cli/small_wall.toml",
            {"wall.courses=10", "wall.units_per_course=10", "stage.precompression.duration=0.002",
             "stage.shear.displacement=0.00002", "stage.shear.law=coulomb_slip", "joints.mortar.tensile_strength=3e4"}},
        Case{"Damage",
             kScenes + "damaged_wall_030.toml",
             {"wall.courses=8", "wall.zones=[2, 1, 1]", "damage.1.crack=[[0.11, 0.4], [0.88, 0.07]]",
              "damage.1.opening=1e-6", "stage.precompression.duration=0.002", "stage.settlement.displacement=0.00001",
              "stage.settlement.ramp_time=0.001", "stage.shear.displacement=0.00001"}},
        Case{"SelectiveWall",
             kTests + "cli/small_wall.toml",
             {"wall.courses=8", "wall.units_per_course=8", "wall.half_thickness=true", "wall.zones=[2, 1, 2]",
              "solver.selective_time_step=4e-5", "stage.precompression.duration=0.004",
              "stage.shear.displacement=0.00005"},
             Case::added_mass},
        Case{"SelectiveBuilding",
             kTests + "host/small_building.toml",
             {"stage.push.displacement=0.00005", "stage.push.record_interval=100", "solver.selective_time_step=4e-5"},
             Case::added_mass},
        Case{"SelectiveRigidUnits",
             kScenes + "cube_wall_10.toml",
             {"stage.1.displacement=0.00005", "solver.selective_time_step=2e-4"},
             Case::added_mass},
        Case{"Nodal",
             kTests + "cli/small_wall.toml",
             {"wall.courses=8", "wall.units_per_course=8", "solver.critical_time_step='nodal'",
              "solver.damping='local'", "solver.time_step_fraction=0.3", "stage.precompression.duration=0.003",
              "stage.shear.displacement=0.00002"}},
        Case{"Scatter",
             kTests + "cli/small_wall.toml",
             {"wall.courses=8", "wall.units_per_course=9", "stage.precompression.duration=0.002",
              "stage.shear.displacement=0.00002",
              "joints.mortar.normal_stiffness={distribution='lognormal', mean=82e9, cov=0.3}",
              "joints.mortar.shear_stiffness={distribution='uniform', lower=30e9, upper=40e9, level='course'}",
              "joints.mortar.fracture_energy_tension={distribution='lognormal', mean=15, cov=0.2, level='wall'}"}},
        Case{"CorrelatedScatter",
             kTests + "cli/small_wall.toml",
             {"wall.courses=8", "wall.units_per_course=9", "stage.precompression.duration=0.002",
              "stage.shear.displacement=0.00002",
              "joints.mortar.tensile_strength={distribution='lognormal', mean=3e4, cov=0.3, level='point', "
              "correlation_length=0.3, scatter_of='joint'}",
              "joints.mortar.cohesion={distribution='lognormal', mean=2e5, cov=0.3, level='unit', "
              "correlation_length=0.5}",
              "joints.mortar.normal_stiffness={distribution='lognormal', mean=82e9, cov=0.3, level='joint', "
              "correlation_length=0.2}"}},
        Case{"Promotion",
             kTests + "cli/small_wall.toml",
             {"solver.rotation_bound=1e-5", "stage.shear.displacement=0.00005"},
             Case::promotion},
        Case{"ShakenWall",
             QUOIN_HOST_TESTS "/shaken_wall.toml",
             {"output.energy=true", "stage.shake.ground_motion.scale=1.5", "stage.shake.duration=0.006"}},
        Case{"ShakenWallThatGoesOver",
             QUOIN_HOST_TESTS "/shaken_wall.toml",
             {"solver.rotation_bound=1e-6", "stage.shake.duration=0.006"},
             Case::promotion},
        Case{"Arch",
             kScenes + "arch.toml",
             {"arch.arch.voussoirs=15", "stage.push.collapse.rate=0.5", "stage.weight.duration=0.1",
              "stage.weight.ramp_time=0.05", "stage.push.ramp_time=0.1"},
             Case::detection},
        Case{"Shaken",
             kScenes + "facade.toml",
             {"output.energy=true", "stage.weight.duration=0.01", "stage.earthquake.duration=0.05",
              "stage.earthquake.ground_motion={direction=[1, 0, 0], pulse={shape='sine', amplitude=40, period=0.05}}"}},
        Case{"Deformable",
             kScenes + "mixed.toml",
             {"wall.rigid_units=false", "wall.zones=[2, 2, 1]", "stage.weight.duration=0.004",
              "stage.push.duration=0.004"}},
        Case{"FreedEnergies",
             kScenes + "mixed.toml",
             {"output.energy=true", "stage.weight.duration=0.05", "stage.push.duration=0.1"},
             Case::detection},
        Case{"PulledJoints", QUOIN_HOST_TESTS "/pulled_stack.toml", {}, Case::detection},
        Case{"Members", QUOIN_HOST_TESTS "/all_members.toml", {}},
        Case{"MembersAndScatter",
             QUOIN_HOST_TESTS "/all_members.toml",
             {"stage.shake.duration=0.015",
              "joints.mortar.tensile_strength={distribution='lognormal', mean=2e4, cov=0.3, level='point'}"}},
        Case{"TiedFacade",
             kScenes + "tied_facade.toml",
             {"output.energy=true", "tie.left.pretension=500", "stage.weight.duration=0.2", "stage.push.ramp_time=0.2",
              "stage.push.collapse.start=0.3"},
             Case::detection},
        Case{"HalvesThatPart",
             kTests + "host/halves_part.toml",
             {"solver.large_motion=always", "output.energy=true"},
             Case::parting},
        Case{"LeavingFrames",
             kTests + "host/small_building.toml",
             {"solver.sliding_bound=0.01", "stage.push.displacement=0.006", "stage.push.record_interval=10",
              "output.energy=true"},
             Case::promotion}),
    [](const auto& of) { return std::string(of.param.name); });

// Load balancing in mid-run moves blocks between ranks, with all arrays of their contact points: initial openings,
// random properties, added inertia.
TEST(Ranks, DividedAnewKeepWhatPointsHave) {
  const Case of{
      "DividedAnew",
      kScenes + "damaged_wall_030.toml",
      {"wall.courses=32", "wall.zones=[1, 1, 1]", "damage.1.crack=[[0.11, 1.9], [0.88, 0.07]]", "damage.1.opening=1e-6",
       "stage.precompression.duration=0.006", "stage.settlement.displacement=0.00001",
       "stage.settlement.ramp_time=0.001", "stage.shear.displacement=0.00001", "solver.selective_time_step=1.5e-5",
       "joints.unit.normal_stiffness={distribution='lognormal', mean=1000e9, cov=0.3}"},
      Case::added_mass};
  const Found one = alone(of);
  setenv("QUOIN_DEAR_BLOCKS", "60x100", 1);  // step/state/rank_load.h
  std::atomic<int> changed_hands = 0;
  Found first;
  on_ranks(3, [&](Ranks& ranks) {
    Simulation simulation(scene_of(of), 1, &ranks);
    const auto owned = [&] {
      std::vector<bool> blocks;
      for (int b = 0; b < simulation.block_count(); ++b) blocks.push_back(owns_block(simulation, b));
      return blocks;
    };
    const std::vector<bool> before = owned();
    const std::uint64_t start = simulation.hash();
    Rows rows;
    simulation.run(rows);
    changed_hands += owned() != before ? 1 : 0;
    gather_at_first(simulation);
    if (ranks.rank() == 0) first = found_in(simulation, rows, start);
  });
  unsetenv("QUOIN_DEAR_BLOCKS");
  EXPECT_GT(changed_hands, 0);
  EXPECT_EQ(first.rows, one.rows);
  EXPECT_EQ(first.blocks, one.blocks);
  EXPECT_EQ(first.points, one.points);
  EXPECT_EQ(first.hash, one.hash);
}

TEST(Ranks, WithDifferentModelsAreRefused) {
  const std::string scene = kTests + "cli/small_wall.toml";
  const auto refused = [&](const std::string& scene_of_other, const Overrides& of_other) {
    try {
      on_ranks(2, [&](Ranks& ranks) {
        Simulation simulation(ranks.rank() == 0 ? read_scene(scene, {}) : read_scene(scene_of_other, of_other), 1,
                              &ranks);
      });
      return std::string("taken");
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      return std::string(error.what());
    }
  };
  EXPECT_EQ(refused(scene, {}), "taken");
  EXPECT_NE(refused(scene, {"solver.time_step_fraction=0.31"}).find("different models"), std::string::npos);
  EXPECT_NE(refused(scene, {"wall.courses=5"}).find("different models"), std::string::npos);

  // An additional stone without contacts changes neither the number of contact points nor the time step.
  const auto stones = [](int free) {
    std::string text = undamped_stone("general") + "[[stage]]\nduration = 0.1\n";
    for (int i = 0; i < 2 + free; ++i)
      text += fmt::format("[[block]]\nmaterial = \"stone\"\nbox = {{ lower = [{}, 0, 0], size = [0.1, 0.1, 0.1] }}\n",
                          i < 2 ? 0.1 * i : 3.0);
    return read_scene_text(text, "stones.toml", {"contact.cubic_points=false"});  // sums of few terms
  };
  EXPECT_DOUBLE_EQ(Simulation(stones(1)).time_step_report().time_step,
                   Simulation(stones(0)).time_step_report().time_step);
  EXPECT_THROW(on_ranks(2, [&](Ranks& ranks) { Simulation(stones(ranks.rank()), 1, &ranks); }), Error);
}

// Ranks find no state of rest. That is said before the first stage of the run, not hours later.
TEST(Ranks, RefuseALaterStageOfRestAtTheStart) {
  const std::string scene = undamped_stone("general") +
                            "[[block]]\nmaterial = \"stone\"\nbox = { lower = [0, 0, 0], size = [0.1, 0.1, 0.1] }\n"
                            "[[stage]]\nduration = 0.001\n[[stage]]\nkind = \"rest\"\n";
  std::atomic<long> steps = 0;
  try {
    on_ranks(2, [&](Ranks& ranks) {
      Simulation simulation(read_scene_text(scene, "stones.toml"), 1, &ranks);
      Observer nothing;
      try {
        simulation.run(nothing);
      } catch (...) {
        steps += simulation.step();
        throw;
      }
    });
    ADD_FAILURE() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::bad_input);
    EXPECT_NE(std::string(error.what()).find("stones.toml:"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("start quoin without mpirun"), std::string::npos) << error.what();
  }
  EXPECT_EQ(steps, 0);
}

// The state of rest is found at the start of its stage. Ranks may take the steps that follow.
TEST(Ranks, GoOnInsideAStageOfRest) {
  const std::string scene =
      undamped_stone("general") +
      "[[block]]\nmaterial = \"stone\"\nbox = { lower = [0, 0, 0], size = [0.1, 0.1, 0.1] }\n"
      "fixed = true\n[[stage]]\nkind = \"rest\"\nmax_steps = 100000\n[[stage]]\nduration = 1e-4\n";
  struct Stopper : Observer {
    Simulation* simulation = nullptr;
    std::vector<std::uint8_t> saved;
    void on_pause(const Simulation& of, bool) override {
      if (saved.empty()) saved = of.save(), simulation->request_stop();
    }
  } stopper;
  Simulation first(read_scene_text(scene, "stones.toml"), 1);
  stopper.simulation = &first;
  try {
    first.run(stopper);
  } catch (const Error&) {
  }
  if (stopper.saved.empty()) GTEST_SKIP() << "this program finds no states of rest";
  std::atomic<int> ended = 0;
  on_ranks(2, [&](Ranks& ranks) {
    Simulation simulation(read_scene_text(scene, "stones.toml"), 1, &ranks);
    simulation.restore(stopper.saved);
    Observer nothing;
    simulation.run(nothing);
    ended += simulation.stages_ended() == 2 ? 1 : 0;
  });
  EXPECT_EQ(ended, 2);
}

// 40 x 40 units: each of four ranks has a quarter of the blocks and the blocks close to it.
TEST(Ranks, HoldTheirPartsOfLargeMotion) {
  const Overrides settings = {"solver.large_motion=always", "wall.courses=40", "wall.units_per_course=40"};
  on_ranks(4, [&](Ranks& ranks) {
    Simulation simulation(read_scene(kTests + "cli/small_wall.toml", settings), 1, &ranks);
    simulation.advance(3);
    int own = 0, laid_out = 0;
    for (int b = 0; b < simulation.block_count(); ++b) {
      own += owns_block(simulation, b) ? 1 : 0;
      laid_out += simulation.large_motion()->part.laid_out[static_cast<std::size_t>(b)] ? 1 : 0;
    }
    EXPECT_GT(own, simulation.block_count() / 8);
    EXPECT_GT(laid_out, own) << "neighbours";
    EXPECT_LT(laid_out, simulation.block_count() / 2);
  });
}

// Two ranks resume a checkpoint of three ranks in the middle of a collapse, bitwise identical to one process.
TEST(Ranks, CheckpointsOfLargeMotionAreOfAnyNumberOfThem) {
  struct Goes {
    std::string scene;
    Overrides overrides;
    long detections;
  };
  constexpr long kFirst = 2000, kThen = 2000;
  for (const Goes& of :
       {Goes{kScenes + "mixed.toml", {"stage.weight.gravity=[20.0, -9.81, 0.0]"}, 2},  // the post falls
        Goes{QUOIN_HOST_TESTS "/all_members.toml", {}, 0}}) {
    const auto read = [&] { return read_scene(of.scene, of.overrides); };
    Simulation alone(read(), 1);
    alone.advance(kFirst + kThen, true);
    const auto goes_on = [&](int count, const std::vector<std::uint8_t>& from, long steps) {
      std::vector<std::uint8_t> state;
      on_ranks(count, [&](Ranks& ranks) {
        Simulation simulation(read(), 1, &ranks);
        if (!from.empty()) simulation.restore(from);
        simulation.advance(steps, true);
        simulation.save(
            [&](std::span<const std::uint8_t> bytes) { state.insert(state.end(), bytes.begin(), bytes.end()); });
      });
      return state;
    };
    const std::vector<std::uint8_t> last = goes_on(2, goes_on(3, {}, kFirst), kThen);
    Simulation reader(read(), 1);
    reader.restore(last);
    EXPECT_GT(alone.large_motion()->detection.count, of.detections) << of.scene;
    EXPECT_EQ(reader.step(), alone.step()) << of.scene;
    EXPECT_EQ(reader.hash(), alone.hash()) << of.scene;
  }
}

// An error of one rank while it builds its part is thrown by all ranks, with the same message.
TEST(Ranks, FaultsOfOnePartAreThoseOfAll) {
  const auto words = [&](const Overrides& overrides, int rank) {
    std::string message;
    EXPECT_THROW(on_ranks(3,
                          [&](Ranks& ranks) {
                            try {
                              Simulation simulation(read_scene(kScenes + "damaged_wall_030.toml", overrides), 1,
                                                    &ranks);
                              Observer nobody;
                              simulation.run(nobody);
                            } catch (const Error& error) {
                              if (ranks.rank() == rank) message = error.what();
                              EXPECT_TRUE(error.exit_code == Exit::bad_input || error.exit_code == Exit::law_refused);
                              throw;
                            }
                          }),
                 Error);
    return message;
  };
  const Overrides small{"wall.courses=6", "wall.zones=[2, 1, 1]", "stage.precompression.duration=0.001"};
  const auto with = [&](const Overrides& more) {
    Overrides all = small;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  // A crack in one corner, in joints that are still bonded.
  const Overrides open =
      with({"damage.1.crack=[[0.8, 0.1], [0.99, 0.1]]", "damage.1.initial_state=\"bonded\"", "damage.1.opening=1e-4"});
  const Overrides nowhere = with({"damage.1.from=[5, 0, 0]"});
  const Overrides weak = with({"damage.1.xi=0.5", "stage.settlement.law=elastic", "stage.shear.law=coulomb_slip",
                               "stage.settlement.displacement=0.00001", "stage.settlement.ramp_time=0.001",
                               "joints.mortar.cohesion=1e3", "joints.mortar.tensile_strength=1e3"});
  for (const int rank : {0, 1, 2}) {
    EXPECT_NE(words(open, rank).find("cannot stand open without force"), std::string::npos) << words(open, rank);
    EXPECT_NE(words(nowhere, rank).find("no contact point of its joints"), std::string::npos) << words(nowhere, rank);
    EXPECT_NE(words(weak, rank).find("outside the strength"), std::string::npos) << words(weak, rank);
  }
}

// Each eigenvalue search has new vectors. A vector at the address of an old one has new values, which must be
// exchanged.
TEST(Ranks, ExchangeTheNumbersOfTheVectorThatIsThere) {
  constexpr std::size_t kOfBody = 6;
  on_ranks(2, [](Ranks& ranks) {
    const auto here = static_cast<std::size_t>(ranks.rank()), there = 1 - here;
    const auto halo_of = [&](LaneVector<double>& vector) {
      Border border{static_cast<int>(there), {}, {}, {}, {}};
      for (std::size_t k = 0; k < kOfBody; ++k) {
        border.send.push_back(&vector[kOfBody * here + k]);
        border.receive.push_back(&vector[kOfBody * there + k]);
      }
      Halo halo;
      halo.add(std::move(border));
      return halo;
    };
    const Model model;
    RankSums sums(model, {}, {}, {0, 1}, ranks, halo_of);
    LaneVector<double> vector(2 * kOfBody), other(2 * kOfBody);
    for (const double value : {3.0, 5.0, 7.0}) {
      std::fill_n(vector.begin() + static_cast<std::ptrdiff_t>(kOfBody * here), kOfBody, value);
      sums.exchange(vector);
      for (const double number : vector) EXPECT_EQ(number, value);
      vector.swap(other);
    }
  });
}

// If one rank fails, all ranks end.
TEST(Ranks, OneThatFailsEndsAll) {
  const std::string scene = kTests + "cli/small_wall.toml";
  EXPECT_THROW(on_ranks(3,
                        [&](Ranks& ranks) {
                          Simulation simulation(read_scene(scene, {}), 1, &ranks);
                          if (ranks.rank() == 1) throw Error(Exit::numerical, "no more");
                          Observer nobody;
                          simulation.run(nobody);
                        }),
               std::exception);
}

}  // namespace
}  // namespace quoin
