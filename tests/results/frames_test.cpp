// Frames of a run: their estimated size against the files of a frame; their times, read from files.
#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>
#include <fstream>
#include <map>

#include "folder.h"
#include "results/read_vtu.h"
#include "results/vtk.h"
#include "scene/read_scene.h"
#include "step/collect.h"

namespace quoin {
namespace {

class Frames : public InFolder {};

TEST_F(Frames, AreAsLargeAsWasTold) {
  for (const auto& [scene, setting] : {std::pair{"solid_wall_030", "wall.courses=4"},
                                       {"cube_wall_10", "wall.courses=4"},
                                       {"arch", "output.frames=1"},
                                       {"solid_wall_030_blocks", "dry_wall.1.courses=4"}}) {
    const Simulation simulation(read_scene(std::string(QUOIN_SCENES) + "/" + scene + ".toml", {setting}));
    const Surfaces surfaces;
    VtkSeries(folder_, surfaces).add_frame(simulation);
    const double bytes = static_cast<double>(std::filesystem::file_size(folder_ / "blocks_0000.vtu") +
                                             std::filesystem::file_size(folder_ / "joints_0000.vtu"));
    // The estimate is never too small. It has 10 kB for the heads of the two files, which use about 5 kB. It includes
    // every state of a law, although one or two of about 40 numbers of a point are not written.
    EXPECT_GE(frame_bytes(simulation, surfaces), bytes) << scene;
    EXPECT_LE(frame_bytes(simulation, surfaces), 1.05 * bytes + 8000.0) << scene;
  }
}

// The estimated growth of both files by four courses is exact, except for digits in their heads. With a law without
// states, for every kind of block.
TEST_F(Frames, GrowAsWasTold) {
  const std::string begin = R"([materials.brick]
density = 1900
young_modulus = 1e10
poisson_ratio = 0.2
[joints.mortar]
law = "elastic"
normal_stiffness = 1e10
shear_stiffness = 1e10
)";
  const std::string lattice = R"([wall]
units_per_course = 3
unit = [0.2, 0.1, 0.1]
mid_unit_joints = false
unit_material = "brick"
bed_joint = "mortar"
head_joint = "mortar"
beam_joint = "mortar"
rigid_units = {}
[[stage]]
kind = "shear"
displacement = 0.001
)";
  const std::string blocks = R"([[dry_wall]]
material = "brick"
units_per_course = 3
unit = [0.2, 0.1, 0.1]
{}
[[stage]]
gravity = [0, -9.81, 0]
duration = 0.1
[solver]
kernels = "general"
)";
  const auto with = [](std::string text, const std::string& word) { return text.replace(text.find("{}"), 2, word); };
  for (const std::string& scene : {with(lattice, "false"), with(lattice, "true"), with(blocks, ""),
                                   with(blocks, "rigid = false\nzones = [2, 2, 1]")}) {
    const char* courses = scene.starts_with("[wall]") ? "wall.courses=" : "dry_wall.1.courses=";
    double estimated[2], written[2];
    for (const int i : {0, 1}) {
      const Simulation simulation(
          read_scene_text(begin + scene, "s.toml", {courses + std::string(i == 0 ? "4" : "8")}));
      const Surfaces surfaces;
      VtkSeries(folder_, surfaces).add_frame(simulation);
      estimated[i] = frame_bytes(simulation, surfaces);
      written[i] = static_cast<double>(std::filesystem::file_size(folder_ / "blocks_0000.vtu") +
                                       std::filesystem::file_size(folder_ / "joints_0000.vtu"));
    }
    EXPECT_GT(written[1] - written[0], 1e4);
    EXPECT_NEAR(estimated[1] - estimated[0], written[1] - written[0], 50.0) << scene;
  }
}

// Threads make results side by side, and one of them writes those of the blocks before.
TEST_F(Frames, HaveTheSameBytesForAnyNumberOfThreads) {
  for (const char* kernels : {"solver.large_motion=never", "solver.large_motion=always"}) {
    std::map<std::string, std::string> files[2];
    for (const int threads : {1, 3}) {
      Simulation simulation(read_scene(QUOIN_SCENES "/wall_2m_576.toml", {kernels}), threads);
      EXPECT_GT(runs_of_blocks(simulation).size(), 1u);
      EXPECT_GT(runs_of_points(simulation).size(), 1u);
      simulation.advance(2);
      const Surfaces surfaces;
      VtkSeries(folder_, surfaces).add_frame(simulation);
      for (const char* name : {"blocks_0000.vtu", "joints_0000.vtu", "forces_0000.vtu"})
        files[threads == 1 ? 0 : 1][name] = read_all(folder_ / name);
    }
    EXPECT_GT(files[0]["blocks_0000.vtu"].size(), 1000000u);
    EXPECT_TRUE(files[0] == files[1]) << kernels;
  }
}

// Files have decimal points also if the locale of the program has decimal commas.
TEST_F(Frames, HaveTheSameTimesWhereDecimalsHaveAComma) {
  const std::string locale = (folder_ / "comma").string();
  if (std::system(("localedef -i de_DE -f UTF-8 '" + locale + "' >/dev/null 2>&1").c_str()) != 0)
    GTEST_SKIP() << "no localedef with de_DE here (Debian: locales)";
  setenv("LOCPATH", folder_.c_str(), 1);
  ASSERT_NE(std::setlocale(LC_NUMERIC, "comma"), nullptr);
  ASSERT_EQ(std::strtod("0,5", nullptr), 0.5);
  std::ofstream(folder_ / "blocks.pvd") << "<VTKFile><Collection><DataSet timestep=\"0.25\" file=\"a\"/>"
                                           "<DataSet timestep=\"1e-3\" file=\"b\"/></Collection></VTKFile>";
  EXPECT_EQ(read_collection(folder_, "blocks"), (std::vector{0.25, 1e-3}));
  std::setlocale(LC_NUMERIC, "C");
}

}  // namespace
}  // namespace quoin
