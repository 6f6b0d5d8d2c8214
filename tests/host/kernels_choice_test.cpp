// Choice of kernels for a scene. Blocks that fit the lattice are recognised as bricks; their bricks, joints and results
// are bitwise identical to those of a [wall]. Messages name blocks that do not fit.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "../scene_of_text.h"
#include "base/error.h"
#include "base/input_file.h"
#include "geometry/zoning.h"
#include "model/brick_template.h"
#include "model/motion.h"
#include "scene/actions/action.h"
#include "scene/generate.h"
#include "scene/generate_blocks.h"
#include "scene/read_scene.h"
#include "scene/to_bricks.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

using ::testing::HasSubstr;

std::string list(const auto& values) { return fmt::format("[{}, {}, {}]", values[0], values[1], values[2]); }

// Returns bricks as a list of [[block]] at their positions; names: one for each brick.
std::string as_list_of_blocks(const Assembly& assembly, const std::vector<std::string>& names,
                              const std::set<std::string>& fixed) {
  std::string text;
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) {
    const Brick& brick = assembly.bricks[i];
    text += fmt::format(
        "[[block]]\nname = \"{}\"\nmaterial = \"{}\"\nposition = {}\nbox = {{ lower = [0, 0, 0], size = {} }}\n",
        names[i], assembly.materials[static_cast<std::size_t>(brick.material)].name, list(brick.origin),
        list(brick.size));
    if (fixed.contains(names[i])) text += "fixed = true\n";
    if (!brick.rigid)
      text += fmt::format("rigid = false\ndivisions = {}\nunit = \"{}\"\n", list(brick.zones), brick.unit);
  }
  return text;
}

constexpr const char* kSteel = "[materials.beam]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7850.0\n";

// Returns solid_wall_030.toml with its [wall] as a list of blocks and its stages with keys of blocks.
std::string solid_wall_as_blocks() {
  const std::string file = QUOIN_SCENES "/solid_wall_030.toml", text = read_input_file(file);
  const Scene wall = read_scene(file);
  const Assembly assembly = assemble(wall);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i)
    names.push_back(assembly.bricks[i].body.empty() ? fmt::format("half/{}", i) : assembly.bricks[i].body);
  const double force = wall.stages[0].controls[1].force[1];
  return text.substr(0, text.find("\n[wall]")) + "\n" + kSteel +
         "[solver]\nkernels = \"lattice\"\nquality = \"standard\"\n" +
         as_list_of_blocks(assembly, names, {"bottom_beam"}) + R"(
[[joint_rule]]
family = "unit"
inside_units = true
[[joint_rule]]
family = "mortar"
[[stage]]
name = "precompression"
ramp_time = 0.005
equilibrium_ratio = 1e-3
max_steps = 1000000
monitor = "top_beam"
[[stage.velocity]]
block = "top_beam"
velocity = [0, "free", 0]
[[stage.force]]
block = "top_beam"
point = [0.495, 1.05, 0.05]
force = [0, )" +
         fmt::format("{}", force) +
         R"(, 0]
[[stage]]
name = "shear"
ramp_time = 0.05
monitor = "top_beam"
displacement = 0.005
[[stage.velocity]]
block = "top_beam"
velocity = [0.02, 0, 0]
[output]
energy = false
)";
}

// Returns cube_wall_10.toml as a list of blocks, in which each cube of the outer courses has its own name.
std::string cube_wall_as_blocks() {
  const std::string file = QUOIN_SCENES "/cube_wall_10.toml", text = read_input_file(file);
  const Assembly assembly = assemble(read_scene(file));
  std::vector<std::string> names;
  std::string drives;
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) {
    names.push_back(fmt::format("cube/{}", i));
    if (const std::string& body = assembly.bricks[i].body; !body.empty())
      drives += fmt::format("[[stage.velocity]]\nblock = \"{}\"\nvelocity = {}\n", names.back(),
                            body == "top_course" ? "[0.01, \"free\", 0]" : "[0, 0, 0]");
  }
  std::string head = text.substr(0, text.find("\n[wall]"));
  head.replace(head.find("[materials.cube]"), 16, "[materials.cube]\nyoung_modulus = 1e10\npoisson_ratio = 0.2");
  return head + "\n" + as_list_of_blocks(assembly, names, {}) +
         "[contact]\ncubic_points = false\n[[stage]]\nname = \"shear\"\nramp_time = 0.02\nmonitor = "
         "\"cube/99\"\ndisplacement = 0.001\n" +
         drives + "[output]\nenergy = false\n";
}

