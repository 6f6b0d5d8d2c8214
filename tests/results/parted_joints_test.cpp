// Joints in large motion that have opened beyond the range of contact points: they are still drawn as cracks.
#include "results/parted_joints.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "folder.h"
#include "results/block_picture.h"
#include "results/read_vtu.h"
#include "results/vtk.h"
#include "scene/read_scene.h"
#include "step/results.h"

namespace quoin {
namespace {

class PartedJoints : public InFolder {};

constexpr double kPulled = 0.01;  // m; points bridge a millimetre or two

// A wall whose top beam moves up, with a bed joint below without strength.
const std::string kScene =
    "[materials.brick]\nyoung_modulus = 16.7e9\npoisson_ratio = 0.15\ndensity = 1900.0\n"
    "[joints.mortar]\nlaw = \"fracture_energy\"\nnormal_stiffness = 82e9\nshear_stiffness = 36e9\n"
    "tensile_strength = 0.2e6\ncohesion = 0.3e6\nfriction_angle = 35\nfracture_energy_tension = 15\n"
    "fracture_energy_shear = 125\n"
    "[wall]\ncourses = 2\nunits_per_course = 2\nunit = [0.22, 0.0625, 0.1]\nzones = [1, 1, 1]\n"
    "mid_unit_joints = false\nunit_material = \"brick\"\nbed_joint = \"mortar\"\nhead_joint = \"mortar\"\n"
    "beam_joint = \"mortar\"\n[[damage]]\nto = [1, 0.01, 1]\n[solver]\nlarge_motion = \"always\"\n"
    "[[stage]]\nname = \"pull\"\nkind = \"custom\"\nmonitor = \"top_beam\"\ndirection = \"y\"\ndisplacement = 0.01\n"
    "ramp_time = 0.001\n[[stage.control]]\nbody = \"bottom_beam\"\nvelocity = [0, 0, 0]\n"
    "[[stage.control]]\nbody = \"top_beam\"\nvelocity = [0, 0.2, 0]\n";

using Pairs = std::set<std::pair<int, int>>;
Pairs touching(const Simulation& simulation) {
  Pairs pairs;
  for (const ContactPoint& p : contact_points(simulation)) pairs.insert(std::minmax(p.block_a, p.block_b));
  return pairs;
}

TEST_F(PartedJoints, AreOpenCracksOfPicturesWithTheirOpening) {
  Simulation simulation(read_scene_text(kScene, "parted.toml", {}), 1);
  const Surfaces surfaces;
  const Pairs start = touching(simulation);
  EXPECT_TRUE(parted_points(simulation).empty());
  Observer nobody;
  simulation.run(nobody);

  // Every initial joint either has contact or has separated. The wall hangs on the beam: the opening is the
  // displacement of the beam plus the vibration of bricks.
  Pairs all = touching(simulation), parted;
  const std::vector<PartedPoint> points = parted_points(simulation);
  ASSERT_FALSE(points.empty());
  for (const PartedPoint& p : points) {
    parted.insert(std::minmax(p.joint.contact.block_a, p.joint.contact.block_b));
    EXPECT_NEAR(p.joint.opening, kPulled, 0.05 * kPulled);
    EXPECT_NEAR(std::abs(p.joint.gap[1]), p.joint.opening, 0.01 * kPulled);
    EXPECT_EQ(p.joint.crack, Crack::open);
    EXPECT_EQ(p.joint.damage_tension, 1.0) << "the bed that held nothing from the start";
    EXPECT_EQ(p.joint.contact.traction, Vec3{});
  }
  all.merge(Pairs(parted));
  EXPECT_EQ(all, start);

  plot_block_cracks(folder_, simulation, surfaces, {}, "");  // the script stays, also without gnuplot
  const std::string script = read_all(folder_ / "plots" / "cracks.gp");
  const std::string name = "$crack" + std::to_string(static_cast<int>(Crack::open)) + " << EOD\n";
  const std::size_t begin = script.find(name);
  ASSERT_NE(begin, std::string::npos);
  const std::string lines =
      script.substr(begin + name.size(), script.find("EOD", begin + name.size()) - begin - name.size());
  long gaps = 0;
  for (std::size_t i = 1; i < lines.size(); ++i) gaps += lines[i] == '\n' && lines[i - 1] == '\n';
  EXPECT_GE(gaps, static_cast<long>(2 * parted.size()));  // both sides of each
}

// Contents of a file of joints: number of points that have lost more than 0.9 of their bond, and their area; widest
// opening.
struct Damaged {
  long points = 0;
  double opening = 0.0, area = 0.0;  // m, m2
};
Damaged damaged_in(const std::filesystem::path& file) {
  const VtuFile joints(file);
  const auto tension = joints.read<float>("damage_tension", VtkRows::point),
             shear = joints.read<float>("damage_shear", VtkRows::point),
             opening = joints.read<float>("opening_m", VtkRows::point),
             area = joints.read<float>("area_m2", VtkRows::point);
  Damaged damaged;
  for (std::size_t i = 0; i < tension.size(); ++i) {
    if (std::max(tension[i], shear[i]) <= 0.9F) continue;
    ++damaged.points;
    damaged.area += double{area[i]};
    damaged.opening = std::max(damaged.opening, double{opening[i]});
  }
  return damaged;
}

class Frames : public Observer {
 public:
  Frames(const std::filesystem::path& folder, std::vector<double> before = {}) : series_(folder, surfaces_, before) {}
  void on_frame(const Simulation& simulation, int, int) override { series_.add_piece(simulation); }
  void on_pause(const Simulation& simulation, bool last) override {
    if (last) saved = simulation.save();
  }
  std::vector<std::uint8_t> saved;
  const std::vector<double>& times() const { return series_.times(); }

