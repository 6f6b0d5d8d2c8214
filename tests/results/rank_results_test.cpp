// Files that rank 0 writes with data of other ranks are equal to those of one process. If rank 0 fails no rank waits
// without end. Ranks are threads here.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <fstream>
#include <map>
#include <optional>

#include "../host/thread_ranks.h"
#include "base/error.h"
#include "folder.h"
#include "results/crushed_out.h"
#include "results/plots.h"
#include "results/read_vtu.h"
#include "results/vtk.h"
#include "scene/read_scene.h"
#include "step/collect.h"

namespace quoin {
namespace {

class RankResults : public InFolder {};

struct Case {
  std::string scene;
  std::vector<std::string> overrides;
};
const Case kWall{QUOIN_TESTS "/cli/small_wall.toml",
                 {"wall.courses=5", "stage.precompression.duration=0.004", "stage.shear.displacement=0.00005"}};
const Case kRigid{QUOIN_SCENES "/cube_wall_10.toml", {"stage.1.displacement=0.0001", "output.frames=2"}};

// Deformable blocks of any shape, in large motion.
const Case kFree{QUOIN_SCENES "/mixed.toml",
                 {"wall.rigid_units=false", "wall.zones=[2, 2, 1]", "stage.weight.duration=0.004",
                  "stage.push.duration=0.004", "output.frames=2"}};

// A wall whose joints separate in large motion: 26 points have no contact at the end.
const Case kParted{QUOIN_TESTS "/results/settling_wall.toml", {}};

// Writes frames, on rank 0 of several ranks or in one process.
class Writer : public Observer {
 public:
  explicit Writer(const std::filesystem::path& folder) : frames_(folder, surfaces_) {}
  void on_frame(const Simulation& simulation, int, int) override {
    if (failed) return frames_.leave_out(simulation);
    try {
      frames_.add_piece(simulation);
    } catch (const Error& error) {
      failed = error.what();
    }
  }
  void on_row(const HistoryRow& row) override { last = row.resistance; }
  std::optional<std::string> failed;
  double last = 0.0;

 private:
  Surfaces surfaces_;
  VtkSeries frames_;
};

class Helper : public Observer {
 public:
  void on_frame(const Simulation& simulation, int, int) override { collect_frame(simulation, surfaces_); }

