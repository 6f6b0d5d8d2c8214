// Blocks under weight, loads and prescribed velocities against Newton's law, through changes of stages: on the lattice
// and for blocks of any shape. A value that a stage changes goes from old to new by s = 10 x^3 - 15 x^4 + 6 x^5 over
// the ramp.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "../momentum.h"
#include "model/world_results.h"
#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

// Returns the integral of s over the first t seconds of a ramp, in seconds.
double grown(double t, double ramp) {
  const double x = ramp > 0.0 ? std::min(1.0, t / ramp) : 1.0;
  return ramp * x * x * x * x * (2.5 - 3 * x + x * x) + std::max(0.0, t - ramp);
}

struct Kind {
  const char* kernels;
  bool rigid;
};
std::string name_of(const ::testing::TestParamInfo<Kind>& of) {
  return std::string(of.param.kernels) + (of.param.rigid ? "Rigid" : "Zones");
}

std::string block(const std::string& name, const Vec3& lower, const Vec3& size, const std::string& more = "") {
  return fmt::format(
      "[[block]]\nname = \"{}\"\nmaterial = \"stone\"\nbox = {{ lower = [{}, {}, {}], size = [{}, {}, "
      "{}] }}\n{}\n",
      name, lower[0], lower[1], lower[2], size[0], size[1], size[2], more);
}
const Vec3 kCube{0.1, 0.1, 0.1};  // 2 kg of stone
constexpr double kMass = 2.0;

// Returns two blocks at rest that touch, behind the others: the lattice needs a joint.
std::string resting_pair() {
  return block("pillar", {0, 0, 9}, kCube, "fixed = true") + block("neighbour", {0.1, 0, 9}, kCube);
}

// Returns the mean velocity of a block, weighted by mass, m/s.
Vec3 mean_velocity(const Simulation& simulation, int block) {
  if (simulation.large_motion()) return geometry::array(velocity_of(*simulation.large_motion(), block));
  const auto& model = simulation.model();
  const auto velocity = block_velocity(simulation, block);
  Vec3 mean{};
  double mass = 0.0;
  if (model.place[static_cast<std::size_t>(block)].body >= 0) return velocity[0];
  std::size_t node = 0;
  model.for_each_gridpoint(block, [&](std::size_t, double of_node) {
    for (std::size_t c = 0; c < 3; ++c) mean[c] += of_node * velocity[node][c];
    mass += of_node, ++node;
  });
  for (double& v : mean) v /= mass;
  return mean;
}

class ScaledMass : public ::testing::TestWithParam<Kind> {};

// mass_scaling multiplies inertia but not weight: a block with sixteen times the mass falls with g/16 along every axis.
TEST_P(ScaledMass, FallsBySoMuchLess) {
  const std::string zones = GetParam().rigid ? "" : "rigid = false\ndivisions = [2, 1, 1]";
  Simulation simulation(read_scene_text(undamped_stone(GetParam().kernels) + block("falls", {5, 5, 0}, kCube, zones) +
                                            resting_pair() + "[[stage]]\nduration = 1.0\ngravity = [1.0, -9.81, 2.0]\n",
                                        "fall.toml", {"solver.mass_scaling=16"}));
  simulation.advance(50);
  const double t = 50 * simulation.time_step_report().time_step;
  const Vec3 v = mean_velocity(simulation, 0), g{1.0, -9.81, 2.0};
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[c], g[c] / 16 * t, 1e-9 * t) << c;
}

