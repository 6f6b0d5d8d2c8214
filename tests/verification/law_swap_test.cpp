// Law swaps during runs of blocks of any shape. Tractions do not change by a bit, the run continues, and the energy
// balance includes the reported jump.
#include "step/law_swap.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "model/world_results.h"
#include "scene/read_scene.h"
#include "step/results.h"
#include "step/simulation.h"
#include "support.h"

namespace quoin::verification {
namespace {

struct SwapRecorder : Observer {
  std::vector<LawSwap> swaps;
  std::vector<std::vector<ContactPoint>> at_begin, at_end;
  std::vector<double> balance;   // energy balance at the end of each stage, J
  std::vector<double> least_xi;  // smallest xi at the end of each stage, of all points whose law has one
  std::vector<long> detections;
  void on_stage_begin(const Simulation& s, int) override { at_begin.push_back(contact_points(s)); }
  void on_law_swap(const LawSwap& swap) override { swaps.push_back(swap); }
  void on_stage_end(const Simulation& s, int, const HistoryRow& last) override {
    at_end.push_back(contact_points(s));
    if (last.energies) balance.push_back(last.energies->balance_error());
    const std::vector<double> xi = law_state(s, "xi_t");
    least_xi.push_back(std::ranges::min(xi));
    detections.push_back(s.large_motion()->detection.count);
  }