 private:
  Surfaces surfaces_;
};

struct Written {
  std::map<std::string, std::string> bytes;  // by file
  CrushedOut crushed_out;
};

Written written_by(const Case& of, const std::filesystem::path& folder, Ranks* ranks) {
  Simulation simulation(read_scene(of.scene, of.overrides), 1, ranks);
  if (ranks && ranks->rank() > 0) {
    Helper helper;
    simulation.run(helper);
    find_crushed_out(simulation);
    if (!simulation.large_motion()) collect_cracks(simulation, {});
    EXPECT_TRUE(ranks_collect(simulation)) << "rank 0 has all";
    return {};
  }
  std::filesystem::create_directories(folder);
  Writer writer(folder);
  simulation.run(writer);
  EXPECT_EQ(writer.failed, std::nullopt);
  Written written;
  written.crushed_out = find_crushed_out(simulation);
  if (!simulation.large_motion()) plot_cracks(folder, simulation, {}, {}, "law", "");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string extension = entry.path().extension();
    if (extension != ".vtu" && extension != ".dat") continue;
    written.bytes[entry.path().filename()] = read_all(entry.path());
  }
  return written;
}

TEST_F(RankResults, HaveTheBytesOfOneProcess) {
  for (const Case* const one : {&kWall, &kRigid, &kFree, &kParted}) {
    const Case& of = *one;
    const Written alone = written_by(of, folder_ / "1", nullptr);
    ASSERT_GE(alone.bytes.size(), &of == &kFree || &of == &kParted ? 6u : 15u)
        << "two files a frame, nine of the picture";
    ASSERT_GT(alone.bytes.at("joints_0001.vtu").size(), 5000u);
    for (const int count : {2, 3}) {
      Written first;
      on_ranks(count, [&](Ranks& ranks) {
        const Written here = written_by(of, folder_ / std::to_string(count), &ranks);
        if (ranks.rank() == 0) first = here;
      });
      ASSERT_EQ(first.bytes.size(), alone.bytes.size());
      for (const auto& [name, bytes] : alone.bytes) EXPECT_TRUE(first.bytes[name] == bytes) << name << ", " << count;
    }
    std::filesystem::remove_all(folder_);
  }
}

// Each piece has the joints whose first block is of its rank, also if the other block is of another rank.
TEST_F(RankResults, PiecesHaveTheJointsThatHaveParted) {
  const auto parted_in = [](const std::filesystem::path& file) {
    const VtuFile joints(file);
    const auto gap = joints.read<float>("gap_m", VtkRows::point, 3);
    std::map<std::array<float, 3>, int> parted;
    for (std::size_t i = 0; i < gap.size(); i += 3) {
      const std::array<float, 3> here{gap[i], gap[i + 1], gap[i + 2]};
      if (here != std::array<float, 3>{}) ++parted[here];
    }
    return parted;
  };
  written_by(kParted, folder_ / "1", nullptr);
  const auto whole = parted_in(folder_ / "1" / "joints_0002.vtu");
  ASSERT_GT(whole.size(), 5u);
  constexpr int kRanks = 3;
  Case in_pieces = kParted;
  in_pieces.overrides.emplace_back("output.pieces=true");
  std::filesystem::create_directories(folder_ / "3");
  on_ranks(kRanks, [&](Ranks& ranks) {
    Simulation simulation(read_scene(in_pieces.scene, in_pieces.overrides), 1, &ranks);
    struct Pieced : Observer {
      Surfaces surfaces;
      VtkSeries frames;
      Pieced(const std::filesystem::path& folder, Pieces pieces) : frames(folder, surfaces, {}, false, pieces) {}
      void on_frame(const Simulation& now, int, int) override { frames.add_piece(now); }
    } pieced(folder_ / "3", {ranks.rank(), kRanks});
    simulation.run(pieced);
  });
  std::map<std::array<float, 3>, int> all;
  for (int r = 0; r < kRanks; ++r) {
    for (const auto& [gap, count] : parted_in(folder_ / "3" / fmt::format("joints_0002_r{}.vtu", r))) all[gap] += count;
  }
  EXPECT_EQ(all, whole);
}

// A wall of low strength, with crushed-out points on every rank.
TEST_F(RankResults, CountTheCrushedPointsOfAll) {
  Case crushed = kWall;
  for (const char* more : {"joints.mortar.compressive_strength=1e4", "joints.mortar.fracture_energy_compression=0.5",
                           "solver.large_motion=never", "solver.past_motion_bound=warn"})
    crushed.overrides.emplace_back(more);
  const Written alone = written_by(crushed, folder_ / "1", nullptr);
  ASSERT_GT(alone.crushed_out.points, 10);
  ASSERT_GT(alone.crushed_out.overlap, 0.0);
  on_ranks(3, [&](Ranks& ranks) {
    const Written here = written_by(crushed, folder_ / "3", &ranks);
    if (ranks.rank() > 0) return;
    EXPECT_EQ(here.crushed_out.points, alone.crushed_out.points);
    EXPECT_EQ(here.crushed_out.overlap, alone.crushed_out.overlap);
  });
}

TEST_F(RankResults, RunGoesOnWhereFramesCannotBeWritten) {
  std::filesystem::create_directories(folder_);
  Writer alone(folder_);
  Simulation one(read_scene(kWall.scene, kWall.overrides));
  one.run(alone);
  std::atomic<int> ended = 0;
  on_ranks(3, [&](Ranks& ranks) {
    Simulation simulation(read_scene(kWall.scene, kWall.overrides), 1, &ranks);
    if (ranks.rank() > 0) {
      Helper helper;
      simulation.run(helper);
    } else {
      std::ofstream(folder_ / "taken") << "a file, no folder";
      Writer writer(folder_ / "taken");
      simulation.run(writer);
      ASSERT_TRUE(writer.failed);
      EXPECT_NE(writer.failed->find("cannot be written"), std::string::npos) << *writer.failed;
      EXPECT_EQ(writer.last, alone.last);
    }
    ++ended;
  });
  EXPECT_EQ(ended, 3);
}

}  // namespace
}  // namespace quoin