// Stones on springs of k = 1e8 Pa/m times their base area, whose weight acts from the start. They vibrate about m g/k
// for any scaling, here four times slower: y = -(m g/k) (1 - cos w t), w = sqrt(k/16 m). A dozen are congruent, which
// the lattice moves in SIMD groups; one has another shape. Central differences shift the time by half a step. With
// zones stones are softer by 1 %, by the springs of gridpoints inside the face.
TEST_P(ScaledMass, SwingsAboutTheTrueWeightOnItsBase) {
  const std::string zones = GetParam().rigid ? "" : "rigid = false\ndivisions = [1, 2, 1]";
  std::string text = undamped_stone(GetParam().kernels) + block("base", {0, -0.1, 0}, {6, 0.1, 0.1}, "fixed = true");
  for (int i = 0; i < 12; ++i) text += block(fmt::format("stone {}", i), {0.3 * i, 0, 0}, kCube, zones);
  text += block("long", {5, 0, 0}, {0.2, 0.1, 0.1}, zones);
  text += "[[stage]]\nduration = 1.0\ngravity = [0, -9.81, 0]\n";
  Simulation simulation(
      read_scene_text(text, "swing.toml", {"solver.mass_scaling=16", "solver.time_step_fraction=0.1"}));
  const double dt = simulation.time_step_report().time_step, closed = kMass * 9.81 / 1e6;
  const double frequency = std::sqrt(1e6 / (16 * kMass)), quarter = std::numbers::pi / 2 / frequency;
  for (int k = 1; k <= 4; ++k) {
    simulation.advance(std::lround(quarter / dt) / 2);
    const double t = static_cast<double>(simulation.step()) * dt + dt / 2;
    const double expected = -closed * (1 - std::cos(frequency * t));
    for (const int b : {1, 6, 12, 13})
      EXPECT_NEAR(block_displacement(simulation, b)[0][1], expected, (GetParam().rigid ? 5e-3 : 0.03) * 2 * closed)
          << b << " at " << t;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ScaledMass,
                         ::testing::Values(Kind{"lattice", true}, Kind{"lattice", false}, Kind{"general", true},
                                           Kind{"general", false}),
                         name_of);

// ---- Changes of stages ---------------------------------------------------------------------------------------------

struct StageTimes : Observer {
  const Simulation* simulation = nullptr;
  std::map<int, double> begin;  // s
  void on_stage_begin(const Simulation& s, int stage) override { begin.emplace(stage, s.time()); }
};

// A value that changes in every stage over the ramp, integrated from the start to time t.
struct Ramped {
  std::vector<Vec3> value;   // by stage
  std::vector<double> ramp;  // s
  Vec3 before{};             // value before the first stage
  Vec3 integral(const std::map<int, double>& begin, double t) const {
    Vec3 sum{};
    for (std::size_t i = 0; i < value.size(); ++i) {
      const auto from = begin.find(static_cast<int>(i)), next = begin.find(static_cast<int>(i) + 1);
      if (from == begin.end()) break;
      const double lasted = (next == begin.end() ? t : next->second) - from->second, s = grown(lasted, ramp[i]);
      for (std::size_t c = 0; c < 3; ++c)
        sum[c] += s * value[i][c] + (lasted - s) * (i > 0 ? value[i - 1][c] : before[c]);
    }
    return sum;
  }
};

class Stages : public ::testing::TestWithParam<Kind> {};

// Impulses at every time of three stages. Those of a force at the centre and of a pressure fade while those of the next
// stage grow. Gravity changes between stages, and the force of a removed support fades. Also the displacement of a
// stone with one velocity, then another one. All ramps end before the next stage begins. The midpoint sum of a ramp of
// a thousand steps has an error of 1e-7. With automatic large motion the neighbour of the pillar rotates in the second
// stage, which causes a promotion in the middle of the ramp.
TEST_P(Stages, HandOverLoadsDrivesAndSupportsAlongTheirRamps) {
  const std::string zones = GetParam().rigid ? "" : "rigid = false\ndivisions = [1, 1, 1]";
  std::string text = undamped_stone(GetParam().kernels) + block("pushed", {1, 1, 0}, kCube, zones) +
                     block("pressed", {2, 1, 0}, kCube, zones) + block("held", {3, 1, 0}, kCube) +
                     block("driven", {4, 1, 0}, kCube) + resting_pair();
  const std::string pushed = "[[stage.force]]\nblock = \"pushed\"\npoint = [1.05, 1.05, 0.05]\nforce = ";
  const bool promoted = GetParam().kernels == std::string("automatic");
  // Pressure on a block that may turn has blocks of any shape from the start: a force is promoted in its place.
  const auto pressed = [&](const char* normal, int pressure, const char* force) {
    return promoted
               ? fmt::format("[[stage.force]]\nblock = \"pressed\"\npoint = [2.05, 1.05, 0.05]\nforce = {}\n", force)
               : fmt::format("[[stage.pressure]]\nblock = \"pressed\"\nnormal = {}\npressure = {}\n", normal, pressure);
  };
  const std::string held = "[[stage.velocity]]\nblock = \"held\"\nvelocity = [0, 0, 0]\n";
  const std::string driven = "[[stage.velocity]]\nblock = \"driven\"\nvelocity = ";
  text += "[[stage]]\nname = \"one\"\nduration = 0.02\nramp_time = 0.01\ngravity = [1.0, -9.81, 2.0]\n" + pushed +
          "[10, 40, -6]\n" + pressed("[1, 0, 0]", 1000, "[-10, 0, 0]") + held + driven + "[0.3, -0.2, 0.1]\n" +
          "[[stage]]\nname = \"two\"\nduration = 0.03\nramp_time = 0.02\ngravity = [0, -4.0, 3.0]\n" + pushed +
          "[-30, 0, 8]\n[[stage.force]]\nblock = \"neighbour\"\npoint = [0.15, 0.05, 9.05]\nforce = [0, -300, 0]\n" +
          pressed("[0, 1, 0]", 3000, "[0, -30, 0]") + driven + "[0.1, 0.4, 0]\n" +
          "[[stage]]\nname = \"three\"\nduration = 0.03\nramp_time = 0.02\ngravity = [0, 0, 0]\n";
  std::vector<std::string> settings{"solver.time_step_fraction=0.02", "solver.rotation_bound=2e-3",
                                    "contact.cubic_points=false"};  // the motion passes the bound in mid-ramp
  if (GetParam().kernels == std::string("lattice"))
    settings.insert(settings.end(), {"solver.large_motion=never", "solver.past_motion_bound=warn"});
  Simulation simulation(read_scene_text(text, "stages.toml", settings));
  ASSERT_EQ(simulation.large_motion() != nullptr, GetParam().kernels == std::string("general"));
  const double dt = simulation.time_step_report().time_step;
  ASSERT_LT(dt, 5e-5);

  const std::vector<double> ramp{0.01, 0.02, 0.02};
  const Ramped gravity{{{1.0, -9.81, 2.0}, {0, -4.0, 3.0}, {}}, ramp};
  const Ramped push{{{10, 40, -6}, {-30, 0, 8}, {}}, ramp};
  const Ramped press{{{-10, 0, 0}, {0, -30, 0}, {}}, ramp};  // on faces of 0.01 m2
  const Ramped drive{{{0.3, -0.2, 0.1}, {0.1, 0.4, 0}}, ramp};
  StageTimes stages;
  int looks = 0;
  for (bool more = true; more;) {
    more = simulation.run_stage(stages, std::lround(0.003 / dt));
    const double t = simulation.time();
    SCOPED_TRACE(t);
    const Vec3 weight = gravity.integral(stages.begin, t), impulse = push.integral(stages.begin, t),
               pressure = press.integral(stages.begin, t);
    const Vec3 of_pushed = mean_velocity(simulation, 0), of_pressed = mean_velocity(simulation, 1),
               of_held = mean_velocity(simulation, 2), driven_way = block_displacement(simulation, 3)[0];
    const auto second = stages.begin.find(1), third = stages.begin.find(2);
    const Vec3 way = drive.integral(stages.begin, third == stages.begin.end() ? t : third->second);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(of_pushed[c], weight[c] + impulse[c] / kMass, 2e-6) << c;
      EXPECT_NEAR(of_pressed[c], weight[c] + pressure[c] / kMass, 2e-6) << c;
      double fallen = 0.0;  // m; the force of the support, the weight at the end of the first stage, fades over a ramp
      if (second != stages.begin.end()) {
        const double left = second->second, lasted = (third == stages.begin.end() ? t : third->second) - left;
        const Vec3 of_first = gravity.integral({{0, 0.0}}, left);
        fallen = weight[c] - of_first[c] - gravity.value[0][c] * (lasted - grown(lasted, 0.02));
      }
      EXPECT_NEAR(of_held[c], fallen, 2e-6) << c;
      if (third == stages.begin.end()) {
        EXPECT_NEAR(driven_way[c], way[c], 2e-8) << c;
      }
    }
    ++looks;
  }
  ASSERT_EQ(simulation.outcome().promotion.has_value(), promoted);
  if (promoted) {
    const double after = simulation.outcome().promotion->time - stages.begin.at(1);
    EXPECT_TRUE(after > 0.0 && after < 0.02) << after << " s: in the middle of the second ramp";
  }
  EXPECT_GT(looks, 20);  // some in every ramp
  EXPECT_GT(std::abs(mean_velocity(simulation, 0)[0]), 0.1) << "nothing has moved: nothing is tested";
}

