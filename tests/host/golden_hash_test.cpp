// Hashes of small runs of every kind, after some thousand steps of loading. They are equal for any number of threads
// and any instruction set with fused multiply-add, and equal to the recorded hashes. So this test finds unintended
// changes that are below the tolerances of other tests.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "hwy/highway.h"
#include "hwy/targets.h"
#include "scene/read_scene.h"
#include "step/collect.h"
#include "step/kernels.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"
#include "thread_ranks.h"

namespace quoin {
namespace {

struct GoldenRun {
  const char* name;
  const char* scene;
  std::vector<std::string> overrides;
  long steps;          // steps of the last stage
  std::uint64_t hash;  // recorded with AVX-512, GCC 12
};

void PrintTo(const GoldenRun& run, std::ostream* out) { *out << run.name; }

const GoldenRun kRuns[] = {
    {"solid_wall", QUOIN_SCENES "/solid_wall_030.toml", {"stage.2.record_interval=500"}, 2000, 0x39fb73e82519f919u},
    {"cube_wall", QUOIN_SCENES "/cube_wall_10.toml", {"stage.1.record_interval=500"}, 2000, 0xe58c102272fd8798u},
    {"building",
     QUOIN_HOST_TESTS "/small_building.toml",
     {"solver.large_motion=never", "solver.past_motion_bound=warn"},
     2000,
     0xf76d0a0c14941d30u},
    {"tilted_wall",
     QUOIN_SCENES "/ferris_tin_loi_2.toml",
     {"stage.2.record_interval=500", "stage.2.ramp_time=0.2", "stage.2.collapse.start=0.6"},
     5000,
     0xe7c67fa1be144863u},
    {"falling_arch",
     QUOIN_SCENES "/arch.toml",
     {"stage.2.record_interval=500", "stage.2.ramp_time=0.2", "stage.2.collapse.start=0.5",
      "stage.2.collapse.displacement=3.0"},
     4000,
     0x50e4f5ce7b71dd22u},
};

// Stops at the first row of the last stage after the given number of steps.
struct Stopper : Observer {
  void on_stage_begin(const Simulation& s, int) override { start = s.step(); }
  void on_row(const HistoryRow& row) override {
    if (row.stage == last && row.step - start >= steps) simulation->request_stop();
  }
  Simulation* simulation = nullptr;
  int last = 0;
  long start = 0, steps = 0;
};

// Limits the instruction set of laws and host, which choose their kernels through one library.
struct OnTarget {
  explicit OnTarget(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~OnTarget() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

struct Bits {
  std::uint64_t hash = 0;
  std::string instruction_set;
  long steps = 0, damaged = 0;
};

Bits bits_of(const GoldenRun& run, int threads) {
  Scene scene = read_scene(run.scene, run.overrides);
  scene.output.frames = 0;
  Simulation simulation(scene, threads);
  Stopper stopper;
  stopper.simulation = &simulation;
  stopper.last = static_cast<int>(scene.stages.size()) - 1;
  stopper.steps = run.steps;
  try {
    simulation.run(stopper);
    ADD_FAILURE() << "the run ended before it was stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::interrupted) << error.what();
  }
  const auto counts = condition_counts(simulation);
  return {simulation.hash(), kernel_instruction_set(), simulation.step(),
          simulation.point_count() - counts[static_cast<std::size_t>(Condition::elastic)]};
}

class GoldenHash : public ::testing::TestWithParam<GoldenRun> {};

TEST_P(GoldenHash, ThreadsAndFusedInstructionSetsAgreeWithTheRecord) {
  const GoldenRun& run = GetParam();
  const Bits first = bits_of(run, 1);
  std::printf("%s: %ld steps, %ld points not elastic, %s: 0x%016llx\n", run.name, first.steps, first.damaged,
              first.instruction_set.c_str(), static_cast<unsigned long long>(first.hash));
  EXPECT_GT(first.damaged, 0) << "a run in which nothing gives way says little";
  for (const int threads : {2, 4}) EXPECT_EQ(bits_of(run, threads).hash, first.hash) << threads << " threads";

  const std::int64_t fused = hwy::SupportedTargets() & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2);
  if (fused == 0) {
    std::printf("no AVX2 or AVX-512: %s is not compared with the record\n", first.instruction_set.c_str());
    return;
  }
  if ((fused & HWY_AVX2) != 0 && fused != HWY_AVX2) {
    const OnTarget avx2(HWY_AVX2);
    const Bits other = bits_of(run, 1);
    EXPECT_EQ(other.instruction_set, "AVX2");
    EXPECT_EQ(other.hash, first.hash) << other.instruction_set << " and " << first.instruction_set;
  }
  EXPECT_EQ(first.hash, run.hash) << "with " << first.instruction_set << ", " << first.steps
                                  << " steps. If results were meant to change, put the hash printed above into "
                                     "golden_hash_test.cpp and say why in the commit";
}

// Compares every number of every row, with energies and damping work. Sums over gridpoints and contact points are split
// at fixed positions, so their rounding does not depend on the vector length.
TEST(Rows, HaveTheSameBitsWithVectorsOfFourAndOfEight) {
  if ((hwy::SupportedTargets() & (HWY_AVX3_DL | HWY_AVX3)) == 0 || (hwy::SupportedTargets() & HWY_AVX2) == 0)
    GTEST_SKIP() << "no AVX-512 here: there is nothing to compare AVX2 with";
  struct Numbers : Observer {
    std::vector<double> all;
    void on_row(const HistoryRow& row) override {
      const Energies& e = row.energies.value();
      all.insert(all.end(), {row.displacement, row.resistance, row.vertical_force, row.dynamic_force,
                             row.unbalanced_ratio, e.kinetic, e.strain, e.contact_stored, e.dissipated[0],
                             e.dissipated[1], e.dissipated[2], e.dissipated[3], e.external, e.damping});
    }
  };
  for (const char* kernels : {"lattice", "general"}) {
    for (const std::vector<std::string>& solver :
         {std::vector<std::string>{"solver.damping=viscous", "solver.mass_damping=20", "solver.stiffness_damping=1e-6"},
          {"solver.damping=local"},
          {"solver.damping=block"}}) {
      SCOPED_TRACE(kernels + solver[0]);
      const auto numbers = [&] {
        std::vector<std::string> overrides = solver;
        overrides.insert(overrides.end(), {std::string("solver.kernels=") + kernels, "output.energy=true",
                                           "stage.precompression.duration=0.002", "stage.shear.displacement=0.00002"});
        Simulation simulation(read_scene(QUOIN_HOST_TESTS "/../cli/small_wall.toml", overrides));
        Numbers rows;
        simulation.run(rows);
        return rows.all;
      };
      const std::vector<double> eight = numbers();
      ASSERT_GT(eight.size(), 1000u);
      const OnTarget avx2(HWY_AVX2);
      EXPECT_EQ(numbers(), eight);
    }
  }
}

// Short runs, one for each kind of model and each event in a run, with joints weak enough to crack.
struct GoldenKind {
  const char* name;
  std::string scene;
  std::vector<std::string> overrides;
  std::uint64_t state, rows;  // hashes recorded with AVX-512, GCC 12: of all bodies and contact points; of the history
  enum { nothing, promotion, swap, detection, parting, leaving } has = nothing;
};

void PrintTo(const GoldenKind& kind, std::ostream* out) { *out << kind.name; }

const std::string kWall = QUOIN_HOST_TESTS "/../cli/small_wall.toml";

std::vector<std::string> weak(const std::vector<std::string>& more, double shear = 4e-5) {
  std::vector<std::string> all = {"wall.courses=4",
                                  "wall.units_per_course=3",
                                  "joints.mortar.tensile_strength=3e4",
                                  "joints.mortar.cohesion=5e4",
                                  "joints.mortar.fracture_energy_tension=1",
                                  "stage.precompression.duration=0.003",
                                  "stage.precompression.pressure=0.1e6",
                                  "stage.shear.velocity=0.2",
                                  "stage.shear.ramp_time=0.0005",
                                  fmt::format("stage.shear.displacement={}", shear)};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

const std::vector<std::string> kCycles = {"wall.courses=3",
                                          "wall.units_per_course=2",
                                          "wall.zones=[2, 1, 1]",
                                          "joints.mortar.tensile_strength=3e4",
                                          "stage.precompression.duration=0.003",
                                          "stage.cycles.amplitudes=[2e-5, 4e-5]",
                                          "stage.cycles.velocity=0.05",
                                          "stage.cycles.ramp_time=0.0002"};

std::vector<std::string> with(std::vector<std::string> overrides, const std::vector<std::string>& more) {
  overrides.insert(overrides.end(), more.begin(), more.end());
  return overrides;
}

const GoldenKind kKinds[] = {
    {"lattice", kWall, weak({}), 0x52614e085cdbd210u, 0x403fa4a3e15dc73fu},
    {"lattice_local", kWall, weak({"solver.damping=local"}), 0xb8e04d0b72186256u, 0x1c1a5e1fe656aa55u},
    {"lattice_viscous", kWall,
     weak({"solver.damping=viscous", "solver.mass_damping=20", "solver.stiffness_damping=1e-6"}), 0x0b571907ed8d7beeu,
     0xb40525e375255b2eu},
    {"half_thickness", kWall, weak({"wall.half_thickness=true", "wall.zones=[2, 1, 2]"}), 0x9b9f93ab1f212e18u,
     0x1c67dea530db268eu},
    {"selective", kWall, weak({"solver.selective_time_step=4e-5"}), 0x1ab7852eaf0e2837u, 0x434a4cc6c641d6ebu},
    {"building",
     QUOIN_HOST_TESTS "/small_building.toml",
     {"joints.mortar.tensile_strength=1e4", "stage.push.displacement=0.0001", "stage.push.record_interval=100"},
     0xaefc66e589a8b9bbu,
     0x58c51cd8f9fef654u},
    {"cyclic", QUOIN_SCENES "/cyclic_wall_121.toml", kCycles, 0x341e64fc1532c6fdu, 0x17d2a968101fa2d5u},
    {"swapped", kWall, weak({"stage.shear.law=coulomb_slip"}), 0x466c94200de72f3bu, 0xf7791bff44b599e8u,
     GoldenKind::swap},
    {"damaged",
     QUOIN_SCENES "/damaged_wall_030.toml",
     {"wall.courses=8", "wall.zones=[2, 1, 1]", "damage.1.crack=[[0.11, 0.4], [0.88, 0.07]]", "damage.1.opening=1e-6",
      "stage.precompression.duration=0.002", "stage.settlement.displacement=0.00001",
      "stage.settlement.ramp_time=0.001", "stage.shear.displacement=0.00001"},
     0x0cb6872595bbea93u,
     0x7f190f045fc7837cu},
    {"scattered", kWall,
     weak({"joints.mortar.tensile_strength={distribution='lognormal', mean=3e4, cov=0.3, level='point', "
           "correlation_length=0.3, scatter_of='joint'}",
           "joints.mortar.cohesion={distribution='lognormal', mean=5e4, cov=0.3, level='unit', "
           "correlation_length=0.5}",
           "joints.mortar.normal_stiffness={distribution='lognormal', mean=82e9, cov=0.3}"}),
     0x26cab5255051ec0bu, 0xde24dd83f629b040u},
    {"promoted", kWall, weak({"solver.rotation_bound=1e-5"}), 0x6aa6879cea711137u, 0xee29108fda1495a0u,
     GoldenKind::promotion},
    {"promoted_local", kWall, weak({"solver.rotation_bound=1e-5", "solver.damping=local"}), 0xb56b08ff5d4e1977u,
     0xed3e4b8478216a1eu, GoldenKind::promotion},
    {"promoted_cycles", QUOIN_SCENES "/cyclic_wall_121.toml", with(kCycles, {"solver.rotation_bound=1e-5"}),
     0xa8f08bd41babf520u, 0x787357033581c7e3u, GoldenKind::promotion},
    {"promoted_units", kWall,
     weak({"solver.rotation_bound=1e-5", "wall.mid_unit_joints=true", "wall.unit_joint=mortar"}), 0x59efcc720426ef86u,
     0xd05af1cd288f1c05u, GoldenKind::promotion},
    {"general", kWall, weak({"solver.kernels=general"}), 0xc991c76fb0e7ecd8u, 0x3040b885aa0a617eu},
    {"general_viscous", kWall,
     weak({"solver.kernels=general", "solver.damping=viscous", "solver.mass_damping=20",
           "solver.stiffness_damping=1e-6"}),
     0x7aa7cdfc577e2e0au, 0x0902c06e34ead715u},
    {"general_zones", kWall, weak({"solver.kernels=general", "solver.internal_forces=zones"}), 0x497d5248caa784dau,
     0xe0b84f6db99f120cu},
    {"general_swapped", kWall, weak({"solver.kernels=general", "stage.shear.law=coulomb_slip"}), 0x7f2645a15a9df58bu,
     0xd082e0ef38aec491u, GoldenKind::swap},
    {"general_scattered", kWall,
     weak({"solver.kernels=general", "joints.mortar.cohesion={distribution='lognormal', mean=5e4, cov=0.3}"}),
     0xe4cadb4eb0997000u, 0xec2c3a4677967712u},
    {"general_damaged",
     QUOIN_SCENES "/damaged_wall_030.toml",
     {"solver.kernels=general", "wall.courses=4", "wall.zones=[2, 1, 1]", "damage.1.crack=[[0.11, 0.2], [0.88, 0.07]]",
      "damage.1.opening=1e-6", "stage.precompression.duration=0.001", "stage.settlement.displacement=0.000005",
      "stage.settlement.ramp_time=0.0005", "stage.shear.displacement=0.000005"},
     0x775459aae5a93d92u,
     0xdddf6fbf93b32c60u},
    {"general_rigid",
     QUOIN_SCENES "/cube_wall_10.toml",
     {"solver.kernels=general", "stage.1.displacement=0.0002", "joints.mortar.tensile_strength=1e4"},
     0x6b3011016061381du,
     0x4b6ee726d2ac2d55u},
    {"halves_part",
     QUOIN_HOST_TESTS "/halves_part.toml",
     {"solver.large_motion=always"},
     0xe622dc80912200b0u,
     0xa690097c8f4a853du,
     GoldenKind::parting},
    {"corners",
     QUOIN_HOST_TESTS "/small_building.toml",
     {"solver.large_motion=always", "joints.unit.law=fracture_energy", "joints.unit.tensile_strength=1e3",
      "joints.unit.cohesion=1e3", "joints.unit.friction_angle=30", "joints.unit.compressive_strength=6.2e6",
      "joints.unit.fracture_energy_tension=0.01", "joints.unit.fracture_energy_shear=0.1",
      "joints.unit.fracture_energy_compression=1e4", "stage.push.displacement=0.006", "stage.push.velocity=0.3"},
     0x216af9dd125440cbu,
     0x4034309e0394ab60u,
     GoldenKind::parting},
    {"leaving_frames",
     QUOIN_HOST_TESTS "/small_building.toml",
     {"solver.sliding_bound=0.01", "stage.push.displacement=0.006", "stage.push.record_interval=10"},
     0x0e66f57fbb301892u,
     0x2b26ac5f9d9ef56fu,
     GoldenKind::leaving},
    {"turned", QUOIN_HOST_TESTS "/turned_wall.toml", {}, 0x34a2ca0ff63f473bu, 0xfc82aafe511a566au},
    {"mixed",
     QUOIN_SCENES "/mixed.toml",
     {"stage.weight.duration=0.05", "stage.push.duration=0.1"},
     0x81a82387ee8cea08u,
     0x639c5a0bcdbc95e8u,
     GoldenKind::detection},
    {"mixed_deformable",
     QUOIN_SCENES "/mixed.toml",
     {"wall.rigid_units=false", "wall.zones=[2, 2, 1]", "stage.weight.duration=0.004", "stage.push.duration=0.004"},
     0xe3efd9a143c63701u,
     0xcd340691b3ae52cdu},
    {"arch",
     QUOIN_SCENES "/arch.toml",
     {"arch.arch.voussoirs=15", "stage.push.collapse.rate=0.5", "stage.weight.duration=0.1",
      "stage.weight.ramp_time=0.05", "stage.push.ramp_time=0.1"},
     0x2fd96878a361811fu,
     0x32893c3146769c8cu,
     GoldenKind::detection},
};

constexpr std::uint64_t kHashStart = 0xcbf29ce484222325u;  // FNV-1a, 64 bits at a time
void add_to_hash(std::span<const double> numbers, std::uint64_t* hash) {
  for (const double x : numbers) *hash = (*hash ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3u;
}

struct GoldenBits {
  std::uint64_t state = 0, rows = kHashStart;
  long steps = 0, not_elastic = 0;
  std::vector<long> frames = {};  // their steps
  bool operator==(const GoldenBits&) const = default;
};
std::string PrintToString(const GoldenBits& b) {
  return fmt::format("0x{:016x}u, 0x{:016x}u ({} steps, {} points not elastic, {} frames)", b.state, b.rows, b.steps,
                     b.not_elastic, b.frames.size());
}
void PrintTo(const GoldenBits& bits, std::ostream* out) { *out << PrintToString(bits); }

// Hash of the history of a run, and a state from its middle.
struct Golden : Observer {
  std::uint64_t rows = kHashStart, rows_then = kHashStart;
  std::vector<std::uint8_t> saved;
  std::vector<long> frames, frames_then;  // steps of frames
  long save_after = -1;                   // steps
  int swaps = 0, promotions = 0;
  const Simulation* watched = nullptr;
  int fewest_units = std::numeric_limits<int>::max(), most_units = 0;    // number of units whose halves are connected
  long fewest_fixed = std::numeric_limits<long>::max(), most_fixed = 0;  // number of blocks in fixed frames
  bool wants_pause(bool) override { return save_after >= 0; }
  void on_pause(const Simulation& simulation, bool) override {
    if (save_after < 0 || simulation.step() < save_after || !saved.empty()) return;
    saved = simulation.save(), rows_then = rows, frames_then = frames;
  }
  void on_frame(const Simulation& simulation, int, int) override { frames.push_back(simulation.step()); }
  void on_law_swap(const LawSwap&) override { ++swaps; }
  void on_promotion(const Simulation&) override { ++promotions; }
  void on_row(const HistoryRow& row) override {
    if (const blocks::Model* m = watched ? watched->large_motion() : nullptr) {
      fewest_units = std::min(fewest_units, m->units.count), most_units = std::max(most_units, m->units.count);
      const long fixed = std::ranges::count(m->frames.fixed, 1);
      fewest_fixed = std::min(fewest_fixed, fixed), most_fixed = std::max(most_fixed, fixed);
    }
    const Energies& e = row.energies.value();
    const double numbers[] = {row.time,           row.displacement,     row.resistance,     row.vertical_force,
                              row.dynamic_force,  row.unbalanced_ratio, row.kinetic_energy, row.multiplier,
                              row.joint_force[0], row.joint_force[1],   e.kinetic,          e.strain,
                              e.contact_stored,   e.dissipated[0],      e.dissipated[1],    e.dissipated[2],
                              e.dissipated[3],    e.external,           e.damping,          e.detection};
    add_to_hash(numbers, &rows);
  }
};

class GoldenKinds : public ::testing::TestWithParam<GoldenKind> {
 protected:
  static Scene scene() {
    Scene scene = read_scene(GetParam().scene, with(GetParam().overrides, {"output.energy=true"}));
    scene.output.frames = 0;
    scene.output.frames_at_damage = 1e-5;  // the records are of runs without
    scene.solver.motion_bound.stop = false;
    return scene;
  }
  static GoldenBits bits_of(const Simulation& simulation, const Golden& golden) {
    const auto counts = condition_counts(simulation);
    return {simulation.hash(), golden.rows, simulation.step(),
            simulation.point_count() - counts[static_cast<std::size_t>(Condition::elastic)], golden.frames};
  }
  static GoldenBits alone(int threads) {
    Simulation simulation(scene(), threads);
    Golden golden;
    simulation.run(golden);
    return bits_of(simulation, golden);
  }
};

// One thread is the reference. Four threads, two ranks, a run resumed from its middle and the other instruction set
// must be bitwise identical.
TEST_P(GoldenKinds, ThreadsRanksResumedRunsAndInstructionSetsAgreeWithTheRecord) {
  const GoldenKind& kind = GetParam();
  Simulation simulation(scene(), 1);
  Golden golden;
  golden.watched = &simulation;
  simulation.run(golden);
  const GoldenBits bits = bits_of(simulation, golden);
  std::printf("%s: %s\n", kind.name, PrintToString(bits).c_str());
  EXPECT_GT(bits.not_elastic, 0) << "a run in which nothing gives way says little";
  EXPECT_EQ(golden.promotions > 0, kind.has == GoldenKind::promotion || kind.has == GoldenKind::leaving);
  EXPECT_EQ(golden.swaps > 0, kind.has == GoldenKind::swap);
  if (kind.has == GoldenKind::detection) {
    EXPECT_GT(simulation.large_motion()->detection.count, 2);
  }
  if (kind.has == GoldenKind::parting) {
    EXPECT_LT(golden.fewest_units, golden.most_units) << "no halves parted";
  }
  if (kind.has == GoldenKind::leaving) {
    EXPECT_LT(golden.fewest_fixed, golden.most_fixed) << "no block left its fixed frame";
    EXPECT_GT(golden.fewest_fixed, 0) << "all blocks left their fixed frames";
  }

  EXPECT_EQ(alone(4), bits) << "4 threads";
  on_ranks(2, [&](Ranks& ranks) {
    Simulation half(scene(), 1, &ranks);
    Golden of_half;
    half.run(of_half);
    gather_at_first(half);
    if (ranks.rank() == 0) {
      EXPECT_EQ(bits_of(half, of_half), bits) << "2 ranks";
    }
  });
  Golden to_save, resumed;
  to_save.save_after = bits.steps / 2;
  Simulation(scene(), 1).run(to_save);
  Simulation again(scene(), 1);
  again.restore(to_save.saved);
  resumed.rows = to_save.rows_then, resumed.frames = to_save.frames_then;
  again.run(resumed);
  EXPECT_EQ(bits_of(again, resumed), bits) << "resumed";

  const std::int64_t fused = hwy::SupportedTargets() & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2);
  if (fused == 0) return;
  if ((fused & HWY_AVX2) != 0 && fused != HWY_AVX2) {
    const OnTarget avx2(HWY_AVX2);
    EXPECT_EQ(alone(1), bits) << "AVX2";
  }
  EXPECT_EQ(bits, (GoldenBits{kind.state, kind.rows, bits.steps, bits.not_elastic, bits.frames}))
      << "If results were meant to change, put the hashes printed above into golden_hash_test.cpp and say why in the "
         "commit";
}

INSTANTIATE_TEST_SUITE_P(Kinds, GoldenKinds, ::testing::ValuesIn(kKinds),
                         [](const ::testing::TestParamInfo<GoldenKind>& kind) { return std::string(kind.param.name); });

INSTANTIATE_TEST_SUITE_P(Runs, GoldenHash, ::testing::ValuesIn(kRuns),
                         [](const ::testing::TestParamInfo<GoldenRun>& run) { return std::string(run.param.name); });

}  // namespace
}  // namespace quoin