// Stops at the first row of the last stage after the given number of steps.
struct Stopper : Observer {
  explicit Stopper(long steps_in) : steps(steps_in) {}
  void on_stage_begin(const Simulation& s, int) override { start = s.step(); }
  void on_row(const HistoryRow& row) override {
    rows.push_back(row);
    if (row.stage == last && row.step - start >= steps) simulation->request_stop();
  }
  Simulation* simulation = nullptr;
  int last = 0;
  long steps, start = 0;
  std::vector<HistoryRow> rows;
};

Stopper run_for(Simulation& simulation, long steps) {
  Stopper stopper(steps);
  stopper.simulation = &simulation;
  stopper.last = static_cast<int>(simulation.scene().stages.size()) - 1;
  try {
    simulation.run(stopper);
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::interrupted) << error.what();
  }
  return stopper;
}

void expect_same_brick(const Brick& a, const Brick& b, double tolerance) {
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(a.origin[c], b.origin[c], tolerance);
    EXPECT_NEAR(a.size[c], b.size[c], tolerance);
  }
  EXPECT_EQ(a.rigid, b.rigid);
  EXPECT_EQ(a.beam, b.beam);
  EXPECT_EQ(a.body, b.body);
  if (a.rigid || b.rigid) return;
  EXPECT_EQ(a.zones, b.zones);
  EXPECT_EQ(a.parity, b.parity);
}

// Expects equal bricks and joints. shift: brick i of b is brick (i + shift) mod n of a.
void expect_same_assembly(const Assembly& a, const Assembly& b, std::size_t shift, double tolerance) {
  const std::size_t n = b.bricks.size();
  ASSERT_EQ(a.bricks.size(), n);
  const auto of_a = [&](int i) { return static_cast<int>((static_cast<std::size_t>(i) + shift) % n); };
  std::map<int, int> unit;
  for (int i = 0; i < static_cast<int>(n); ++i) {
    const Brick &x = a.bricks[static_cast<std::size_t>(of_a(i))], &y = b.bricks[static_cast<std::size_t>(i)];
    expect_same_brick(x, y, tolerance);
    if (!x.rigid) {
      EXPECT_EQ(unit.try_emplace(y.unit, x.unit).first->second, x.unit) << "brick " << i;
    }
  }
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t j = 0; j < a.joints.size(); ++j) {
    EXPECT_EQ(a.joints[j].block_a, of_a(b.joints[j].block_a)) << "joint " << j;
    EXPECT_EQ(a.joints[j].block_b, of_a(b.joints[j].block_b)) << "joint " << j;
    EXPECT_EQ(a.joints[j].face_a, b.joints[j].face_a) << "joint " << j;
    EXPECT_EQ(a.families[static_cast<std::size_t>(a.joints[j].family)].name,
              b.families[static_cast<std::size_t>(b.joints[j].family)].name)
        << "joint " << j;
  }
}

// A wall as a list of blocks is bitwise identical to the [wall].
TEST(KernelsChoice, ListOfBlocksIsTheWallItself) {
  Simulation wall(read_scene(QUOIN_SCENES "/solid_wall_030.toml", {"output.frames=0"}));
  Simulation blocks(scene_of_text(solid_wall_as_blocks(), {"output.frames=0"}));
  ASSERT_FALSE(blocks.large_motion());
  expect_same_assembly(blocks.assembly(), wall.assembly(), 0, 0.0);
  const Stopper a = run_for(wall, 500), b = run_for(blocks, 500);
  EXPECT_EQ(blocks.step(), wall.step());
  EXPECT_EQ(blocks.hash(), wall.hash());
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t i = 0; i < a.rows.size(); ++i) EXPECT_EQ(a.rows[i].resistance, b.rows[i].resistance);
  EXPECT_GT(a.rows.back().resistance, 100.0);
  // A column that histories of walls do not have: its largest displacement is that of the top beam.
  EXPECT_NEAR(b.rows.back().largest_displacement, norm(geometry::vector(b.rows.back().monitor_displacement)), 2e-6);
}

