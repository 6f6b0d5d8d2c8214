// Block scenes: reader, generators and stages.

#include <cmath>
#include <complex>
#include <limits>

#include "../scratch.h"
#include "base/error.h"
#include "model/world_results.h"
#include "scene/generate_blocks.h"
#include "scene/read_scene.h"
#include "step/simulation.h"
#include "support.h"

namespace quoin::verification {
namespace {

std::string with_stone(const std::string& body) {
  return R"(
[materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 5e8
friction_angle = 35.0
)" + body;
}
void run_through(Simulation& simulation) {
  Observer nobody;
  simulation.run(nobody);
}

const char* const rest_stage = R"(
[[stage]]
gravity = [0.0, -9.81, 0.0]
ramp_time = 0.05
duration = 0.1
)";

TEST(BlockScenes, EveryShapeAndGenerator) {
  const Scratch scratch;
  scratch.file(
      "wedge.off",
      "OFF\n6 5 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 1\n0 1 1\n3 0 2 1\n3 3 4 5\n4 0 1 4 3\n4 1 2 5 4\n4 2 0 3 5\n");
  const std::string text = with_stone(R"(
[[block]]
name = "box"
material = "stone"
fixed = true
box = { lower = [-10, -1, -10], size = [40, 1, 40] }
[[block]]
name = "hull"
material = "stone"
vertices = [[0,0,0],[1,0,0],[0,1,0],[0,0,1]]
position = [0, 0.0, -4]
[[block]]
name = "mesh"
material = "stone"
mesh = "wedge.off"
rotation = [-90, 0, 0]
position = [4, 0, -4]
[[block]]
name = "soft"
material = "stone"
rigid = false
zone_edge = 0.5
box = { lower = [8, 0, -4], size = [1, 1, 1] }
[[arch]]
material = "stone"
centre = [10, 0.1, 5]
radius = 2.0
thickness = 0.4
depth = 0.5
voussoirs = 11
[[dry_wall]]
name = "long"
material = "stone"
courses = 6
units_per_course = 5
unit = [0.4, 0.2, 0.2]
trim_start = [0.0, 0.2]
[[dry_wall.opening]]
from = 0.8
to = 1.4
sill = 0.2
head = 0.8
bearing = 0.2
[[dry_wall]]
name = "cross"
material = "stone"
courses = 6
units_per_course = 4
unit = [0.4, 0.2, 0.2]
origin = [0.2, 0, 0]
direction = 90
trim_start = [0.2, 0.0]
[[joint_rule]]
family = "none"
between = ["hull", "mesh"]
)" + std::string(rest_stage));
  Simulation run(read_scene(scratch.file("scene.toml", text)));
  const blocks::Assembly& a = run.large_motion()->assembly;
  double wall = 0.0, expected = 0.0;
  for (size_t i = 0; i < a.blocks.size(); ++i) {
    if (a.blocks[i].name.starts_with("long") || a.blocks[i].name.starts_with("cross")) {
      wall += geometry::mass_properties(a.shapes[a.blocks[i].shape]).volume;
    }
  }
  // two walls, with the corner counted once, less the opening (0.6 x 0.6)
  expected = (2.0 * 1.2 + 1.6 * 1.2 - 0.2 * 1.2 - 0.36) * 0.2;
  EXPECT_NEAR(wall, expected, 1e-9);
  EXPECT_EQ(find_blocks(a, "arch/5", "test").size(), 1u);
  EXPECT_THROW(find_blocks(a, "arch/55", "test"), Error);
  run_through(run);
  // the free hull, wedge and soft block rest on the floor; the corner does not separate
  EXPECT_LT(run.measure().largest_displacement, 0.02);
}

TEST(BlockScenes, FaultsAreLocated) {
  const std::string faulty = with_stone(R"(
[[block]]
name = "a"
material = "ston"
box = { lower = [0, 0, 0], size = [1, -1, 1] }
wieght = 3
[[dry_wall]]
material = "stone"
courses = 0
units_per_course = 2.3
unit = [0.4, 0.2, 0.2]
[[stage]]
gravity = [0, -9.81, 0]
)");
  try {
    scene_of(faulty);
    FAIL();
  } catch (const Error& e) {
    const std::string text = e.what();
    for (const char* part : {"did you mean 'stone'", "block.1.box.size", "wieght", "dry_wall.1.courses",
                             "a multiple of 0.5", "never ends"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
    }
  }
  const std::string concave = with_stone(R"(
[[block]]
name = "flat"
material = "stone"
vertices = [[0,0,0],[1,0,0],[0,1,0],[1,1,0]]
)" + std::string(rest_stage));
  try {
    Simulation run(scene_of(concave));
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("block flat: its vertices lie in one plane"), std::string::npos) << e.what();
  }
}

// Two blocks without contacts, so that no contact law detects a position that is not finite.
const char* const two_free_blocks = R"(
[[block]]
name = "here"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[block]]
name = "there"
material = "stone"
box = { lower = [5, 0, 0], size = [1, 1, 1] }
[output]
picture = false
)";