INSTANTIATE_TEST_SUITE_P(Kinds, Stages,
                         ::testing::Values(Kind{"lattice", true}, Kind{"automatic", true}, Kind{"general", true},
                                           Kind{"general", false}),
                         name_of);

// Bricks of the lattice with zones have forces of stages by their names, distributed by mass.
TEST(Stages, HandOverForcesOnBricksWithZones) {
  Scene scene = bare_scene(0.1);
  Assembly assembly = brick_grid({2, 1, 1}, {0.2, 0.1, 0.05}, {2, 1, 1});
  assembly.joints.clear();
  assembly.bricks[1].body = "brick";
  const Ramped push{{{30, 5, 0}, {-10, 0, 60}, {}}, {0.0, 0.002, 0.001}};
  for (std::size_t i = 0; i < 3; ++i) {
    Stage& stage = scene.stages.emplace_back();
    stage.name = fmt::format("stage {}", i);
    stage.duration = 0.003, stage.ramp_time = push.ramp[i];
    if (push.value[i] == Vec3{}) continue;
    BodyControl& control = stage.controls.emplace_back();
    control.body = "brick";
    control.kind.fill(DofKind::free);
    control.force = push.value[i];
  }
  Simulation simulation(scene, assembly);
  const double mass = kDensity * 0.2 * 0.1 * 0.05;
  StageTimes stages;
  for (bool more = true; more;) {
    more = simulation.run_stage(stages, 97);
    const Vec3 v = mean_velocity(simulation, 1), impulse = push.integral(stages.begin, simulation.time());
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[c], impulse[c] / mass, 1e-7) << c << " at " << simulation.time();
  }
}