// The shipped scene, in which beams are first and coordinates are sums.
TEST(KernelsChoice, DryWallOfZonedHalfUnitsIsTheWallItself) {
  Simulation wall(read_scene(QUOIN_SCENES "/solid_wall_030.toml", {"output.frames=0"}));
  Simulation blocks(read_scene(QUOIN_SCENES "/solid_wall_030_blocks.toml", {"output.frames=0"}));
  ASSERT_FALSE(blocks.large_motion());
  expect_same_assembly(blocks.assembly(), wall.assembly(), 2, 1e-12);
  const Stopper a = run_for(wall, 500), b = run_for(blocks, 500);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  // The tolerance is for rounding of coordinates.
  EXPECT_NEAR(b.rows.back().resistance, a.rows.back().resistance, 1e-9 * a.rows.back().resistance);
  EXPECT_NEAR(b.rows.back().vertical_force, a.rows.back().vertical_force, 1e-9 * a.rows.back().vertical_force);
}

// Cubes with equal controls move in SIMD groups; the monitored one moves alone. Sums in another order differ by
// rounding, which cracks amplify to 2e-9 at the end.
TEST(KernelsChoice, ListOfCubesMovesInRigidLanes) {
  Simulation wall(read_scene(QUOIN_SCENES "/cube_wall_10.toml", {"output.frames=0"}));
  Simulation blocks(scene_of_text(cube_wall_as_blocks(), {"solver.kernels=lattice", "output.frames=0"}));
  ASSERT_FALSE(blocks.large_motion());
  EXPECT_EQ(blocks.point_count(), wall.point_count());
  EXPECT_EQ(blocks.model().lone_bodies.size(), 1u);
  long in_lanes = 0;
  for (const BodyGroup& group : blocks.model().body_groups) in_lanes += group.body_count;
  EXPECT_EQ(in_lanes, 99);

  run_for(wall, 1000), run_for(blocks, 1000);
  ASSERT_EQ(blocks.step(), wall.step());
  std::map<std::array<int, 5>, Vec3> traction;
  const auto key = [](const ContactPoint& p) {
    const auto mm = [](double x) { return static_cast<int>(std::lround(1e4 * x)); };
    return std::array{mm(p.position[0]), mm(p.position[1]), mm(p.position[2]), p.block_a, p.block_b};
  };
  double largest = 0.0;
  for (const ContactPoint& p : contact_points(wall)) {
    traction[key(p)] = p.traction;
    for (const double x : p.traction) largest = std::max(largest, std::abs(x));
  }
  EXPECT_GT(largest, 1e3);
  for (const ContactPoint& p : contact_points(blocks)) {
    ASSERT_TRUE(traction.contains(key(p)));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(p.traction[c], traction[key(p)][c], 1e-7 * largest);
  }
}

// Scenes that fit the lattice use it by default; arches and panels with crossing joints do not fit.
TEST(KernelsChoice, GeometryChooses) {
  EXPECT_FALSE(choose_motion(scene_of_text(cube_wall_as_blocks())).shapes);
  for (const char* scene : {"arch", "ferris_tin_loi_1", "ferris_tin_loi_2"})
    EXPECT_TRUE(choose_motion(read_scene(fmt::format("{}/{}.toml", QUOIN_SCENES, scene))).shapes) << scene;
}

// Corners of a tetrahedron, as a set, whose order has no meaning; coordinates in micrometres.
using Tetrahedron = std::set<std::array<long, 3>>;
std::array<long, 3> in_micrometres(const Vec3& p) {
  return {std::lround(p[0] * 1e6), std::lround(p[1] * 1e6), std::lround(p[2] * 1e6)};
}