std::string failure(const std::function<void()>& action, Exit code) {
  try {
    action();
  } catch (const Error& e) {
    EXPECT_EQ(e.exit_code, code) << e.what();
    return e.what();
  }
  return "no failure";
}

void expect_words(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " in\n" << text;
}

TEST(BlockScenes, ABlockThatIsNowhereEndsTheRun) {
  const double nowhere[] = {NAN, INFINITY, -INFINITY};
  for (double wrong : nowhere) {
    const quoin::Scene scene = scene_of(with_stone(two_free_blocks + std::string(rest_stage)));
    Model m(blocks::assemble(scene), scene.solver);
    run_steps(m, 3);
    body_of(m, 1).v.y = wrong;
    expect_words(failure([&] { m.step(); }, Exit::numerical),
                 {"block #1 'there', (5.5, 0.5, 0.5) m at the start", "no finite number at step 4"});
  }
  Simulation spinning(scene_of(with_stone(two_free_blocks + std::string(R"(
[[stage]]
duration = 0.1
[[stage.velocity]]
block = "there"
velocity = [0, 0, 0]
omega = [0, 1e300, 0]
)"))));
  expect_words(failure([&] { run_through(spinning); }, Exit::numerical),
               {"block #1 'there'", "no finite number at step 1"});
  // of deformable blocks, gridpoints
  std::string soft = two_free_blocks;
  soft.replace(soft.rfind("material"), 0, "rigid = false\nzone_edge = 1.0\n");
  const quoin::Scene scene = scene_of(with_stone(soft + rest_stage));
  Model m(blocks::assemble(scene), scene.solver);
  run_steps(m, 3);
  change_node_velocities(m)[2].z = NAN;
  expect_words(failure([&] { m.step(); }, Exit::numerical), {"block #1 'there'", "no finite number at step 4"});
}

// The message has the point that the law has failed: its jumps are finite, but their traction is not.
TEST(BlockScenes, AFailedContactPointIsNamedWithItsPlace) {
  std::string three = R"(
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-1, -1, 0], size = [9, 1, 1] }
)";
  for (const char* x : {"0", "2", "4"})
    three += std::string("[[block]]\nname = \"at ") + x + "\"\nmaterial = \"stone\"\nbox = { lower = [" + x +
             ", 0, 0], size = [1, 1, 1] }\n";
  const quoin::Scene scene = scene_of(with_stone(three + rest_stage));
  Model m(blocks::assemble(scene), scene.solver);
  run_steps(m, 3);
  body_of(m, 2).x.y = -1e300;
  expect_words(failure([&] { m.step(); }, Exit::numerical),
               {"law 'coulomb_slip' failed at 4 of 12 points at step 3", "joint family 'dry'", "#0 'ground'",
                "#2 'at 2'", "opening -1e+300 m", "time_step_fraction than"});
}

TEST(BlockScenes, HistoriesHoldFiniteNumbers) {
  // Positions stay finite, but the square of the velocity does not.
  std::string stage = rest_stage;
  stage.replace(stage.find("-9.81"), 5, "-1e200");
  Simulation run(scene_of(with_stone(two_free_blocks + stage)));
  expect_words(failure([&] { run_through(run); }, Exit::numerical), {"stage 'stage'", "step", "no finite number"});
}

TEST(BlockScenes, ModelsStartSomewhere) {
  const quoin::Scene scene = scene_of(with_stone(two_free_blocks + std::string(rest_stage)));
  const auto refused = [&](const std::function<void(blocks::Assembly&)>& spoil) {
    blocks::Assembly a = blocks::assemble(scene);
    spoil(a);
    return failure([&] { Model(a, scene.solver); }, Exit::bad_input);
  };
  expect_words(refused([](blocks::Assembly& a) {
                 a.blocks[1].orientation = geometry::rotation({1e300, 0, 0});
               }),
               {"block #1 'there'", "its place is no finite number", "rotation"});
  expect_words(refused([](blocks::Assembly& a) { a.blocks[1].position.y = NAN; }), {"block #1 'there'", "position"});
  expect_words(refused([](blocks::Assembly& a) {
                 a.materials[0].density = 1.7e308, a.shapes[0] = geometry::box({}, {9, 9, 9});
               }),
               {"block #0 'here'", "mass inf kg"});
  expect_words(refused([](blocks::Assembly& a) { a.materials[0].density = 0.0; }), {"density 0 kg/m3", "must be > 0"});
  EXPECT_EQ(refused([](blocks::Assembly&) {}), "no failure");
  Model m(blocks::assemble(scene), scene.solver);
  for (const int face : {-1, 6}) {
    blocks::Pressure pressure;
    pressure.block = 1, pressure.face = face;
    expect_words(failure([&] { m.add(pressure); }, Exit::bad_input),
                 {"block #1 'there'", "does not exist; there are faces 0 to 5"});
  }
}