  // Expects that every stage begins with the tractions at the end of the last one.
  void expect_continuous_tractions() const {
    for (size_t stage = 1; stage < at_begin.size(); ++stage) {
      const auto &before = at_end[stage - 1], &after = at_begin[stage];
      ASSERT_EQ(before.size(), after.size());
      double largest = 0.0;
      for (size_t i = 0; i < before.size(); ++i) {
        for (size_t k = 0; k < 3; ++k) {
          ASSERT_EQ(before[i].traction[k], after[i].traction[k]) << "stage " << stage << ", point " << i;
          largest = std::max(largest, std::abs(before[i].traction[k]));
        }
      }
      EXPECT_GT(largest, 1e2) << "nothing is carried: nothing is tested";
    }
  }
};

// The arch stands under its weight, has three law swaps between two laws, and is pushed until it falls. Dry joints are
// equal in both laws, so it falls at the multiplier without a swap.
TEST(BlockLawSwap, ArchFallsUnderTheSameForceWhicheverLawHoldsItsDryJoints) {
  quoin::Scene scene = read_scene(QUOIN_SCENES "/arch.toml");
  Stage standing = scene.stages[0];
  standing.ramp_time = 0.0, standing.duration = 0.05;
  scene.stages.insert(scene.stages.begin() + 1, 2, standing);
  Simulation unswapped(scene);
  Observer nobody;
  unswapped.run(nobody);

  scene.stages[1].law_swaps["dry"] = "fracture_energy";
  scene.stages[2].law_swaps["dry"] = "coulomb_slip";
  scene.stages[3].law_swaps["dry"] = "fracture_energy";
  Simulation swapped(scene);
  SwapRecorder recorder;
  swapped.run(recorder);
  ASSERT_EQ(recorder.swaps.size(), 3u);
  recorder.expect_continuous_tractions();
  for (const LawSwap& swap : recorder.swaps) {
    EXPECT_EQ(swap.points, 8 * 4);  // points of 8 joints, before hinges open
    EXPECT_EQ(swap.limited, 0);
    EXPECT_GT(swap.stored_before, 0.0);
    EXPECT_LT(std::abs(swap.energy_jump), 1e-9 * swap.stored_before);
  }
  ASSERT_TRUE(swapped.outcome().collapse_multiplier.has_value());
  // The laws have different rounding, which is amplified while the arch falls.
  check("arch, law swapped three times: multiplier as without a swap", *unswapped.outcome().collapse_multiplier,
        *swapped.outcome().collapse_multiplier, 1e-4, "-", "dry joints are the same to both laws");
}

// Returns a wall with law swaps while it overturns and its units slide and rotate on each other, before the first
// impact on the ground. An impact has a balance error of a part of a percent in single steps, for any law.
quoin::Scene falling_wall() {
  constexpr double kOneStep = 1e-6;  // s, less than a step
  const auto stage = [](const char* gravity, double duration, const char* law) {
    std::string text = "[[stage]]\nramp_time = 0.05\n";
    text += "gravity = " + std::string(gravity) + "\nduration = " + std::to_string(duration) + "\n";
    return *law ? text + "law = \"" + law + "\"\n" : text;
  };
  const char *const rest = "[0, -9.81, 0]", *const push = "[3.4, -9.81, 5.9]";
  quoin::Scene scene = scene_of(stone_and_ground(1e10) + R"(
[[dry_wall]]
name = "wall"
material = "stone"
courses = 5
units_per_course = 2.5
unit = [0.4, 0.2, 0.2]
[output]
energy = true
)" + stage(rest, 0.1, "") + stage(push, 0.5, "") +
                                stage(push, kOneStep, "fracture_energy") + stage(push, 0.1, "") +
                                stage(rest, kOneStep, "coulomb_slip") + stage(rest, 0.5, ""));
  scene.solver.time_step_fraction = 0.3;  // error of impacts over m g h: 0.011 at 0.6, 0.0038 at 0.3, 0.0014 at 0.15
  return scene;
}

TEST(BlockLawSwap, FallingWallGoesOnWithItsEnergiesInBalance) {
  const quoin::Scene scene = falling_wall();
  Simulation simulation(scene, 1);
  SwapRecorder recorder;
  simulation.run(recorder);
  ASSERT_EQ(recorder.swaps.size(), 2u);
  recorder.expect_continuous_tractions();
  ASSERT_GT(recorder.detections[3], recorder.detections[1] + 5) << "no points were born: nothing is tested";
  EXPECT_GE(recorder.least_xi[3], 1.0) << "points born after the swap are dry";
  EXPECT_GT(simulation.measure().largest_displacement, 0.5) << "the wall stands";

  const double ground = 1800.0 * 60 * 0.2 * 60, height = 5 * 0.2;
  const double scale = (whole_mass(*simulation.large_motion()) - ground) * gravity * height / 2;
  double jumps = 0.0;
  for (size_t stage = 0; stage < recorder.balance.size(); ++stage) {
    if (stage == 2 || stage == 4) {  // stages of one step after a swap
      const double jump = recorder.swaps[stage / 2 - 1].energy_jump;
      check_error("falling dry wall, step after a swap: energy out of balance / m g h",
                  (recorder.balance[stage] - recorder.balance[stage - 1] - jump) / scale, 1e-4, "-",
                  "less the jump that is reported");
      jumps += jump;
    }
    // bound as for the walls of collapse_test.cpp
    check_error("falling dry wall, stage " + std::to_string(stage) + ": energy from nothing / m g h",
                std::max(0.0, recorder.balance[stage] - jumps) / scale, 1e-2, "-", "less the jumps at swaps");
  }
  Simulation wide(scene, 4);
  Observer nobody;
  wide.run(nobody);
  EXPECT_EQ(wide.hash(), simulation.hash()) << "4 threads have other bits";
}

// A joint in tension that has softened by half has a secant stiffness far below kn. A law without this history
// continues with kn. Without a normal shift its traction would change abruptly in the first step. For joint planes of
// rigid blocks, and for those of triangles of deformable ones.
void softened_joint(const std::string& base) {
  constexpr double kn = 1e10, velocity = 1e-3;
  const quoin::Scene scene = scene_of(R"(
[materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000.0
[joints.mortar]
law = "fracture_energy"
normal_stiffness = 1e10
shear_stiffness = 5e9
tensile_strength = 0.2e6
cohesion = 0.3e6
friction_angle = 35.0
fracture_energy_tension = 10.0
fracture_energy_shear = 50.0
[solver]
kernels = "general"
damping = "none"
[[block]]
name = "base"
material = "stone"
fixed = true
box = { lower = [0, 0, 0], size = [1, 1, 1] }
)" + base + R"(
[[block]]
name = "top"
material = "stone"
box = { lower = [0, 1, 0], size = [1, 1, 1] }
[[stage]]
displacement = 4e-5
monitor = "top"
direction = "y"
[[stage.velocity]]
block = "top"
velocity = [0, 1e-3, 0]
[[stage]]
law = "coulomb_slip"
duration = 1e-9
monitor = "top"
direction = "y"
[[stage.velocity]]
block = "top"
velocity = [0, 1e-3, 0]
[output]
energy = true
)");
  Simulation simulation(scene);
  SwapRecorder recorder;
  simulation.run(recorder);
  ASSERT_EQ(recorder.swaps.size(), 1u);
  const auto &before = recorder.at_end[0], &swapped = recorder.at_begin[1], &after = recorder.at_end[1];
  EXPECT_EQ(recorder.swaps[0].limited, long(before.size())) << "the joint has not softened: nothing is tested";
  double jump = 0.0;
  for (size_t i = 0; i < before.size(); ++i) {
    const double sigma = before[i].traction[0];
    EXPECT_GT(sigma, 0.05e6);
    EXPECT_LT(sigma, 0.15e6);
    EXPECT_EQ(sigma, swapped[i].traction[0]);
    EXPECT_NEAR(swapped[i].jump[0], sigma / kn, 1e-18);
    // The stage has one step, and another step that completes its last row.
    const double opening = 2.0 * velocity * simulation.large_motion()->stepping.dt;
    EXPECT_NEAR(after[i].traction[0] - sigma, kn * opening, 1e-6 * sigma + 0.01 * kn * opening);
    jump += before[i].area * (0.5 * sigma * sigma / kn - 0.5 * sigma * before[i].jump[0]);
  }
  EXPECT_NEAR(recorder.swaps[0].energy_jump, jump, 1e-9 * std::abs(jump));
  // The work of the block with prescribed velocity has an error of kn (v dt)^2 / 2 in a step, by the trapezoidal rule.
  const double step = velocity * simulation.large_motion()->stepping.dt;
  EXPECT_GT(std::abs(jump), 4.0 * kn * step * step) << "whether the jump is booked is not tested";
  EXPECT_NEAR(recorder.balance[1], recorder.balance[0], 2.0 * kn * step * step);
}
TEST(BlockLawSwap, SoftenedJointOnARigidPlaneKeepsItsTraction) { softened_joint(""); }
TEST(BlockLawSwap, SoftenedJointOnADeformablePlaneKeepsItsTraction) {
  softened_joint("rigid = false\ndivisions = [1, 1, 1]");
}

// A block that has not landed yet: contact points that are new after the swap are dry, although initial joints would be
// bonded.
TEST(BlockLawSwap, PointsBornLaterStartDry) {
  const JointFamily mortar = joint("fracture_energy", {{"normal_stiffness", 1e9},
                                                       {"shear_stiffness", 5e8},
                                                       {"tensile_strength", 0.05e6},
                                                       {"cohesion", 0.08e6},
                                                       {"friction_angle", 35},
                                                       {"fracture_energy_tension", 10.0},
                                                       {"fracture_energy_shear", 50.0}});
  JointFamily first = elastic_joint(1e9, 5e8);
  first.initial_state = "bonded";
  Scene scene(first);
  scene.brick({-1, -1, -1}, {3, 1, 3}, true);
  scene.brick({0, 0.02, 0}, {1, 1, 1});
  auto m = scene.model(undamped());
  m->set_gravity({0, -gravity, 0});
  ASSERT_EQ(m->point_count(), 0u);
  m->replace_law(0, successor(mortar, "fracture_energy"), {}, {});
  // The state is checked before the first call of the law, which would break a bond across a gap.
  while (m->point_count() == 0 && m->stepping.time < 0.1) m->step();
  ASSERT_GT(m->point_count(), 0u);
  const Family& f = m->contacts.families[0];
  for (double xi : f.state[size_t(f.material->law().state_index("xi_t"))]) EXPECT_GE(xi, 1.0);
}

// A law four times as stiff halves the time step; a softer one does not change it.
TEST(BlockLawSwap, StifferLawShortensTheStep) {
  Scene scene(elastic_joint(1e9, 5e8));
  scene.brick({0, 0, 0}, {1, 1, 1}, true);
  scene.brick({0, 1, 0}, {1, 1, 1});
  auto m = scene.model(undamped());
  run_steps(*m, 3);
  const double dt = m->stepping.dt;
  const std::vector<double> still(m->point_count(), 0.0);
  m->replace_law(0, successor(elastic_joint(4e9, 2e9), "elastic"), {}, still);
  check("law four times as stiff: time step", 0.5 * dt, m->stepping.dt, 1e-6, "s", "2/omega_max");
  const double shorter = m->stepping.dt;
  m->replace_law(0, successor(elastic_joint(1e9, 5e8), "elastic"), {}, still);
  EXPECT_EQ(m->stepping.dt, shorter);
}

// Viscosity over stiffness is 2 xi/omega, and omega goes with the root of the stiffness. It had stayed that of the old
// law, so that damping was ten times as large. A block that is fixed and freed by a stage lands as any other.
TEST(BlockLawSwap, ImpactDampingIsThatOfTheNewStiffness) {
  for (const bool is_freed : {false, true}) {
    Scene scene(elastic_joint(1e9, 5e8));
    scene.brick({0, 0, 0}, {1, 1, 1}, true);
    scene.brick({0, 1, 0}, {1, 1, 1}, is_freed);
    scene.assembly.blocks.back().freed = is_freed;
    SolverSettings settings;
    settings.damping = DampingKind::impact;
    auto m = scene.model(settings);
    run_steps(*m, 3);
    ASSERT_EQ(m->contacts.list.size(), 1u);
    const std::array<double, 2> before = m->contacts.place[0].viscosity;
    const double share = impact_damping_in_use(*m);
    EXPECT_GT(before[0], 0.0);
    const std::vector<double> still(m->point_count(), 0.0);
    m->replace_law(0, successor(elastic_joint(1e11, 5e10), "elastic"), {}, still);
    for (size_t k = 0; k < 2; ++k) EXPECT_NEAR(m->contacts.place[0].viscosity[k], 0.1 * before[k], 1e-12 * before[k]);
    EXPECT_NEAR(impact_damping_in_use(*m), share, 1e-3) << "all frequencies go with the root of the stiffness";
    m->replace_law(0, successor(elastic_joint(1e9, 5e8), "elastic"), {}, still);
    for (size_t k = 0; k < 2; ++k) EXPECT_NEAR(m->contacts.place[0].viscosity[k], before[k], 1e-12 * before[k]);
  }
}

TEST(BlockLawSwap, RefusedWithTheReason) {
  const auto refusal = [](const std::string& law) {
    quoin::Scene scene = read_scene(QUOIN_SCENES "/arch.toml");
    scene.stages[0].duration = 0.1;
    scene.stages[1].law_swaps["dry"] = law;
    Simulation simulation(scene);
    Observer nobody;
    try {
      simulation.run(nobody);
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::law_refused);
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  EXPECT_NE(refusal("no_such_law").find("no_such_law"), std::string::npos);

  // A swap of elastic joints in tension to a law without tensile strength.
  const quoin::Scene scene = scene_of(R"(
[materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000.0
[joints.glue]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 5e8
[[block]]
name = "ceiling"
material = "stone"
fixed = true
box = { lower = [0, 1, 0], size = [1, 1, 1] }
[[block]]
name = "hanging"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[stage]]
gravity = [0, -9.81, 0]
equilibrium_ratio = 1e-3
[[stage]]
law = "coulomb_slip"
duration = 0.01
)");
  Simulation simulation(scene);
  Observer nobody;
  try {
    simulation.run(nobody);
    FAIL() << "a law without strength took over joints that hang";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::law_refused);
    EXPECT_NE(std::string(error.what()).find("outside the strength"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("'glue'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace quoin::verification