// A brick rotated by right angles has the tetrahedra of the block, for any of its corners as the lowest one.
TEST(KernelsChoice, BrickHasTheZonesOfTheTurnedBlock) {
  int patterns = 0;
  for (const geometry::Vector& turn : std::vector<geometry::Vector>{{},
                                                                    {0, M_PI_2, 0},
                                                                    {0, M_PI, 0},
                                                                    {0, -M_PI_2, 0},
                                                                    {M_PI_2, 0, 0},
                                                                    {M_PI, 0, 0},
                                                                    {0, 0, M_PI_2},
                                                                    {0, 0, M_PI}}) {
    for (const int parity : {0, 1}) {
      blocks::Assembly assembly;
      assembly.materials = {brick_material()};
      blocks::Block block;
      block.rigid = false, block.divisions = {3, 2, 1}, block.parity = parity;
      block.position = {1.0, 2.0, 3.0}, block.orientation = geometry::rotation(turn);
      assembly.add(geometry::box({0.1, 0.2, 0.3}, {0.3, 0.2, 0.4}), block);
      const std::optional<Brick> brick = blocks::as_brick(assembly, 0);
      ASSERT_TRUE(brick);
      patterns += brick->parity;

      const geometry::Zoning zoning = geometry::make_brick_zones(assembly.shapes[0], block.divisions, parity, "");
      std::set<Tetrahedron> of_block, of_brick;
      for (const auto& zone : zoning.zones) {
        Tetrahedron corners;
        for (const int node : zone)
          corners.insert(in_micrometres(geometry::array(
              block.position + matrix(block.orientation) * zoning.nodes[static_cast<std::size_t>(node)])));
        of_block.insert(corners);
      }
      const BrickTemplate made = make_brick_template(*brick, assembly.materials[0]);
      for (const Zone& zone : made.zone) {
        Tetrahedron corners;
        for (const int node : zone.node) {
          Vec3 p = made.node[static_cast<std::size_t>(node)];
          for (std::size_t c = 0; c < 3; ++c) p[c] += brick->origin[c];
          corners.insert(in_micrometres(p));
        }
        of_brick.insert(corners);
      }
      EXPECT_EQ(of_block, of_brick) << turn.x << " " << turn.y << " " << turn.z << " parity " << parity;
    }
  }
  EXPECT_GT(patterns, 0);
  EXPECT_LT(patterns, 16);
}

constexpr const char* kTwoBlocks = R"(
[solver]
kernels = "lattice"
[materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000
[joints.dry]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 1e9
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [0, -1, 0], size = [1, 1, 1] }
[[block]]
name = "stone"
material = "stone"
position = [0, 0, 0]
box = { lower = [0, 0, 0], size = [1, 0.5, 1] }
[[block]]
name = "soft"
material = "stone"
rigid = false
divisions = [2, 1, 2]
box = { lower = [0, 0.5, 0], size = [1, 0.5, 1] }
[[stage]]
gravity = [0, -9.81, 0]
duration = 0.01
)";

std::string refusal(const std::vector<std::string>& overrides, const std::string& more = "") {
  try {
    choose_motion(scene_of_text(kTwoBlocks + more, overrides));
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::bad_input);
    return error.what();
  }
  return "accepted";
}

