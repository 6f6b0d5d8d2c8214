// A moving load in a run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes.h"

namespace quoin {
namespace {

using members_cases::box;
using members_cases::head;

// A slab on two narrow feet on springs: the load at x is distributed by the lever rule. Tolerance 2 %, for the rotation
// of feet of 0.1 m on 4 m, and for remaining motion.
TEST(MovingLoad, DividesByTheLever) {
  const double load = 2e4, span = 4.0, weight = 2000.0 * 4.1 * 0.2 * 1.0 * 9.81;
  for (const double x : {0.0, 1.0, 3.0}) {
    const std::string feet =
        box("left", "[-0.05, 0, 0]", "[0.1, 0.2, 1]") + box("right", "[3.95, 0, 0]", "[0.1, 0.2, 1]");
    const auto spring = [](const char* name) {
      return fmt::format("[[spring]]\nname = \"{0}\"\nblock = \"{0}\"\nnormal_stiffness = 1e9\nshear_stiffness = 1e9\n",
                         name);
    };
    std::string scene = head(30.0, 1e11, 20.0) + feet + box("slab", "[-0.05, 0.2, 0]", "[4.1, 0.2, 1]");
    // The base is moved far below; the feet are on springs.
    const std::string base = "box = { lower = [-9, -1, -9]";
    scene.replace(scene.find(base), base.size(), "box = { lower = [-9, -9, -9]");
    scene += spring("left") + spring("right");
    scene += "[[stage]]\ngravity = [0, -9.81, 0]\nramp_time = 0.2\nduration = 0.5\n";
    scene += fmt::format(
        "[[stage]]\ngravity = [0, -9.81, 0]\nramp_time = 0.2\nduration = 2.2\nmoving_load = {{ from = [0, 1, 0.5], to "
        "= [{}, 1, "
        "0.5], force = [0, {}, 0], positions = 5 }}\n",
        x, -load);
    Simulation simulation(read_scene_text(scene, "moving.toml"), 1);
    Observer nobody;
    simulation.run(nobody);
    const members::Members& m = *simulation.large_motion()->held_by.members.get();
    const double left = m.beds()[0].force().y, right = m.beds()[1].force().y;
    const double feet_weigh = 2 * 2000.0 * 0.02 * 9.81;
    EXPECT_NEAR(left + right, load + weight + feet_weigh, 0.005 * load) << x;
    EXPECT_NEAR(right, 0.5 * (weight + feet_weigh) + load * x / span, 0.02 * load) << x;
  }
}

}  // namespace
}  // namespace quoin
