// Blocks of any shape are bitwise identical for any number of threads, and for both loops of steps.
#include "scene/generate_blocks.h"
#include "scene/read_scene.h"
#include "step/simulation.h"
#include "support.h"

namespace quoin::verification {
namespace {

// A stage without ramp: the loads are constant from the first step on.
const char* const pushed = R"(
[[stage]]
gravity = [3.4, -9.81, 5.9]
duration = 0.3
)";

quoin::Scene collapse(int courses = 8, int units_per_course = 5) {
  return scene_of(stone_and_ground(5e8) + R"(
[[dry_wall]]
name = "wall"
material = "stone"
unit = [0.4, 0.2, 0.2]
)" + "courses = " +
                  std::to_string(courses) + "\nunits_per_course = " + std::to_string(units_per_course) + pushed);
}

quoin::Scene deformable() {
  std::string text = stone_and_ground(5e8);
  for (int column = 0; column < 4; ++column) {
    for (int course = 0; course < 3; ++course) {
      const std::string x = std::to_string(0.4 * column), y = std::to_string(0.2 * course);
      text += "[[block]]\nname = \"b" + std::to_string(column) + "/" + std::to_string(course) +
              "\"\nmaterial = \"stone\"\nrigid = false\ndivisions = [2, 1, 1]\nbox = { lower = [" + x + ", " + y +
              ", 0], size = [0.4, 0.2, 0.2] }\n";
    }
  }
  quoin::Scene scene = scene_of(text + pushed);
  scene.stages[0].duration = 0.05;
  return scene;
}

quoin::Scene arch() {
  quoin::Scene scene = read_scene(QUOIN_SCENES "/arch.toml");
  scene.stages[0].duration = 0.3;
  scene.stages[1].collapse->start = 0.5;  // above the multiplier of collapse
  scene.stages[1].ramp_time = 0.1;
  return scene;
}

void same_at_any_number_of_threads(const quoin::Scene& scene, bool detects) {
  Observer nobody;
  Simulation alone(scene, 1);
  const long at_start = alone.large_motion()->detection.count;
  alone.run(nobody);
  if (detects) {
    EXPECT_GT(alone.large_motion()->detection.count, at_start + 5) << "nothing moves: nothing is tested";
  }
  for (int threads = 2; threads <= 4; ++threads) {
    Simulation shared(scene, threads);
    ASSERT_EQ(shared.thread_count(), threads);
    shared.run(nobody);
    EXPECT_EQ(shared.step(), alone.step()) << threads;
    EXPECT_EQ(shared.hash(), alone.hash()) << threads;
    if (!scene.output.energy) continue;
    EXPECT_NE(alone.measure().energies->detection, 0.0);
    EXPECT_EQ(shared.measure().energies->detection, alone.measure().energies->detection) << threads;
  }
}

TEST(BlockThreads, CollapseWithDetection) { same_at_any_number_of_threads(collapse(), true); }
// So many pairs that threads share each part of a detection: 512 pairs or contact points and more.
TEST(BlockThreads, DetectionOfManyPairs) {
  quoin::Scene scene = collapse(14, 14);
  scene.output.energy = true;
  EXPECT_GT(Simulation(scene).large_motion()->contacts.list.size(), 512);
  same_at_any_number_of_threads(scene, true);
}
TEST(BlockThreads, DeformableBlocks) {
  const quoin::Scene scene = deformable();
  EXPECT_GT(Simulation(scene).zone_count(), 0);
  same_at_any_number_of_threads(scene, false);
}
TEST(BlockThreads, DeformableBlocksUnderDampingByBlock) {
  quoin::Scene scene = deformable();
  scene.solver.damping = DampingKind::block, scene.solver.local_damping = 0.3;
  scene.solver.deformation_inertia = 64.0;
  same_at_any_number_of_threads(scene, false);
}
TEST(BlockThreads, Arch) { same_at_any_number_of_threads(arch(), true); }

// Compares the loop of the model, with one and several threads, with the loop of a simulation.
TEST(BlockThreads, TheModelsLoopIsThatOfASimulation) {
  constexpr long kSteps = 1000;
  for (const quoin::Scene& scene : {collapse(), deformable()}) {
    Simulation simulation(scene, 2);
    simulation.advance(kSteps);
    Model model(blocks::assemble(scene), scene.solver);
    model.set_gravity(geometry::vector(scene.stages[0].gravity));
    run_steps(model, kSteps);
    EXPECT_EQ(model.hash(), simulation.hash());
    EXPECT_EQ(model.stepping.time, simulation.time());

    ThreadPool pool(3);
    Model threaded(blocks::assemble(scene), scene.solver);
    threaded.threads = &pool;
    threaded.set_gravity(geometry::vector(scene.stages[0].gravity));
    run_steps(threaded, kSteps);
    EXPECT_EQ(threaded.hash(), model.hash());
  }
}

}  // namespace
}  // namespace quoin::verification