TEST(KernelsChoice, WhatDoesNotFitIsNamed) {
  ASSERT_EQ(refusal({}), "accepted");
  const auto reason = [](const std::string& override) { return refusal({override}); };
  EXPECT_THAT(reason("block.stone.rotation=[0, 0, 1]"), HasSubstr("block #1 'stone' is no box along the axes"));
  EXPECT_THAT(reason("block.stone.position=[0, 1e-4, 0]"),
              HasSubstr("blocks #0 'ground' and #1 'stone' stand 0.0001 m apart"));
  EXPECT_THAT(reason("block.stone.position=[0, -0.01, 0]"), HasSubstr("overlap by 0.01 m"));
  EXPECT_THAT(reason("block.stone.position=[0.3, 0, 0]"), HasSubstr("ends between two gridpoints of #2 'soft'"));
  EXPECT_THAT(reason("block.soft.fixed=true"), HasSubstr("'soft' is fixed and deformable"));
  EXPECT_THAT(reason("stage.1.collapse={}"), HasSubstr("pushes until collapse"));
  EXPECT_THAT(reason("stage.1.ground_motion={direction=[1,0,0],time=[0,1],acceleration=[0,1]}"),
              HasSubstr("moves the ground"));
  EXPECT_THAT(reason("stage.1.solver={damping=\"block\"}"), HasSubstr("has damping by block of its own"));
  EXPECT_THAT(reason("stage.1.solver={damping=\"impact\",maxwell_damping=0.02}"), HasSubstr("has maxwell_damping"));
  EXPECT_THAT(reason("stage.1.monitor=soft"), HasSubstr("watches 'soft', a deformable block"));
  EXPECT_THAT(reason("stage.1.monitor=sotf"), HasSubstr("did you mean 'soft'?"));
  EXPECT_THAT(reason("stage.1.force=[{block=\"soft\",point=[0,1,0],force=[1,0,0]}]"), HasSubstr("pushes 'soft'"));
  EXPECT_THAT(reason("stage.1.force=[{block=\"stone\",point=[0,0.3,0],force=[1,0,0]}]"),
              HasSubstr("pushes 'stone', which may turn, beside its centre"));
  EXPECT_THAT(reason("stage.1.force=[{block=\"stone\",point=[0.5,0.5,0.5],force=[0,-1,0]}]"),
              HasSubstr("pushes 'stone', which may turn, beside its centre"));
  EXPECT_THAT(reason("stage.1.pressure=[{block=\"stone\",normal=[0,1,0],pressure=10}]"),
              HasSubstr("presses a face of 'stone', which may turn"));
  EXPECT_THAT(reason("stage.1.velocity=[{block=\"stone\",velocity=[0,0,0],omega=[0,0,1]}]"),
              HasSubstr("turns 'stone'"));
  EXPECT_THAT(reason("contact.small_displacement=0"), HasSubstr("more than 0 with solver.kernels = \"lattice\""));
  EXPECT_THAT(reason("solver.large_motion=always"), HasSubstr("solver.kernels = 'lattice'"));
  EXPECT_THAT(reason("contact.point_spacing=0.2"), HasSubstr("contact.point_spacing"));
  // Zones of 1/2 m on zones of 1/3 m: only the ends of the blocks coincide.
  EXPECT_THAT(refusal({}, R"(
[[block]]
name = "other"
material = "stone"
rigid = false
divisions = [3, 1, 2]
box = { lower = [0, 1, 0], size = [1, 0.5, 1] }
)"),
              HasSubstr("have zones of 0.5 and 0.3333 m in their joint"));
  // Blocks beside each other along each horizontal axis, with an offset of half the height of a zone.
  for (const char* lower : {"[1, 0.75, 0]", "[0, 0.75, 1]"}) {
    EXPECT_THAT(refusal({}, fmt::format("[[block]]\nname = \"beside\"\nmaterial = \"stone\"\n"
                                        "box = {{ lower = {}, size = [1, 0.5, 1] }}\n",
                                        lower)),
                HasSubstr("blocks #2 'soft' and #3 'beside' ends between two gridpoints of #2 'soft'"));
  }
  // Settings that the general kernels do not have.
  EXPECT_THAT(refusal({"solver.kernels=general", "solver.damping=block", "solver.unit_inertia=2"}),
              HasSubstr("solver.unit_inertia is of the lattice"));
}

