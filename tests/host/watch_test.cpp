// Values that a run monitors besides its results, and the shapes of blocks in pictures.
#include "step/watch.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scene/read_scene.h"
#include "step/findings.h"
#include "step/results.h"
#include "step/simulation.h"

namespace quoin {
namespace {

// Returns a stone of 0.4 x 0.2 x 0.3 m on the ground, with elastic joints so soft that a load of 10 kN closes them by
// millimetres.
std::string stone(const std::string& solver, const std::string& of_stone, const std::string& stage) {
  return "[solver]\ndamping = \"viscous\"\nmass_damping = 50.0\n" + solver + R"(
[materials.stone]
density = 2000.0
young_modulus = 5e9
poisson_ratio = 0.2
[joints.soft]
law = "elastic"
normal_stiffness = 5e7
shear_stiffness = 2e7
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-0.1, -0.1, 0], size = [0.6, 0.1, 0.3] }
[[block]]
name = "stone"
material = "stone"
box = { lower = [0, 0, 0], size = [0.4, 0.2, 0.3] }
)" + of_stone +
         "\n[[stage]]\nname = \"press\"\nduration = 0.1\n" + stage;
}

// A load at each corner in turn, so that the deepest contact point is at each of them. The lattice has loads at the
// centre only.
TEST(Watch, SeesTheDeepestContactPointAndItsPlace) {
  std::vector<double> overlap;
  for (const auto& [x, z] : {std::pair{0.05, 0.05}, {0.35, 0.05}, {0.05, 0.25}, {0.35, 0.25}}) {
    SCOPED_TRACE(fmt::format("{} {}", x, z));
    Simulation simulation(read_scene_text(
        stone("kernels = \"general\"", "",
              fmt::format("[[stage.force]]\nblock = \"stone\"\npoint = [{}, 0.2, {}]\nforce = [0, -10e3, 0]\n", x, z)),
        "stone.toml", {"contact.cubic_points=false"}));
    Observer nobody;
    simulation.run(nobody);
    const auto points = contact_points(simulation);
    ASSERT_EQ(points.size(), 4u);
    const auto deepest = std::min_element(points.begin(), points.end(),
                                          [](const auto& a, const auto& b) { return a.jump[0] < b.jump[0]; });
    EXPECT_GT(-deepest->jump[0], 1e-3) << "nothing is pressed";
    EXPECT_EQ(deepest->position[0] < 0.2, x < 0.2);
    EXPECT_EQ(deepest->position[2] < 0.15, z < 0.15);
    // Largest overlap of all rows. The load acts from the start, so the block vibrates beyond its final position.
    EXPECT_GE(watch_of(simulation).overlap, -deepest->jump[0]);
    EXPECT_LT(watch_of(simulation).overlap, -2.2 * deepest->jump[0]);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(watch_of(simulation).overlap_at[c], deepest->position[c], 0.01) << c;
    overlap.push_back(watch_of(simulation).overlap);
  }
  // The four loads are mirror images of each other.
  for (const double one : overlap) EXPECT_NEAR(one, overlap[0], 1e-6 * overlap[0]);
}

// Overlap F / (kn A) of a joint of 0.4 x 0.3 m, below and above the bound of 5 % of the ground's 0.1 m. The load grows
// slowly, so vibration adds at most 2 %.
TEST(Watch, OverlapIsToldFromAFivePercentOfTheLeastExtentOn) {
  for (const char* kernels : {"lattice", "general"}) {
    for (const double share : {0.9, 1.1}) {
      SCOPED_TRACE(fmt::format("{} {}", kernels, share));
      const double overlap = share * 0.05 * 0.1;
      Simulation simulation(read_scene_text(
          stone(fmt::format("kernels = \"{}\"", kernels), "",
                fmt::format("ramp_time = 0.08\n[[stage.force]]\nblock = \"stone\"\npoint = [0.2, 0.1, 0.15]\nforce = "
                            "[0, {}, 0]\n",
                            -overlap * 5e7 * 0.4 * 0.3)),
          "stone.toml"));
      Observer nobody;
      simulation.run(nobody);
      EXPECT_NEAR(allowed_overlap(simulation), 0.05 * 0.1, 1e-15);
      EXPECT_NEAR(watch_of(simulation).overlap, overlap, 0.02 * overlap);
      const auto& warnings = simulation.outcome().warnings;
      EXPECT_EQ(std::count_if(warnings.begin(), warnings.end(),
                              [](const Warning& w) { return w.about == "interpenetration"; }),
                share > 1 ? 1 : 0);
    }
  }
}