 private:
  Surfaces surfaces_;
  VtkSeries series_;
};

// Points of blocks that have separated stay in the frames, with their damage and their gap.
TEST_F(PartedJoints, StayInFramesWithTheirDamageAndTheirGap) {
  Simulation simulation(read_scene_text(kScene, "parted.toml", {"output.frames=5"}), 1);
  Frames frames(folder_);
  simulation.run(frames);
  Damaged before;
  for (int frame = 0; frame <= 5; ++frame) {
    const Damaged now = damaged_in(folder_ / fmt::format("joints_000{}.vtu", frame));
    EXPECT_GE(now.points, before.points) << frame;
    EXPECT_GE(now.area, 0.999 * before.area) << frame;
    EXPECT_GE(now.opening, before.opening) << frame;
    before = now;
  }
  // At least the bed of 0.44 m x 0.1 m, open by the displacement of the beam.
  EXPECT_GE(before.area, 0.044 - 1e-6);
  EXPECT_NEAR(before.opening, kPulled, 0.05 * kPulled);
}

// A resumed run writes the files of one run, including the gaps of joints that had separated before.
TEST_F(PartedJoints, AreTheSameAfterARunGoesOn) {
  const Scene scene = read_scene_text(kScene, "parted.toml", {"output.frames=5"});
  std::filesystem::create_directories(folder_ / "whole");
  Simulation whole(scene, 1);
  Frames frames(folder_ / "whole");
  whole.run(frames);

  struct Stopped : Frames {
    using Frames::Frames;
    Simulation* simulation = nullptr;
    void on_frame(const Simulation& now, int stage, int frame) override {
      Frames::on_frame(now, stage, frame);
      if (frame == 3) simulation->request_stop();
    }
  };
  Simulation first(scene, 1);
  Stopped stopped(folder_);
  stopped.simulation = &first;
  EXPECT_THROW(first.run(stopped), Error);
  ASSERT_FALSE(parted_points(first).empty());
  Simulation second(scene, 2);
  second.restore(stopped.saved);
  Frames rest(folder_, stopped.times());
  second.run(rest);
  for (const char* name : {"joints_0003.vtu", "joints_0004.vtu", "joints_0005.vtu"})
    EXPECT_TRUE(read_all(folder_ / name) == read_all(folder_ / "whole" / name)) << name;
}

// After a law swap separated joints keep their damage, by the ids of states.
TEST_F(PartedJoints, KeepTheirDamageWhenTheLawIsReplaced) {
  const std::string later =
      kScene +
      "[[stage]]\nname = \"hold\"\nkind = \"custom\"\nmonitor = \"top_beam\"\nduration = 1e-4\n"
      "law = \"fracture_energy\"\n[[stage.control]]\nbody = \"bottom_beam\"\nvelocity = [0, 0, 0]\n"
      "[[stage.control]]\nbody = \"top_beam\"\nvelocity = [0, 0, 0]\n";
  Simulation simulation(read_scene_text(later, "parted.toml", {}), 1);
  Observer nobody;
  simulation.run(nobody);
  const std::vector<PartedPoint> points = parted_points(simulation);
  ASSERT_FALSE(points.empty());
  for (const PartedPoint& p : points) EXPECT_EQ(p.joint.damage_tension, 1.0);
}

class BlockPicture : public InFolder {};

// Blocks that are not in one plane are drawn from the direction (0.55, 0.45, 1). Nearer blocks hide those behind, for
// any order of the blocks, and the ground hides nothing.
TEST_F(BlockPicture, IsDrawnFromBackToFrontOnTheGround) {
  const std::string head =
      "[materials.stone]\nyoung_modulus = 1e10\npoisson_ratio = 0.2\ndensity = 2000\n"
      "[joints.dry]\nlaw = \"elastic\"\nnormal_stiffness = 1e9\nshear_stiffness = 5e8\n";
  const auto block = [](const std::string& keys, const std::string& lower, const std::string& size) {
    return "[[block]]\nmaterial = \"stone\"\n" + keys + "box = { lower = " + lower + ", size = " + size + " }\n";
  };
  const std::string front = block("name = \"front\"\n", "[0, 0, 2]", "[0.2, 0.2, 0.2]"),
                    back = block("name = \"back\"\n", "[0, 0, 0]", "[0.2, 0.2, 0.2]"),
                    ground = block("name = \"ground\"\nfixed = true\n", "[-2, -0.2, -2]", "[6, 0.2, 6]");
  Simulation simulation(read_scene_text(head + front + back + ground + "[[stage]]\nduration = 1\n", "view.toml", {}),
                        1);
  plot_block_cracks(folder_, simulation, Surfaces(), {}, "");
  std::istringstream script(read_all(folder_ / "plots" / "cracks.gp"));
  // Left and right ends of each polygon in the picture, m, by its number, which is the order of drawing.
  std::map<int, std::array<double, 2>> by_number;
  for (std::string line; std::getline(script, line);) {
    if (!line.starts_with("set object ")) continue;
    const int number = std::stoi(line.substr(std::string("set object ").size()));
    auto& [left, right] = by_number[number] = {1e9, -1e9};
    for (std::size_t at = line.find(" from "); at != std::string::npos; at = line.find(" to ", at + 1)) {
      const double x = std::stod(line.substr(line.find(' ', at + 1) + 1));
      left = std::min(left, x), right = std::max(right, x);
    }
  }
  std::vector<std::array<double, 2>> across;
  for (const auto& [number, ends] : by_number) across.push_back(ends);
  ASSERT_GE(across.size(), 7u) << "three faces of each stone, and the top of the ground";
  EXPECT_GT(across[0][1] - across[0][0], 0.5) << "the ground, as far as the picture goes";
  // A stone that is 2 m nearer is 2 m 0.55/sqrt(0.55^2 + 1) further to the left; its width is 0.3 m.
  const std::size_t first = across.size() - 6;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(across[first + i][1] - across[first + i][0], 0.3);
    EXPECT_GT(across[first + i][0], across[first + 3 + i][1] + 0.5) << "the one behind is drawn first";
  }
}

}  // namespace
}  // namespace quoin