// Keys of stages that the lattice expresses by controls: fixed blocks, forces beside fixed components, pressures.
TEST(KernelsChoice, StagesOfBlocksBecomeControlsOfBodies) {
  const Motion motion =
      choose_motion(scene_of_text(kTwoBlocks, {"stage.1.velocity=[{block=\"stone\",velocity=[0,\"free\",0.5]}]",
                                               "stage.1.force=[{block=\"stone\",point=[0,0.5,0],force=[0,-3,0]}]",
                                               "stage.1.pressure=[{block=\"stone\",normal=[0.1,1,0],pressure=10}]"}));
  ASSERT_FALSE(motion.shapes);
  const auto& controls = motion.scene.stages[0].controls;
  ASSERT_EQ(controls.size(), 2u);
  EXPECT_EQ(controls[0].body, "stone");
  EXPECT_EQ(controls[0].velocity, (Vec3{0.0, 0.0, 0.5}));
  EXPECT_EQ(controls[0].force, (Vec3{0.0, -3.0 - 10.0, 0.0}));  // 10 Pa on 1 m2
  EXPECT_FALSE(controls[0].may_turn);
  EXPECT_EQ(controls[1].body, "ground");
  EXPECT_EQ(motion.bricks.bricks[1].body, "stone");
  EXPECT_EQ(controls[1].kind, (std::array{DofKind::velocity, DofKind::velocity, DofKind::velocity}));

  const Motion free = choose_motion(
      scene_of_text(kTwoBlocks, {"stage.1.force=[{block=\"stone\",point=[0.5,0.25,0.5],force=[7,-3,0]}]"}));
  ASSERT_EQ(free.scene.stages[0].controls.size(), 2u);
  EXPECT_EQ(free.scene.stages[0].controls[1].body, "stone");
  EXPECT_EQ(free.scene.stages[0].controls[1].force, (Vec3{7.0, -3.0, 0.0}));
  EXPECT_TRUE(free.scene.stages[0].controls[1].may_turn);

  // Areas are 0.5 m2 at the ends and 1 m2 at the top. Each pressure acts against the normal of its face.
  const Motion pressed = choose_motion(scene_of_text(
      kTwoBlocks, {"stage.1.pressure=[{block=\"stone\",normal=[-1,0,0],pressure=6},{block=\"stone\",normal="
                   "[0,1,0],pressure=5},{block=\"stone\",normal=[0,0,-1],pressure=8}]",
                   "stage.1.velocity=[{block=\"stone\",velocity=[\"free\",\"free\",\"free\"]}]"}));
  ASSERT_EQ(pressed.scene.stages[0].controls.size(), 2u);
  EXPECT_EQ(pressed.scene.stages[0].controls[0].body, "stone");
  EXPECT_EQ(pressed.scene.stages[0].controls[0].force, (Vec3{3.0, -5.0, 4.0}));
}

// Up to 12 bodies with controls keep their names. Of more, those with equal controls share one.
TEST(KernelsChoice, BodiesWithEqualControlsShareAName) {
  const auto names = [](int count, const std::string& more) {
    std::string text = fmt::format(
        "[materials.stone]\ndensity = 2000\n[joints.dry]\nlaw = \"elastic\"\nnormal_stiffness = 1e9\n"
        "shear_stiffness = 5e8\n[[block]]\nname = \"slab\"\nmaterial = \"stone\"\n"
        "box = {{ lower = [0, 0, 0], size = [{}, 1, 1] }}\n",
        count);
    for (int i = 0; i < count; ++i)
      text += fmt::format(
          "[[block]]\nname = \"p{}\"\nmaterial = \"stone\"\nfixed = true\nbox = {{ lower = [{}, -1, 0], size = [1, 1, "
          "1] }}\n",
          i, i);
    const Motion motion = choose_motion(scene_of_text(text + "[[stage]]\nduration = 0.1\n" + more));
    std::set<std::string> of_controls, of_bricks;
    for (const BodyControl& control : motion.scene.stages[0].controls) of_controls.insert(control.body);
    for (const Brick& brick : motion.bricks.bricks) of_bricks.insert(brick.body);
    of_controls.insert("");  // the slab
    EXPECT_EQ(of_controls, of_bricks);
    return of_controls;
  };
  EXPECT_EQ(names(12, "").size(), 13u);
  EXPECT_EQ(names(13, ""), (std::set<std::string>{"", "p0 and 12 more"}));
  EXPECT_EQ(names(13, "[[stage.velocity]]\nblock = \"p4\"\nvelocity = [0, 0.1, 0]\n"),
            (std::set<std::string>{"", "p4", "p0 and 11 more"}));
}

