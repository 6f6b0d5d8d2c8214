// The bits of small runs of every kind, some thousand steps into their loading: the same for any number of threads and
// any instruction set with fused multiply-add, and the same as when they were recorded. What changes a bit without
// meaning to is found here, whatever tolerances other tests have.
#include <gtest/gtest.h>

#include <cstdio>
#include <ostream>
#include <string>
#include <vector>

#include "hwy/highway.h"
#include "hwy/targets.h"
#include "scene/read_scene.h"
#include "support.h"

namespace quoin {
namespace {

struct GoldenRun {
  const char* name;
  const char* scene;
  std::vector<std::string> overrides;
  long steps;          // of the last stage
  std::uint64_t hash;  // recorded with AVX-512, GCC 12
};

void PrintTo(const GoldenRun& run, std::ostream* out) { *out << run.name; }

const GoldenRun kRuns[] = {
    {"solid_wall", QUOIN_SCENES "/solid_wall_030.toml", {"stage.2.record_interval=500"}, 2000, 0x963a53fad2631f16u},
    {"cube_wall", QUOIN_SCENES "/cube_wall_10.toml", {"stage.1.record_interval=500"}, 2000, 0xaa8c7c214032be81u},
    {"building",
     QUOIN_HOST_TESTS "/small_building.toml",
     {"solver.large_motion=never", "solver.past_motion_bound=warn"},
     2000,
     0x284f1536c6d5b86eu},
    {"tilted_wall",
     QUOIN_SCENES "/ferris_tin_loi_2.toml",
     {"stage.2.record_interval=500", "stage.2.ramp_time=0.2", "stage.2.collapse.start=0.6"},
     5000,
     0xccd5b837b15d3efau},
    {"falling_arch",
     QUOIN_SCENES "/arch.toml",
     {"stage.2.record_interval=500", "stage.2.ramp_time=0.2", "stage.2.collapse.start=0.5",
      "stage.2.collapse.displacement=3.0"},
     4000,
     0x6edee8b288250a8au},
};

// Stops at the first row of the last stage that lies so many steps in.
struct Stopper : Observer {
  void on_stage_begin(const Simulation& s, int) override { start = s.step(); }
  void on_row(const HistoryRow& row) override {
    if (row.stage == last && row.step - start >= steps) simulation->request_stop();
  }
  Simulation* simulation = nullptr;
  int last = 0;
  long start = 0, steps = 0;
};

// Laws and host choose their kernels through the same library, so this decides for both.
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
  const auto counts = simulation.condition_counts();
  return {simulation.hash(), simulation.instruction_set(), simulation.step(),
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

// Every number of every row, energies and what damping has taken too: sums over gridpoints and contact points go in
// parts that no vector's length decides.
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

INSTANTIATE_TEST_SUITE_P(Runs, GoldenHash, ::testing::ValuesIn(kRuns),
                         [](const ::testing::TestParamInfo<GoldenRun>& run) { return std::string(run.param.name); });

}  // namespace
}  // namespace quoin
