// Joints pulled apart beyond the distance at which the broad phase finds neighbours. Without a strength a joint is a
// spring: N = kn A u at any opening u. A joint that has failed is let go.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "outside.h"

namespace quoin::verification {
namespace {

constexpr double kStiffness = 1e6;  // kn A of the cube, N/m

// The thin base makes the skin 10 mm, and with it the reach 2.5 mm.
std::string cube_on(const std::string& joint, const std::string& of_cube = "", const std::string& contact = "") {
  return "[joints.bed]\nnormal_stiffness = 1e6\nshear_stiffness = 1e6\n" + joint + R"(
[[joint_rule]]
family = "bed"
[[block]]
name = "base"
material = "stone"
fixed = true
box = { lower = [-0.5, -0.2, -0.5], size = [2, 0.2, 2] }
)" + kCube +
         of_cube + "[contact]\n" + contact + "[solver]\nlarge_motion = \"always\"\n";
}
std::string moves(const std::string& motion, double duration) {
  return fmt::format(
      "[[stage]]\nduration = {}\nmonitor = \"cube\"\nrecord_interval = 1\nvelocity = [{{ block = \"cube\", {} }}]\n",
      duration, motion);
}

const std::string kSpring = "law = \"elastic\"\n", kWeakBond = R"(law = "fracture_energy"
tensile_strength = 1e3
cohesion = 2e3
friction_angle = 35.0
fracture_energy_tension = 5.0
fracture_energy_shear = 10.0
)";

// Up by 45 mm, aside by 30 mm, and back along the same way. The work that goes in comes back.
TEST(PulledJoint, WithoutStrengthIsASpringAtAnyOpening) {
  for (const std::string of_cube : {"", "rigid = false\ndivisions = [2, 2, 2]\n"}) {
    const Rows rows = rows_of(cube_on(kSpring, of_cube) + moves("velocity = [0, 0.3, 0]", 0.15) +
                              moves("velocity = [0.3, 0, 0]", 0.1) + moves("velocity = [-0.3, 0, 0]", 0.1) +
                              moves("velocity = [0, -0.3, 0]", 0.15));
    double highest = 0.0;
    for (const HistoryRow& row : rows.all) {
      const Vec3& u = row.monitor_displacement;
      highest = std::max(highest, u[1]);
      // All gridpoints are driven, so the cube stays a cube. Tolerances: rounding of sums of tractions.
      for (int k = 0; k < 2; ++k)
        EXPECT_NEAR(row.reactions[1].force[k], -kStiffness * u[k], 1e-9 * kStiffness * std::abs(u[k]) + 1e-4)
            << of_cube << row.time << " " << k;
      EXPECT_NEAR(row.energies->detection, 0.0, 1e-9);
    }
    EXPECT_GT(highest, 0.04);
    const HistoryRow& last = rows.all.back();
    EXPECT_NEAR(last.energies->balance_error(), 0.0, 1e-6 * kStiffness * highest * highest / 2.0);
  }
}

// The middle of the face goes straight up, and the cube turns: N = kn A u, M = kn I theta. tolerance: share of the
// whole.
void expect_tilted_springs(const std::string& scene, double twist, double tolerance) {
  const Rows rows =
      rows_of(scene + moves(fmt::format("velocity = [-0.05, 0.05, 0], omega = [0, {}, 0.1]", twist), 0.3));
  const HistoryRow& last = rows.all.back();
  const double rise = last.monitor_displacement[1], theta = rise / 0.5;
  const double u = rise + 0.5 * (1.0 - std::cos(theta));  // of the middle of the face
  ASSERT_GT(u + 0.5 * theta, 3.0 * 0.01);
  EXPECT_NEAR(last.reactions[1].force[1], -kStiffness * u, tolerance * kStiffness * u);
  EXPECT_NEAR(last.reactions[1].moment[2], -kStiffness / 12.0 * theta, tolerance * kStiffness / 12.0 * theta);
  EXPECT_NEAR(last.energies->detection, 0.0, tolerance * kStiffness * u * u / 2.0);
}

// The lower edge stays within the reach, where points are placed again. Those that had opened by 20 reaches, 10 mm,
// were left out. 2e-3: the face turns against the normal, by theta^2 of the whole.
TEST(PulledJoint, WithoutStrengthHoldsTheFarSideOfATiltedBlock) {
  expect_tilted_springs(cube_on(kSpring, "", "skin = 0.002\n"), 0.0, 2e-3);
}

// On a face of the same size, turned about the upright axis too, edges cross at the lower rim. A point there took the
// place of all others. 2e-2: the faces overlap by 1 % less when they have turned by 0.013.
TEST(PulledJoint, WithoutStrengthIsHeldByItsFacesWhereEdgesCross) {
  std::string scene = cube_on(kSpring, "", "skin = 0.002\n");
  const std::string wide = "box = { lower = [-0.5, -0.2, -0.5], size = [2, 0.2, 2] }";
  scene.replace(scene.find(wide), wide.size(), "box = { lower = [0, -0.2, 0], size = [1, 0.2, 1] }");
  expect_tilted_springs(scene, 0.04, 2e-2);
}

// Softening has an end, if exponential in double precision alone: a bond of 1 kPa and 5 J/m2 keeps e^-10 at 50 mm.
TEST(PulledJoint, ThatHasFailedIsLetGo) {
  for (const std::string softening : {"", "softening = \"exponential\"\n"}) {
    std::unique_ptr<Simulation> run;
    rows_of(cube_on(kWeakBond + softening) + moves("velocity = [0, 1, 0]", 0.4), &run);
    EXPECT_EQ(run->large_motion()->point_count(), 0u) << softening;
    const Energies& e = run->large_motion()->step_sums.energies;
    EXPECT_NEAR(e.dissipated[0], 5.0, 1e-3) << softening;
    EXPECT_NEAR(e.detection, 0.0, 1e-6) << softening;
  }
}

}  // namespace
}  // namespace quoin::verification
