// The size of frames, told before there is one, beside the files of one.
#include <gtest/gtest.h>

#include "folder.h"
#include "results/vtk.h"
#include "scene/read_scene.h"

namespace quoin {
namespace {

class Frames : public InFolder {};

TEST_F(Frames, AreAsLargeAsWasTold) {
  for (const auto& [scene, setting] : {std::pair{"solid_wall_030", "wall.courses=4"},
                                       {"cube_wall_10", "wall.courses=4"},
                                       {"arch", "output.frames=1"},
                                       {"solid_wall_030_blocks", "dry_wall.1.courses=4"}}) {
    const Simulation simulation(read_scene(std::string(QUOIN_SCENES) + "/" + scene + ".toml", {setting}));
    const Surfaces surfaces(simulation);
    VtkSeries(folder_, surfaces).add_frame(simulation);
    const double bytes = static_cast<double>(std::filesystem::file_size(folder_ / "blocks_0000.vtu") +
                                             std::filesystem::file_size(folder_ / "joints_0000.vtu"));
    // Never too little. 10 kB are set aside for the heads of the two files, of which some 5 kB are used, and every
    // state of a law counts, though some are not kept: one or two of some 40 numbers a point.
    EXPECT_GE(frame_bytes(simulation, surfaces), bytes) << scene;
    EXPECT_LE(frame_bytes(simulation, surfaces), 1.05 * bytes + 8000.0) << scene;
  }
}

}  // namespace
}  // namespace quoin