// A stone of 1 x 0.5 x 1 m of 2000 kg/m3 and a soft one on elastic joints of 1e9 Pa/m, with both kinds of kernels. The
// ground carries only their weight, 2 x 9.81 kN.
TEST(KernelsChoice, BothKernelsCarryTheWeight) {
  for (const char* kernels : {"lattice", "general"}) {
    const Scene scene =
        scene_of_text(kTwoBlocks, {fmt::format("solver.kernels={}", kernels), "stage.1.duration=1000",
                                   "stage.1.equilibrium_ratio=1e-6", "stage.1.monitor=stone", "output.frames=0"});
    Simulation simulation(scene);
    EXPECT_EQ(simulation.large_motion() != nullptr, std::string(kernels) == "general");
    Observer nobody;
    simulation.run(nobody);
    double carried = 0.0;
    for (const ContactPoint& p : contact_points(simulation)) {
      if (std::min(p.block_a, p.block_b) == 0) carried -= p.traction[0] * p.area;
    }
    EXPECT_NEAR(carried, 2 * 0.5 * 2000 * 9.81, 1e-3 * 9810) << kernels;
    EXPECT_NEAR(simulation.measure().monitor_displacement[1], -2 * 9810.0 / 1e9, 1e-8) << kernels;
    EXPECT_GT(simulation.measure().largest_displacement, 2 * 9810.0 / 1e9) << kernels;
  }
}

struct HighestPlace : Observer {
  double highest = -1.0;  // of the monitor in the second stage, m
  void on_row(const HistoryRow& row) override {
    if (row.stage == 1) highest = std::max(highest, row.displacement);
  }
};

// A stage has damping of its own on the lattice too. Half of the weight goes at once. Without damping the blocks swing
// by 2 m g/(2 k) from where they were, with local damping of 0.8 by some 1.3 m g/(2 k). Kernels agree within 0.5 %, as
// their time steps differ.
TEST(KernelsChoice, AStageHasItsOwnDampingInBothKernels) {
  const std::string second =
      "[[stage]]\nname = \"off\"\ngravity = [0, -4.905, 0]\nduration = 0.02\nrecord_interval = "
      "1\nmonitor = \"stone\"\ndirection = \"y\"\n";
  std::map<std::string, double> swing;
  for (const char* kernels : {"lattice", "general"}) {
    for (const char* damping : {"none", "local"}) {
      std::string text = kTwoBlocks + second + fmt::format("solver = {{ damping = \"{}\" }}\n", damping);
      const Scene scene = scene_of_text(text, {fmt::format("solver.kernels={}", kernels), "stage.1.duration=1000",
                                               "stage.1.equilibrium_ratio=1e-6", "output.frames=0"});
      Simulation simulation(scene);
      EXPECT_EQ(simulation.large_motion() != nullptr, std::string(kernels) == "general");
      HighestPlace place;
      simulation.run(place);
      swing[std::string(kernels) + damping] = place.highest;
      std::printf("%s, %s: %.4g um\n", kernels, damping, 1e6 * place.highest);
    }
  }
  for (const char* damping : {"none", "local"}) {
    const double general = swing[std::string("general") + damping];
    EXPECT_NEAR(swing[std::string("lattice") + damping], general, 5e-3 * general) << damping;
  }
  EXPECT_NEAR(swing["latticenone"], 2 * 9.81e-6, 0.02 * 2 * 9.81e-6);
  EXPECT_LT(swing["latticelocal"], 1.4 * 9.81e-6);
}

// Bodies of bricks have forces and pressures. Any other action keeps a scene off the lattice, also one that is new: it
// needs a setting here.
TEST(KernelsChoice, ActionsThatBricksDoNotHaveAreNamed) {
  const std::map<std::string, std::string> settings = {
      {"ground_motion", "{direction=[1,0,0],time=[0,1],acceleration=[0,1]}"},
      {"collapse", "{}"},
      {"moving_load", "{from=[0,1,0],to=[1,1,0],force=[0,-1,0],positions=3}"}};
  for (const StageAction& action : kStageActions) {
    const std::string key = action.key;
    if (key == "force" || key == "pressure") continue;
    ASSERT_TRUE(settings.contains(key)) << key;
    EXPECT_THAT(refusal({"stage.1." + key + "=" + settings.at(key)}), HasSubstr(action.has));
  }
}

