// Joints that have opened wider than contact points bridge, in large motion: they are cracks all the same.
#include "results/parted_joints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "folder.h"
#include "results/block_picture.h"
#include "scene/read_scene.h"

namespace quoin {
namespace {

class PartedJoints : public InFolder {};

constexpr double kPulled = 0.01;  // m; points bridge a millimetre or two

// A wall whose top beam is pulled up, with a bed below that holds nothing.
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
  for (const ContactPoint& p : simulation.contact_points()) pairs.insert(std::minmax(p.block_a, p.block_b));
  return pairs;
}

TEST_F(PartedJoints, AreOpenCracksOfPicturesWithTheirOpening) {
  Simulation simulation(read_scene_text(kScene, "parted.toml", {}), 1);
  const Surfaces surfaces;
  const Pairs start = touching(simulation);
  EXPECT_TRUE(parted_joints(simulation).empty());
  Observer nobody;
  simulation.run(nobody);

  // Every joint of the start either touches still or has parted. The wall hangs on the beam: the opening is what that
  // has moved, and what the bricks still swing by.
  Pairs all = touching(simulation);
  const std::vector<PartedJoint> parted = parted_joints(simulation);
  ASSERT_FALSE(parted.empty());
  for (const PartedJoint& joint : parted) {
    EXPECT_TRUE(all.insert(std::minmax(joint.block_a, joint.block_b)).second);
    EXPECT_NEAR(joint.opening, kPulled, 0.05 * kPulled);
    for (std::size_t i = 0; i < joint.side_a.size(); ++i)
      EXPECT_NEAR(std::abs(joint.side_a[i][1] - joint.side_b[i][1]), joint.opening, 0.01 * kPulled);
  }
  EXPECT_EQ(all, start);

  plot_block_cracks(folder_, simulation, surfaces, "");  // the script stays, also without gnuplot
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

class BlockPicture : public InFolder {};

// Blocks that do not stand in one plane are seen from above and from the right, (0.55, 0.45, 1): what is nearer hides
// what is behind, whatever was named first, and the ground hides nothing.
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
  plot_block_cracks(folder_, simulation, Surfaces(), "");
  std::istringstream script(read_all(folder_ / "plots" / "cracks.gp"));
  std::vector<std::array<double, 2>> across;  // of each polygon: left and right end on paper, m
  for (std::string line; std::getline(script, line);) {
    if (!line.starts_with("set object ")) continue;
    auto& [left, right] = across.emplace_back(std::array{1e9, -1e9});
    for (std::size_t at = line.find(" from "); at != std::string::npos; at = line.find(" to ", at + 1)) {
      const double x = std::stod(line.substr(line.find(' ', at + 1) + 1));
      left = std::min(left, x), right = std::max(right, x);
    }
  }
  ASSERT_GE(across.size(), 7u) << "three faces of each stone, and the top of the ground";
  EXPECT_GT(across[0][1] - across[0][0], 0.5) << "the ground, as far as the picture goes";
  // 2 m nearer is 2 m 0.55/sqrt(0.55^2 + 1) further to the left; a stone is 0.3 m across.
  const std::size_t first = across.size() - 6;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(across[first + i][1] - across[first + i][0], 0.3);
    EXPECT_GT(across[first + i][0], across[first + 3 + i][1] + 0.5) << "the one behind is drawn first";
  }
}

}  // namespace
}  // namespace quoin