TEST(BlockScenes, ALoadOnOneOfTwoBlocksOfTheSameNameIsRefused) {
  std::string twins = two_free_blocks;
  twins.replace(twins.find("there"), 5, "here");
  const std::string load = "[[stage.force]]\nblock = \"here\"\npoint = [0, 0, 0]\nforce = [1, 0, 0]\n";
  expect_words(failure([&] { Simulation run(scene_of(with_stone(twins + rest_stage + load))); }, Exit::bad_input),
               {"blocks #0 and #1 are both called 'here'"});
  EXPECT_NO_THROW(Simulation(scene_of(with_stone(twins + rest_stage))));
}

TEST(BlockScenes, BlocksHaveNoMoreZonesThanMemory) {
  for (const char* zones : {"zone_edge = 1e-9", "divisions = [200, 200, 200]"}) {
    std::string soft = two_free_blocks;
    soft.replace(soft.rfind("material"), 0, "rigid = false\n" + std::string(zones) + "\n");
    expect_words(failure([&] { Simulation run(scene_of(with_stone(soft + rest_stage))); }, Exit::bad_input),
                 {"block #1 'there'", "zones, more than 1e+07"});
  }
}

// Ground motion: a stiff block bonded to the ground follows it; the ground velocity is the integral of the record.
TEST(BlockScenes, GroundMotionIsIntegratedExactly) {
  const std::string text = with_stone(R"(
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-5, -0.2, -5], size = [10, 0.2, 10] }
[[block]]
name = "block"
material = "stone"
box = { lower = [0, 0, 0], size = [0.5, 0.1, 0.5] }
[solver]
damping = "viscous"
mass_damping = 0.0
stiffness_damping = 1e-4
[[stage]]
gravity = [0.0, -9.81, 0.0]
ramp_time = 0.05
duration = 0.1
[[stage]]
duration = 0.5
ground_motion = { direction = [1, 0, 0], time = [0.0, 0.1, 0.2, 0.3], acceleration = [0.0, 2.0, -2.0, 0.0] }
[output]
monitor = "block"
)");
  Simulation run(scene_of(text));
  struct Recorder : Observer {
    Curve ground{"ground"}, block{"block"};
    void on_row(const HistoryRow& row) override {
      if (row.stage == 0) return;
      ground.add(row.time - 0.1, 1e3 * row.ground_displacement[0]);
      block.add(row.time - 0.1, 1e3 * row.monitor_displacement[0]);
    }
  } recorder;
  run.run(recorder);
  // Double integral of the record: each of its corners begins a linear part, whose double integral is cubic.
  const auto moved = [](double t) {
    const auto ramp = [t](double from) { return std::pow(std::max(0.0, t - from), 3) / 6; };
    return 20 * ramp(0) - 60 * ramp(0.1) + 60 * ramp(0.2) - 20 * ramp(0.3);
  };
  write_figure("ground_motion", "time, s", "displacement, mm",
               {reference("double integral of the record", 0, 0.5, [&](double t) { return 1e3 * moved(t); }),
                recorder.ground, recorder.block});
  // double integral of the triangle pair: 0 to 0.1: a = 20 t; 0.1 to 0.2: 2 - 40 (t - 0.1); 0.2 to 0.3: -2 + 20 (t -
  // 0.2)
  const double expected =
      0.02 / 6 + (0.1 * 0.1 + 2 * 0.005 - 40 * 0.001 / 6) + (0.1 * 0.1 - 2 * 0.005 + 20 * 0.001 / 6);
  check("ground motion: displacement after the record", expected, position_of(*run.large_motion(), 0).x, 1e-3, "m",
        "exact integral of the record");
  check("ground motion: the block rides along", expected, position_of(*run.large_motion(), 1).x - 0.25, 2e-3, "m");
}