// The energy balance is checked in a few of some thousand steps, although energies are not requested.
TEST(Watch, EnergiesOfSomeStepsAreLookedAt) {
  const auto missing = [](const std::string& solver, const std::string& of_stone) {
    Simulation simulation(read_scene_text(
        stone(solver, of_stone, "gravity = [0, -9.81, 0]\nramp_time = 0.02\n") + "[output]\nrecord_interval = 10\n",
        "stone.toml"));
    Observer nobody;
    simulation.run(nobody);
    EXPECT_GT(simulation.step(), 400);
    EXPECT_GT(watch_of(simulation).energy_moved, 0.0);
    return std::abs(watch_of(simulation).energy_missing) / watch_of(simulation).energy_moved;
  };
  // Two neighbouring steps of central differences balance to rounding, except for terms half a step apart.
  EXPECT_LT(missing("kernels = \"lattice\"", "rigid = false\ndivisions = [2, 1, 2]"), 0.01);
}

// The faces of a box, counter-clockwise from outside, enclose it. The sum of x . n dA over them is three times its
// volume, and that of n dA is 0.
TEST(BlockMesh, FacesEncloseTheBlock) {
  for (const char* kernels : {"lattice", "general"}) {
    for (const char* of_stone : {"", "rigid = false\ndivisions = [3, 2, 1]"}) {
      SCOPED_TRACE(std::string(kernels) + " " + of_stone);
      const Simulation simulation(read_scene_text(
          stone(fmt::format("kernels = \"{}\"", kernels), of_stone, "gravity = [0, -9.81, 0]\n"), "stone.toml"));
      const BlockMesh mesh = block_mesh(simulation, 1);
      ASSERT_EQ(mesh.face.size(), 6u);
      double volume = 0.0, area = 0.0;
      Vec3 sum{};
      for (const std::vector<int>& face : mesh.face) {
        ASSERT_EQ(face.size(), 4u);
        const auto& x = mesh.gridpoint;
        const Vec3 &a = x[static_cast<std::size_t>(face[0])], &b = x[static_cast<std::size_t>(face[1])],
                   &c = x[static_cast<std::size_t>(face[2])], &d = x[static_cast<std::size_t>(face[3])];
        Vec3 normal{};  // half the cross product of the diagonals; its length is the area of the rectangle
        for (std::size_t k = 0; k < 3; ++k) {
          const std::size_t m = (k + 1) % 3, n = (k + 2) % 3;
          normal[k] = 0.5 * ((c[m] - a[m]) * (d[n] - b[n]) - (c[n] - a[n]) * (d[m] - b[m]));
        }
        area += std::hypot(normal[0], normal[1], normal[2]);
        for (std::size_t k = 0; k < 3; ++k)
          sum[k] += normal[k], volume += 0.25 * (a[k] + b[k] + c[k] + d[k]) * normal[k] / 3;
      }
      EXPECT_NEAR(volume, 0.4 * 0.2 * 0.3, 1e-12);
      EXPECT_NEAR(area, 2 * (0.4 * 0.2 + 0.2 * 0.3 + 0.3 * 0.4), 1e-12);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(sum[k], 0.0, 1e-12);
      double of_zones = 0.0;
      for (const auto& zone : mesh.zone) {
        Vec3 e[3];
        for (std::size_t k = 0; k < 3; ++k)
          for (std::size_t c = 0; c < 3; ++c)
            e[k][c] = mesh.gridpoint[static_cast<std::size_t>(zone[k + 1])][c] -
                      mesh.gridpoint[static_cast<std::size_t>(zone[0])][c];
        for (std::size_t k = 0; k < 3; ++k)
          of_zones += e[0][k] * (e[1][(k + 1) % 3] * e[2][(k + 2) % 3] - e[1][(k + 2) % 3] * e[2][(k + 1) % 3]) / 6;
      }
      EXPECT_NEAR(of_zones, *of_stone ? 0.4 * 0.2 * 0.3 : 0.0, 1e-12);
    }
  }
}

}  // namespace
}  // namespace quoin
