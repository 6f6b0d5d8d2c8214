// A scene with permuted axes has the same results. All vectors of the scene change from x, y, z to y, z, x or z, x, y,
// and so do all results. Kernels and results must treat all axes equally, except for the order of floating-point sums.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scene/read_scene.h"
#include "step/results.h"
#include "step/simulation.h"

namespace quoin {
namespace {

// Returns v with permuted axes: component c becomes component (c + turns) % 3.
Vec3 turned(const Vec3& v, std::size_t turns) {
  Vec3 w{};
  for (std::size_t c = 0; c < 3; ++c) w[(c + turns) % 3] = v[c];
  return w;
}

struct Case {
  const char* name;
  const char* solver;
  bool rigid;
  double rounding;  // tolerance relative to the largest value of a kind
  enum { askew, one_axis, to_and_fro } drive = askew;
};

std::string text(const Vec3& v, std::size_t turns) {
  const Vec3 w = turned(v, turns);
  return fmt::format("[{}, {}, {}]", w[0], w[1], w[2]);
}

// Returns two blocks beside each other and one on top, which has a pressure and an oblique force. All lengths differ.
std::string scene_text(const Case& of, std::size_t turns) {
  std::string toml = fmt::format(R"(
[solver]
{}
[materials.stone]
young_modulus = 5e9
poisson_ratio = 0.2
density = 2000.0
[joints.mortar]
law = "fracture_energy"
normal_stiffness = 8e9
shear_stiffness = 4e9
tensile_strength = 0.05e6
cohesion = 0.1e6
friction_angle = 35.0
compressive_strength = 5e6
fracture_energy_tension = 5.0
fracture_energy_shear = 50.0
fracture_energy_compression = 8000.0
)",
                                 of.solver);
  const auto block = [&](const char* name, const Vec3& lower, const Vec3& size, const Vec3& divisions, bool fixed) {
    toml += fmt::format("[[block]]\nname = \"{}\"\nmaterial = \"stone\"\nbox = {{ lower = {}, size = {} }}\n", name,
                        text(lower, turns), text(size, turns));
    if (fixed) toml += "fixed = true\n";
    if (divisions[0] > 0 && !of.rigid) toml += "rigid = false\ndivisions = " + text(divisions, turns) + "\n";
  };
  block("ground", {-0.1, -0.1, 0.0}, {0.8, 0.1, 0.15}, {}, true);
  block("left", {0.0, 0.0, 0.0}, {0.3, 0.2, 0.15}, {3, 2, 1}, false);
  block("right", {0.3, 0.0, 0.0}, {0.3, 0.2, 0.15}, {3, 2, 1}, false);
  block("top", {0.1, 0.2, 0.0}, {0.4, 0.1, 0.15}, {}, false);
  // The vertical axis is free; one or both of the others have prescribed velocities.
  std::array<std::string, 3> velocity;
  for (std::size_t c = 0; c < 3; ++c)
    velocity[(c + turns) % 3] = std::array{of.drive == Case::to_and_fro ? "0.0" : "0.01", "\"free\"",
                                           of.drive == Case::one_axis     ? "\"free\""
                                           : of.drive == Case::to_and_fro ? "0.0"
                                                                          : "0.006"}[c];
  toml += fmt::format(
      "[[stage]]\nname = \"push\"\n{}gravity = {}\n"
      "[[stage.pressure]]\nblock = \"top\"\nnormal = {}\npressure = 0.1e6\n"
      "[[stage.velocity]]\nblock = \"top\"\nvelocity = [{}]\n[output]\nenergy = true\nmonitor = \"top\"\n",
      of.drive == Case::to_and_fro
          ? fmt::format("kind = \"cycles\"\nblock = \"top\"\ndirection = \"{}\"\namplitudes = [1e-4]\ncycles = [1]\n"
                        "cycle_velocity = 0.01\n",
                        "xyz"[turns])
          : "duration = 0.02\n",
      text({0.3, -9.81, 0.7}, turns), text({0, 1, 0}, turns), fmt::join(velocity, ", "));
  return toml;
}

class Turned : public ::testing::TestWithParam<Case> {};

// Tolerances. The time step, by Lanczos, differs by 1e-15 on the lattice and by up to 3e-7 elsewhere; cracks amplify
// differences. Local damping depends on the sign of every velocity, also of those that are only rounding errors.
constexpr double kSmooth = 1e-6, kOfStep = 1e-4, kOfSigns = 5e-3;

TEST_P(Turned, NamesOfAxesChangeNothing) {
  const double rounding = GetParam().rounding;
  const auto run = [](std::size_t turns) {
    auto simulation = std::make_unique<Simulation>(read_scene_text(scene_text(GetParam(), turns), "turned.toml"));
    Observer nobody;
    simulation->run(nobody);
    return simulation;
  };
  const auto straight = run(0);
  const auto points = contact_points(*straight);
  ASSERT_GE(points.size(), 20u);
  ASSERT_LT(condition_counts(*straight)[static_cast<std::size_t>(Condition::elastic)], straight->point_count())
      << "nothing cracked";
  for (const std::size_t turns : {1u, 2u}) {
    SCOPED_TRACE(turns);
    const auto askew = run(turns);
    ASSERT_EQ(askew->step(), straight->step());

    const HistoryRow a = straight->measure(), b = askew->measure();
    ASSERT_TRUE(a.energies && b.energies);
    EXPECT_NEAR(b.kinetic_energy, a.kinetic_energy, rounding * a.energies->external);
    const auto all = [](const Energies& e) {
      return std::array{e.kinetic,       e.strain,        e.contact_stored, e.dissipated[0], e.dissipated[1],
                        e.dissipated[2], e.dissipated[3], e.external,       e.damping};
    };
    const auto ea = all(*a.energies), eb = all(*b.energies);
    for (std::size_t k = 0; k < ea.size(); ++k) EXPECT_NEAR(eb[k], ea[k], rounding * a.energies->external) << k;
    if (rounding < kOfSigns) {
      EXPECT_NEAR(b.unbalanced_ratio, a.unbalanced_ratio, rounding);
      EXPECT_EQ(condition_counts(*askew), condition_counts(*straight));
    }

    const auto near = [&](const Vec3& was, const Vec3& is, double largest) {
      const Vec3 expected = turned(was, turns);
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(is[c], expected[c], rounding * largest);
    };
    near(a.monitor_displacement, b.monitor_displacement, 1e-3);
    near(a.joint_force, b.joint_force, 1e4);
    // dynamic_force is along the direction of the cycles.
    if (GetParam().drive == Case::to_and_fro) {
      EXPECT_NE(a.dynamic_force, 0.0);
      EXPECT_NEAR(b.dynamic_force, a.dynamic_force, rounding * 1e4);
      EXPECT_NEAR(b.resistance, a.resistance, rounding * 1e4);
      EXPECT_NEAR(b.displacement, a.displacement, rounding * 1e-3);
    }
    for (int i = 0; i < straight->block_count(); ++i) {
      const auto ma = block_mesh(*straight, i), mb = block_mesh(*askew, i);
      const auto ua = block_displacement(*straight, i), ub = block_displacement(*askew, i);
      const auto va = block_velocity(*straight, i), vb = block_velocity(*askew, i);
      ASSERT_EQ(ma.gridpoint.size(), mb.gridpoint.size());
      for (std::size_t g = 0; g < ma.gridpoint.size(); ++g) {
        const Vec3 place = turned(ma.gridpoint[g], turns);
        const auto same = std::find_if(mb.gridpoint.begin(), mb.gridpoint.end(), [&](const Vec3& x) {
          return std::abs(x[0] - place[0]) + std::abs(x[1] - place[1]) + std::abs(x[2] - place[2]) < 1e-9;
        });
        ASSERT_NE(same, mb.gridpoint.end());
        const auto h = static_cast<std::size_t>(same - mb.gridpoint.begin());
        near(ua[g], ub[h], 1e-3);
        near(va[g], vb[h], 1.0);
      }
      // The numbering of zones differs, so values that do not depend on their order are compared.
      Vec3 normal_a{}, normal_b{}, shear_a{}, shear_b{};
      for (const auto& s : block_stress(*straight, i))
        for (std::size_t c = 0; c < 3; ++c)
          normal_a[c] += s[c], shear_a[c] += s[3 + (c + 1) % 3];  // the one without axis c
      for (const auto& s : block_stress(*askew, i))
        for (std::size_t c = 0; c < 3; ++c) normal_b[c] += s[c], shear_b[c] += s[3 + (c + 1) % 3];
      near(normal_a, normal_b, 1e7);
      near(shear_a, shear_b, 1e7);
    }
    const auto others = contact_points(*askew);
    ASSERT_EQ(others.size(), points.size());
    for (const ContactPoint& p : points) {
      const Vec3 place = turned(p.position, turns), normal = turned(p.normal, turns);
      const auto apart = [&](const ContactPoint& q) {  // points of other joints are far
        double sum = 0.0, along = 0.0;
        for (std::size_t c = 0; c < 3; ++c) sum += std::abs(q.position[c] - place[c]), along += q.normal[c] * normal[c];
        return std::abs(along) > 0.999 && q.block_a + q.block_b == p.block_a + p.block_b ? sum : 1.0;
      };
      const auto same =
          std::min_element(others.begin(), others.end(),
                           [&](const ContactPoint& q, const ContactPoint& r) { return apart(q) < apart(r); });
      near(p.position, same->position, 1e-3);  // as displacements
      EXPECT_NEAR(same->area, p.area, 1e-12);
      EXPECT_NEAR(same->traction[0], p.traction[0], rounding * 1e6);
      EXPECT_NEAR(same->jump[0], p.jump[0], rounding * 1e-3);
      EXPECT_NEAR(std::hypot(same->traction[1], same->traction[2]), std::hypot(p.traction[1], p.traction[2]),
                  rounding * 1e6);
      if (rounding < kOfSigns) {
        EXPECT_EQ(same->condition, p.condition);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kernels, Turned,
    ::testing::Values(
        Case{"LatticeOfBricks", "damping = \"local\"\nkernels = \"lattice\"", false, kOfSigns},
        Case{"LatticeOfRigidBricks", "damping = \"local\"\nkernels = \"lattice\"", true, kOfSigns},
        Case{"LatticeByBlock", "damping = \"block\"\ndeformation_inertia = 10.0\nkernels = \"lattice\"", false,
             kOfSigns},
        Case{"LatticeViscous",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"lattice\"", false,
             kSmooth},
        Case{"LatticeRigidViscous",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"lattice\"", true,
             kSmooth},
        Case{"GeneralZones", "damping = \"local\"\nkernels = \"general\"", false, kOfSigns},
        Case{"GeneralZonesByBlock", "damping = \"block\"\ndeformation_inertia = 10.0\nkernels = \"general\"", false,
             kOfSigns},
        Case{"GeneralViscous",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"general\"", false,
             kOfStep},
        Case{"GeneralRigidViscous",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"general\"", true,
             kSmooth},
        Case{"LatticeZonesOneAxis",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"lattice\"", false,
             kSmooth, Case::one_axis},
        Case{"LatticeRigidOneAxis",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"lattice\"", true,
             kSmooth, Case::one_axis},
        Case{"GeneralZonesOneAxis",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"general\"", false,
             kOfStep, Case::one_axis},
        Case{"GeneralRigidOneAxis",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"general\"", true,
             kSmooth, Case::one_axis},
        Case{"LatticeZonesCycles",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"lattice\"", false,
             kSmooth, Case::to_and_fro},
        Case{"LatticeRigidCycles",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"lattice\"", true,
             kSmooth, Case::to_and_fro},
        Case{"GeneralZonesCycles",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"general\"", false,
             kOfStep, Case::to_and_fro},
        Case{"GeneralRigidCycles",
             "damping = \"viscous\"\nmass_damping = 20.0\nstiffness_damping = 1e-6\nkernels = \"general\"", true,
             kSmooth, Case::to_and_fro},
        Case{"GeneralRigid", "damping = \"local\"\nkernels = \"general\"", true, kOfSigns}),
    [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace quoin
