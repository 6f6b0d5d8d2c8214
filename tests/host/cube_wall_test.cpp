// Walls of rigid cubes: courses of bodies with one name, which are moved and measured together.
#include <gtest/gtest.h>

#include <cmath>

#include "scene/read_scene.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

struct Recorder : Observer {
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  std::vector<HistoryRow> rows;
};

Scene cube_wall(int size, const std::vector<std::string>& overrides = {}) {
  Scene scene = read_scene(QUOIN_SCENES "/cube_wall_" + std::to_string(size) + ".toml", overrides);
  scene.output.frames = 0;
  return scene;
}

// Adds stages that move the top course by `displacement` (m) and hold it until equilibrium.
void move_and_hold(Scene* scene, double displacement) {
  Stage hold = scene->stages[0];
  scene->stages[0].displacement = displacement;
  hold.displacement.reset();
  hold.controls[1].velocity = {};
  hold.equilibrium_ratio = 1e-8;
  hold.max_steps = 200000;
  scene->stages.push_back(hold);
}

// Returns the force of the joints on all bodies of a name, N, from the tractions of the contact points.
Vec3 force_on(const Simulation& simulation, const std::string& name) {
  const auto& bricks = simulation.assembly().bricks;
  Vec3 force{};
  for (const ContactPoint& p : contact_points(simulation)) {
    const double sign = (bricks[static_cast<std::size_t>(p.block_a)].body == name ? 1.0 : 0.0) -
                        (bricks[static_cast<std::size_t>(p.block_b)].body == name ? 1.0 : 0.0);
    for (std::size_t c = 0; c < 3; ++c) {
      force[c] += sign * p.area * (p.traction[0] * p.normal[c] + p.traction[1] * p.s[c] + p.traction[2] * p.t[c]);
    }
  }
  return force;
}

TEST(CubeWall, FourPointsAFace) {
  const Scene ten = cube_wall(10), twenty = cube_wall(20);
  const Simulation small(ten, assemble(ten), 1), large(twenty, assemble(twenty), 1);
  EXPECT_EQ(small.model().point_count, 720);
  EXPECT_EQ(large.model().point_count, 3040);
  EXPECT_EQ(small.model().blocks_named("top_course").size(), 10u);
  EXPECT_EQ(large.model().blocks_named("bottom_course").size(), 20u);
  for (const double area : small.model().area) EXPECT_NEAR(area, 0.0025, 1e-15);
}

// One column of n + 1 cubes of edge a, without rotation of both ends: n joints in series, with M = V times the height
// above mid-height. Four points at the corners give a joint the second moment A (a/2)^2. So 1/K = n/(ks A) + sum of
// (height)^2/(kn A a^2/4) = n/(ks A) + n (n^2 - 1)/(3 kn A).
TEST(CubeWall, ColumnHasTheStiffnessOfRigidBlocksInSeries) {
  Scene scene = cube_wall(10, {"wall.units_per_course=1"});
  scene.joints["mortar"] = elastic_family();
  move_and_hold(&scene, 1e-6);
  Simulation simulation(scene, assemble(scene), 1);
  Recorder recorder;
  simulation.run(recorder);
  const HistoryRow& end = recorder.rows.back();
  const double n = 9.0, area = 0.01;
  const double compliance = n / (kShear * area) + n * (n * n - 1.0) / (3.0 * kNormal * area);
  EXPECT_NEAR(end.resistance * compliance / end.monitor_displacement[0], 1.0, 1e-6);
}

// The stiffness of the wall is between that of its separate columns and that of bed joints that only slide.
TEST(CubeWall, ElasticForcesBalanceAndStiffnessIsBounded) {
  Scene scene = cube_wall(10);
  move_and_hold(&scene, 2e-6);
  Simulation simulation(scene, assemble(scene), 2);
  Recorder recorder;
  simulation.run(recorder);
  const HistoryRow& end = recorder.rows.back();
  const double area = 0.1, n = 9.0, stiffness = end.resistance / end.monitor_displacement[0];
  EXPECT_LT(stiffness, kShear * area / n);
  EXPECT_GT(stiffness, area / (n / kShear + n * (n * n - 1.0) / (3.0 * kNormal)));

  const Vec3 top = force_on(simulation, "top_course"), bottom = force_on(simulation, "bottom_course");
  EXPECT_NEAR(-top[0], end.resistance, 1e-6 * end.resistance);
  EXPECT_NEAR(bottom[0], end.resistance, 1e-6 * end.resistance);
  EXPECT_NEAR(top[1], 0.0, 1e-6 * end.resistance);
  EXPECT_NEAR(bottom[1], 0.0, 1e-6 * end.resistance);
}

TEST(CubeWall, SoftensAndClosesItsEnergyBalance) {
  Scene scene = cube_wall(10);
  scene.output.energy = true;
  Simulation simulation(scene, assemble(scene), 1);
  Recorder recorder;
  simulation.run(recorder);
  double peak = 0.0;
  for (const HistoryRow& row : recorder.rows) peak = std::max(peak, row.resistance);
  EXPECT_GT(peak, 10e3);
  EXPECT_LT(recorder.rows.back().resistance, 0.4 * peak);
  const Energies e = *recorder.rows.back().energies;
  EXPECT_GT(e.dissipated[0], 0.1 * e.external);
  EXPECT_LT(std::abs(e.balance_error()), 1e-4 * e.external);
}

}  // namespace
}  // namespace quoin