// A wall with the general kernels, by request: below the bound of large motion it is equal to the wall on the lattice.
TEST(KernelsChoice, WallsCanBeMovedByTheGeneralKernels) {
  const std::vector<std::string> settings = {"solver.damping=local", "wall.units_per_course=3", "output.frames=0"};
  std::vector<std::string> general = settings;
  general.push_back("solver.kernels=general");
  Simulation lattice(read_scene(QUOIN_HOST_TESTS "/../cli/small_wall.toml", settings));
  Simulation blocks(read_scene(QUOIN_HOST_TESTS "/../cli/small_wall.toml", general));
  ASSERT_FALSE(lattice.large_motion());
  ASSERT_TRUE(blocks.large_motion());
  EXPECT_TRUE(blocks.large_motion()->is_small);
  EXPECT_EQ(blocks.point_count(), lattice.point_count());
}

// A wall beside an arch and a post. Joints inside the wall are those of the wall alone; all others have the family of
// the joint rule. Stages accept names of both, and a run can be resumed.
TEST(KernelsChoice, AWallStandsBesideBlocks) {
  for (const bool rigid : {true, false}) {
    std::vector<std::string> overrides = {"output.frames=0", fmt::format("wall.rigid_units={}", rigid)};
    if (!rigid) overrides.push_back("wall.zones=[2,2,1]");
    const Scene scene = read_scene(QUOIN_SCENES "/mixed.toml", overrides);
    const Motion motion = choose_motion(scene);
    ASSERT_TRUE(motion.shapes);
    EXPECT_THAT(motion.why_not_lattice, HasSubstr("'arch/0' is no box along the axes"));
    const auto& made = motion.shapes->blocks;
    const auto named = [&](const char* name) {
      return made[static_cast<std::size_t>(blocks::find_blocks(*motion.shapes, name, "test").front())];
    };
    EXPECT_TRUE(named("bottom_beam").fixed);
    EXPECT_FALSE(named("top_beam").fixed);
    EXPECT_EQ(named("wall/0/0").rigid, rigid);
    EXPECT_EQ(named("wall/5/2").course, 5);
    EXPECT_TRUE(named("post").rigid);

    Scene alone = scene;
    alone.blocks.reset();
    const Assembly wall = choose_motion(alone).bricks;
    const Model lattice(wall, make_materials(wall));
    Simulation simulation(scene);
    const auto& families = simulation.large_motion()->contacts.families;
    const auto of_mortar = std::find_if(lattice.families.begin(), lattice.families.end(),
                                        [](const ContactFamily& f) { return f.name == "mortar"; });
    const auto mortar = static_cast<std::size_t>(of_mortar - lattice.families.begin());
    EXPECT_EQ(families[mortar].size(), static_cast<std::size_t>(of_mortar->point_count));
    EXPECT_EQ(families[1 - mortar].size(), 11u * 4u);  // post, springers and joints of the arch

    simulation.advance(100);
    Simulation other(scene);
    other.restore(simulation.save());
    simulation.advance(100), other.advance(100);
    EXPECT_EQ(simulation.hash(), other.hash());
    EXPECT_EQ(simulation.measure().monitor_displacement, other.measure().monitor_displacement);
    EXPECT_LT(simulation.measure().monitor_displacement[1], 0.0);  // it settles under its weight
  }
  const auto refused = [](const std::string& override) {
    try {
      choose_motion(read_scene(QUOIN_SCENES "/mixed.toml", {override}));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refused("wall.half_thickness=true"), HasSubstr("wall.half_thickness: not beside blocks of any shape"));
  EXPECT_THAT(refused("solver.kernels=lattice"), HasSubstr("'arch/0' is no box along the axes"));
}

TEST(KernelsChoice, ZonesOfDryWallsAreAskedForOnce) {
  const std::string scene = QUOIN_SCENES "/solid_wall_030_blocks.toml";
  const auto refused = [&](const std::string& override) {
    try {
      read_scene(scene, {override});
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refused("dry_wall.wall.rigid=true"),
              HasSubstr("dry_wall.1.zones = [ 4, 2, 2 ]: allowed: only with rigid = false"));
  EXPECT_THAT(refused("dry_wall.wall.zone_edge=0.03"), HasSubstr("not beside zone_edge"));
  EXPECT_THAT(refused("dry_wall.wall.zones=[0,1,1]"), HasSubstr("dry_wall.1.zones"));
}

}  // namespace
}  // namespace quoin