// ---- Loads on blocks that rotate -----------------------------------------------------------------------------------

class TurningBlock : public ::testing::TestWithParam<Kind> {};

// A force of fixed direction at a corner of a free beam. Its work, F times the displacement of that corner, is all the
// energy. The beam rotates by more than a radian in each of two stages with this load, and moves by decimetres. If the
// point of the force did not follow the beam, the error of the work would be tens of percent.
TEST_P(TurningBlock, AForceWorksOnTheWayOfItsPoint) {
  const std::string zones = GetParam().rigid ? "" : "rigid = false\ndivisions = [2, 1, 1]";
  const std::string stage =
      "[[stage]]\nduration = 0.2\n[[stage.force]]\nblock = \"beam\"\npoint = [0.4, 0.1, 0.1]\nforce = [5, 40, -10]\n";
  Simulation simulation(read_scene_text(
      undamped_stone("general") + block("beam", {0, 0, 0}, {0.4, 0.1, 0.1}, zones) + resting_pair() + stage + stage +
          "[output]\nenergy = true\n",
      "beam.toml", {GetParam().rigid ? "solver.time_step_fraction=0.02" : "solver.time_step_fraction=0.4"}));
  const auto corners = block_mesh(simulation, 0).gridpoint;
  std::size_t corner = 0;
  while (std::abs(corners[corner][0] - 0.4) + std::abs(corners[corner][1] - 0.1) + std::abs(corners[corner][2] - 0.1) >
         1e-9)
    ++corner;
  const Vec3 force{5, 40, -10};
  StageTimes stages;
  const double dt = simulation.time_step_report().time_step;
  for (bool more = true; more;) {
    more = simulation.run_stage(stages, 500);
    simulation.advance(1);
    // Energies are those at the time of the forces, a step before.
    const Vec3 moved = block_displacement(simulation, 0)[corner], v = block_velocity(simulation, 0)[corner];
    double work = 0.0;
    for (std::size_t c = 0; c < 3; ++c) work += force[c] * (moved[c] - dt * v[c]);
    const Energies e = *simulation.measure().energies;
    if (simulation.time() > 0.05) {
      EXPECT_NEAR(e.kinetic + e.strain, work, 2e-3 * work) << simulation.time();
    }
  }
  EXPECT_EQ(stages.begin.size(), 2u);
  EXPECT_GT(turned(*simulation.large_motion(), 0), 1.0);
}