// Returns the smallest horizontal body force, over weight, of all mechanisms of three links with four hinges at edges
// of joints (kinematic theorem). The x-y plane is that of complex numbers.
double arch_multiplier(const ArchSpec& arch) {
  using Point = std::complex<double>;
  const int n = arch.voussoirs;
  const double to_radians = pi / 180, radii[2] = {arch.radius - arch.thickness / 2, arch.radius + arch.thickness / 2};
  const auto edge = [&](int joint, int side) {
    return std::polar(radii[side],
                      to_radians * (arch.angles[0] + (arch.angles[1] - arch.angles[0]) * double(joint) / n));
  };
  const auto turned = [](Point a, Point b) { return a.real() * b.imag() - a.imag() * b.real(); };
  std::vector<Point> centroids;  // of the voussoirs, which have equal areas
  for (int i = 0; i < n; ++i) {
    const Point a = edge(i, 0), b = edge(i, 1), c = edge(i + 1, 1), d = edge(i + 1, 0);
    const double abc = turned(b - a, c - a), acd = turned(c - a, d - a);
    centroids.push_back((abc * (a + b + c) + acd * (a + c + d)) / (3.0 * (abc + acd)));
  }
  double least = std::numeric_limits<double>::infinity();
  const auto try_hinges = [&](const std::array<int, 4>& joint, int sides) {
    std::array<Point, 4> hinge;
    for (int h = 0; h < 4; ++h) hinge[h] = edge(joint[h], sides >> h & 1);
    // The first and the last link rotate about their outer hinges, the middle one about the intersection of their
    // lines.
    const Point first = hinge[1] - hinge[0], last = hinge[2] - hinge[3];
    const double parallel = turned(first, last);
    if (std::abs(parallel) < 1e-9 * arch.radius * arch.radius) return;
    const Point meet = hinge[0] + turned(hinge[3] - hinge[0], last) / parallel * first;
    const Point centre[3] = {hinge[0], meet, hinge[3]};
    double spin[3] = {1, 0, 0};
    spin[1] = ((hinge[1] - hinge[0]) / (hinge[1] - meet)).real();
    spin[2] = spin[1] * ((hinge[2] - meet) / (hinge[2] - hinge[3])).real();
    double along = 0, up = 0;  // sums of the velocities
    for (int link = 0; link < 3; ++link) {
      for (int i = joint[link]; i < joint[link + 1]; ++i) {
        const Point velocity = Point(0, spin[link]) * (centroids[i] - centre[link]);
        along += velocity.real(), up += velocity.imag();
      }
    }
    const double way = along > 0 ? 1 : -1;
    for (int h = 0; h < 4; ++h) {  // a joint that rotates about its outer edge opens at the inner one, and vice versa
      const double opening = (h < 3 ? spin[h] : 0.0) - (h > 0 ? spin[h - 1] : 0.0);
      if (way * opening * ((sides >> h & 1) != 0 ? -1 : 1) < 0) return;
    }
    if (up / along > 0) least = std::min(least, up / along);
  };
  for (int a = 0; a <= n; ++a)
    for (int b = a + 1; b <= n; ++b)
      for (int c = b + 1; c <= n; ++c)
        for (int d = c + 1; d <= n; ++d)
          for (int sides = 0; sides < 16; ++sides) try_hinges({a, b, c, d}, sides);
  return least;
}

// The shipped arch; Oppenheim (1992) has 0.37.
TEST(BlockScenes, ArchFallsAtTheMultiplierOfLimitAnalysis) {
  const quoin::Scene scene = read_scene(QUOIN_SCENES "/arch.toml");
  const double expected = arch_multiplier(scene.blocks->arches.at(0));
  EXPECT_NEAR(expected, 0.37, 0.005);
  Simulation run(scene);
  struct Recorder : Observer {
    Curve push{"measured, 0.001 /s"};
    void on_row(const HistoryRow& row) override {
      // There are many rows before the collapse and few during it.
      const double way = 1e3 * row.largest_displacement;
      if (row.multiplier < 0.35) return;
      if (push.points.empty() || way > push.points.back()[0] + 5 || row.multiplier > push.points.back()[1] + 2e-4)
        push.add(way, row.multiplier);
    }
  } recorder;
  run.run(recorder);
  const Outcome& outcome = run.outcome();
  write_figure(
      "arch_multiplier", "largest displacement of a voussoir, mm", "multiplier of the horizontal force, -",
      {{"four hinges, limit analysis", CurveKind::reference, {{0, expected}, {600, expected}}}, recorder.push});
  ASSERT_TRUE(outcome.collapse_multiplier.has_value());
  // Not below; above by the growth of the multiplier in the 2 or 3 s in which the falling arch moves by 0.6 m.
  EXPECT_GT(*outcome.collapse_multiplier, expected);
  check("arch of Oppenheim, 7 voussoirs: multiplier, 0.001 /s", expected, *outcome.collapse_multiplier, 0.01, "-",
        "four hinges, by enumeration");
}

}  // namespace
}  // namespace quoin::verification