// A pressure follows its face. Stage one rotates the block by w t; in stage two it rotates freely under the pressure.
// The velocity of its centre is -p A/m times the integral of the normal.
TEST(SpunBlock, APressureFollowsItsFace) {
  const double spin = 30.0, ramp = 0.02;
  Simulation simulation(read_scene_text(
      undamped_stone("general") + block("spun", {0, 0, 0}, kCube) + resting_pair() +
          "[[stage]]\nduration = 0.05\nramp_time = 0.02\n[[stage.velocity]]\nblock = \"spun\"\nvelocity = [0, 0, 0]\n"
          "omega = [0, 0, 30]\n[[stage]]\nduration = 0.05\n[[stage.pressure]]\nblock = \"spun\"\nnormal = [1, 0, "
          "0]\npressure = 4000\n",
      "spun.toml", {"solver.time_step_fraction=0.02"}));
  StageTimes stages;
  ASSERT_TRUE(simulation.run_stage(stages));
  const double begin = simulation.time(), angle = spin * grown(begin, ramp), push = 4000 * 0.01 / kMass;
  for (bool more = true; more;) {
    more = simulation.run_stage(stages, 100);
    const double t = simulation.time() - begin, now = angle + spin * t;
    const Vec3 v = mean_velocity(simulation, 0);
    // The velocity half a step before includes the forces at the beginnings of all steps until then.
    const double late = push * simulation.time_step_report().time_step;
    EXPECT_NEAR(v[0], -push / spin * (std::sin(now) - std::sin(angle)), late);
    EXPECT_NEAR(v[1], push / spin * (std::cos(now) - std::cos(angle)), late);
    EXPECT_NEAR(v[2], 0.0, 1e-12);
  }
}

// A block has a prescribed rotation about an axis that is not a principal one. Released, it conserves its angular
// momentum and kinetic energy, which the support has supplied. Fixed again, it loses both, and does not rotate after
// the next release.
TEST(SpunBlock, SpinsOnWhereItIsLetGoAndRestsWhereItWasCaught) {
  const std::string hold = "[[stage.velocity]]\nblock = \"spun\"\nvelocity = [0, 0, 0]\nomega = ";
  const std::string stage = "[[stage]]\nduration = 0.02\nramp_time = 0.01\n";
  Simulation simulation(read_scene_text(undamped_stone("general") + block("spun", {0, 0, 0}, {0.1, 0.2, 0.3}) +
                                            resting_pair() + stage + hold + "[10, 20, -15]\n" + stage + stage + hold +
                                            "[0, 0, 0]\n" + stage + "[output]\nenergy = true\n",
                                        "spun.toml", {"solver.time_step_fraction=0.02"}));
  Observer nobody;
  const auto momentum = [&] {
    return angular_momentum(*simulation.large_motion(), position_of(*simulation.large_motion(), 0));
  };
  const auto end_stage = [&] {
    simulation.run_stage(nobody);
    return simulation.measure();
  };
  const double driven = end_stage().energies->kinetic;
  const geometry::Vector given = momentum();
  EXPECT_GT(norm(given), 0.5 * 12 * (0.2 * 0.2 + 0.3 * 0.3) / 12 * 20);
  const HistoryRow free = end_stage();
  EXPECT_LT(norm(momentum() - given), 1e-12 * norm(given));
  const double energy = 0.5 * dot(momentum(), spin_of(*simulation.large_motion(), 0));
  EXPECT_NEAR(driven, 0.0, 1e-12 * energy) << "what is imposed is none";
  EXPECT_NEAR(free.energies->kinetic, energy, 1e-4 * energy);
  EXPECT_NEAR(free.energies->balance_error(), 0.0, 1e-4 * energy);
  const HistoryRow caught = end_stage();
  EXPECT_NEAR(caught.energies->kinetic, 0.0, 1e-12 * energy);
  EXPECT_NEAR(caught.energies->balance_error(), 0.0, 1e-3 * energy);
  EXPECT_NEAR(end_stage().energies->kinetic, 0.0, 1e-12 * energy);
}

INSTANTIATE_TEST_SUITE_P(Kinds, TurningBlock, ::testing::Values(Kind{"general", true}, Kind{"general", false}),
                         name_of);

// ---- Joints in series ----------------------------------------------------------------------------------------------

// A wall of two courses of rigid units between beams, under pressure p. Three joints above each other close by
// p (1/k + 1/k + 1/k'); the outer two are those of the beams.
TEST(PressedWall, GivesByTheSumOfItsJoints) {
  for (const char* kernels : {"lattice", "general"}) {
    Simulation simulation(read_scene_text(fmt::format(R"(
[solver]
kernels = "{}"
[materials.brick]
young_modulus = 1e10
poisson_ratio = 0.2
density = 1900.0
[joints.beds]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 1e9
[joints.beams]
law = "elastic"
normal_stiffness = 4e9
shear_stiffness = 1e9
[wall]
courses = 2
units_per_course = 2
unit = [0.2, 0.1, 0.1]
mid_unit_joints = false
rigid_units = true
unit_material = "brick"
bed_joint = "beds"
head_joint = "beds"
beam_joint = "beams"
[[stage]]
kind = "pressure"
pressure = 0.3e6
equilibrium_ratio = 1e-6
)",
                                                      kernels),
                                          "pressed.toml"));
    Observer nobody;
    simulation.run(nobody);
    const double expected = 0.3e6 * (2 / 4e9 + 1 / 1e9);
    EXPECT_NEAR(simulation.measure().monitor_displacement[1], -expected, 1e-3 * expected) << kernels;
    EXPECT_NEAR(simulation.measure().vertical_force, 0.3e6 * 0.4 * 0.1, 1e-3 * 0.3e6 * 0.04) << kernels;
  }
}

// ---- Collapse ------------------------------------------------------------------------------------------------------

// A pillar 0.1 m wide and 0.4 m high rocks from a quarter of its weight on. A slab beside it on a base of friction 0.1
// has slid by then, by the double integral of (alpha - 0.1) g with alpha = r t. That is r g t^3/6, with t from
// alpha = 0.1. Directions are x, z and one between them.
TEST(CollapseStage, SlipOfTheBaseCountsAlongEveryDirection) {
  const double rate = 0.5;
  for (const auto& [name, direction, x, z] : {std::tuple{"along x", "[1, 0, 0]", 0.1, 0.4},
                                              {"along z", "[0, 0, 1]", 0.4, 0.1},
                                              {"backwards", "[0, 0, -1]", 0.4, 0.1}}) {
    SCOPED_TRACE(name);
    Simulation simulation(read_scene_text(
        "[solver]\ndamping = \"viscous\"\nmass_damping = 0.0\nstiffness_damping = 1e-4\nkernels = \"general\"\n"
        "[materials.stone]\ndensity = 2000.0\nyoung_modulus = 1e9\npoisson_ratio = 0.2\n"
        "[joints.rough]\nlaw = \"coulomb_slip\"\ninitial_state = \"dry\"\nnormal_stiffness = 1e9\nshear_stiffness = "
        "1e9\nfriction_angle = 50.0\n"
        "[joints.slick]\nlaw = \"coulomb_slip\"\ninitial_state = \"dry\"\nnormal_stiffness = 1e9\nshear_stiffness = "
        "1e9\nfriction_angle = 5.710593137499643\n"
        "[[joint_rule]]\nfamily = \"slick\"\nbetween = [\"ground\", \"slab\"]\n[[joint_rule]]\nfamily = \"rough\"\n" +
            block("ground", {-2, -0.1, -2}, {4, 0.1, 4}, "fixed = true") + block("slab", {-1, 0, -1}, {0.4, 0.1, 0.4}) +
            block("pillar", {0, 0, 0}, {x, 0.4, z}) +
            "[[stage]]\nname = \"weight\"\ngravity = [0, -9.81, 0]\nramp_time = 0.05\nduration = 0.1\n"
            "[[stage]]\nname = \"push\"\ngravity = [0, -9.81, 0]\ncollapse = { direction = " +
            direction + fmt::format(", start = 0.05, rate = {}, displacement = 0.2, limit = 1.0 }}\n", rate),
        "slip.toml"));
    struct : Observer {
      double at_uplift = 0.0;
      const Simulation* simulation = nullptr;
      void on_row(const HistoryRow& row) override {
        if (simulation->outcome().base_slip_at_uplift && at_uplift == 0.0) at_uplift = row.multiplier;
      }
    } seen;
    seen.simulation = &simulation;
    simulation.run(seen);
    ASSERT_TRUE(simulation.outcome().base_slip_at_uplift);
    const double slip = *simulation.outcome().base_slip_at_uplift, t = (seen.at_uplift - 0.1) / rate;
    EXPECT_GT(seen.at_uplift, 0.25);
    EXPECT_LT(seen.at_uplift, 0.32) << "a tenth of a millimetre is soon there";
    EXPECT_NEAR(slip, rate * 9.81 * t * t * t / 6, 0.03 * slip);
  }
}

}  // namespace
}  // namespace quoin
