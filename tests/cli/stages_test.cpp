// Settings that stages inherit from earlier ones, their loads, and messages about them.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <regex>
#include <sstream>

#include "program.h"

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Stages : public Cli {
 protected:
  std::string write(const std::string& text, const char* name = "scene.toml") const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  int run(const std::string& scene, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", scene, "--out", out(), "--threads", "1", "--set", "output.plots=false"});
    return quoin(more);
  }
  // Returns the value of a column in the last row of the history.
  double last(const std::string& column) const {
    std::stringstream stream(read_all(folder_ / "out" / "history.csv"));
    std::string head, line, next;
    std::getline(stream, head);
    while (std::getline(stream, next)) line = next;
    std::stringstream names(head), values(line);
    for (std::string name, value; std::getline(names, name, ',') && std::getline(values, value, ',');)
      if (name == column) return std::stod(value);
    ADD_FAILURE() << "no column " << column;
    return 0.0;
  }
  inline static const std::string kBlocks = dry_stone(30) + R"([[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-3, -0.2, -1], size = [6, 0.2, 2] }
[[block]]
name = "bridge/Foundation"
material = "stone"
box = { lower = [-0.2, 0, -0.2], size = [0.4, 0.1, 0.4] }
[output]
frames = 0
[[stage]]
name = "weight"
gravity = [0.0, -9.81, 0.0]
duration = 0.02
)";
};

// A stage inherits settings that its solver table does not have, as the time step fraction.
TEST_F(Stages, SolverTablesKeepWhatTheyDoNotSay) {
  const std::string scene = write(std::string("[solver]\ntime_step_fraction = 0.1\ndamping = \"viscous\"\n"
                                              "stiffness_damping = 1e-6\n") +
                                  kBlocks + R"(solver = { mass_damping = 0.5 }
[[stage]]
name = "on"
duration = 0.02
[[stage]]
name = "faster"
duration = 0.02
solver = { time_step_fraction = 0.4, damping = "local", local_damping = 0.2 }
)");
  ASSERT_EQ(run(scene, {"--set", "stage.faster.duration=1e-6"}), 0) << error_;
  nlohmann::json all = summary();
  const double critical = all["critical_time_step_s"];
  EXPECT_NEAR(all["time_step_s"], 0.4 * critical, 1e-12 * critical);  // a stage may also increase the step
  const auto& stages = all["settings"]["stages"];
  for (const int i : {0, 1}) {  // later stages inherit settings of a stage
    EXPECT_EQ(stages[i]["damping"], "viscous") << i;
    EXPECT_EQ(stages[i]["mass_damping_per_s"], 0.5) << i;
    EXPECT_EQ(stages[i]["stiffness_damping_s"], 1e-6) << i;
    EXPECT_EQ(stages[i]["time_step_fraction"], 0.1) << i;
  }
  EXPECT_EQ(stages[2]["damping"], "local");
  EXPECT_EQ(stages[2]["local_damping"], 0.2);
  EXPECT_EQ(stages[2]["time_step_fraction"], 0.4);
  EXPECT_THAT(error_, AllOf(HasSubstr("damping viscous, mass 0.5 1/s, stiffness 1e-06 s, time_step_fraction 0.1: time "
                                      "step"),
                            HasSubstr("damping local 0.2, time_step_fraction 0.4: time step"),
                            HasSubstr("(0.40 of 2/omega_max)")));

  ASSERT_EQ(quoin({"check", scene}), 0) << error_;
  EXPECT_THAT(out_, AllOf(HasSubstr("stiffness 1e-06 s, time_step_fraction 0.1: time step"),
                          HasSubstr(", 0.40 of 2/omega_max")));

  // Only the first stage: the printed step is the step of the run.
  const std::string first =
      write(std::string("[solver]\ntime_step_fraction = 0.1\n") + kBlocks + "solver = { damping = \"none\" }\n",
            "first.toml");
  ASSERT_EQ(run(first), 0) << error_;
  all = summary();
  EXPECT_NEAR(all["time_step_s"], 0.1 * all["critical_time_step_s"].get<double>(), 1e-12 * critical);
  EXPECT_NEAR(all["simulated_time_s"].get<double>() / all["steps"].get<double>(), all["time_step_s"], 1e-9 * critical);

  EXPECT_EQ(run(scene, {"--set", "stage.on.solver={deformation_damping=0.1}"}), 3);
  EXPECT_THAT(error_, HasSubstr("only with damping = \"block\""));
}

// Loads of floors act also in scenes with blocks of any shape: the base carries them, 20 kN, without weights.
TEST_F(Stages, LoadsOfFloorsActBesideBlocks) {
  std::string text = read_all(QUOIN_TESTS "/host/small_building.toml");
  text = text.substr(0, text.find("[[stage]]")) + R"(
[[joint_rule]]
family = "mortar"
[[block]]
name = "apart"
material = "masonry"
box = { lower = [9, 0, 9], size = [1, 1, 1] }
fixed = true
[[stage]]
name = "load"
gravity = [0, 0, 0]
ramp_time = 0.02
equilibrium_ratio = 1e-3
max_steps = 20000
[output]
monitor = "bottom_beam"
frames = 0
)";
  const std::string scene = write(text);
  for (const char* kernels : {"automatic", "general"}) {
    for (const char* rigid : {"true", "false"}) {
      ASSERT_EQ(run(scene, {"--set", std::string("solver.kernels=") + kernels, "--set",
                            std::string("building.floor.floor_1.rigid_beams=") + rigid}),
                0)
          << error_;
      EXPECT_NEAR(last("monitor_fy_N"), -20e3, 20.0) << kernels << " " << rigid;
    }
  }
  EXPECT_EQ(quoin({"check", scene, "--set", "building.floor.floor_1.rigid_beams=false"}), 0) << error_;
  EXPECT_THAT(out_, AllOf(HasSubstr("on the lattice"), Not(HasSubstr("not on the lattice"))));
}

// A block on ground that tilts by 35 degrees slides where friction is 30. Local damping lets it move by less than a
// millimetre in 0.05 s, which passes for rest. At 20 degrees it stays: what is left of vibrations is far below the
// bound.
TEST_F(Stages, BlocksThatCreepAtTheEndOfAStageAreToldOf) {
  for (const double degrees : {20.0, 35.0}) {
    const double angle = degrees * M_PI / 180.0;
    const std::string scene =
        write(kBlocks + fmt::format("[[stage]]\nname = \"tilt\"\ngravity = [{}, {}, 0]\n"
                                    "ramp_time = 0.05\nduration = 0.1\nmonitor = \"bridge/Foundation\"\n",
                                    9.81 * std::sin(angle), -9.81 * std::cos(angle)));
    for (const char* const kernels : {"automatic", "general"}) {
      ASSERT_EQ(run(scene, {"--set", std::string("solver.kernels=") + kernels}), 0) << error_;
      const std::string warnings = summary()["warnings"].dump(1);
      std::printf("%g degrees: unbalanced_ratio %.3g, dx %.3g mm\n", degrees, last("unbalanced_ratio"),
                  1e3 * last("monitor_dx_m"));
      EXPECT_EQ(warnings.find("stage 'tilt' ends while blocks still move") != std::string::npos, degrees > 30.0)
          << warnings;
    }
  }
}

// The same where the stage asks for equilibrium, under any damping. At 35 degrees it ended by its duration without a
// warning. At 20 degrees it ends at rest.
TEST_F(Stages, AStageThatMissesItsEquilibriumIsToldOf) {
  for (const auto& [degrees, damping] :
       {std::pair{20.0, "local"}, {35.0, "local"}, {35.0, "viscous"}, {35.0, "none"}}) {
    const double angle = degrees * M_PI / 180.0;
    const std::string scene =
        write(kBlocks + fmt::format("[[stage]]\nname = \"tilt\"\ngravity = [{}, {}, 0]\nramp_time = 0.05\n"
                                    "duration = 1.0\nequilibrium_ratio = 1e-3\nsolver = {{ damping = \"{}\" }}\n",
                                    9.81 * std::sin(angle), -9.81 * std::cos(angle), damping));
    ASSERT_EQ(run(scene, {"--set", "output.monitor=bridge/Foundation"}), 0) << error_;
    const std::string warnings = summary()["warnings"].dump(1);
    std::printf("%g degrees, %s: unbalanced_ratio %.3g, dx %.3g mm\n", degrees, damping, last("unbalanced_ratio"),
                1e3 * last("monitor_dx_m"));
    EXPECT_EQ(warnings.find("stage 'tilt' ends without the equilibrium") != std::string::npos, degrees > 30.0)
        << warnings;
    const std::string ratios =
        fmt::format("is {:.3g} of the mean contact force (unbalanced_ratio), wanted 0.001", last("unbalanced_ratio"));
    EXPECT_EQ(warnings.find(ratios) != std::string::npos, degrees > 30.0) << warnings;
  }
}

// An arch of t/R = 0.05 falls, and a voussoir is named at its place: on the line of the arch. All were at its centre,
// the origin of their shapes. Tolerance: a centroid is 2 % inside of the line.
TEST_F(Stages, VoussoirsThatFallAreNamedAtTheirCentres) {
  const std::string scene = write(dry_stone(60) + R"([[arch]]
name = "arch"
material = "stone"
centre = [1.0, 0.0, 0.0]
radius = 2.0
thickness = 0.1
depth = 1.0
voussoirs = 16
angles = [0, 180]
[output]
frames = 0
[[stage]]
name = "weight"
gravity = [0.0, -9.81, 0.0]
duration = 2.0
)");
  ASSERT_EQ(run(scene), 0) << error_;
  const std::string text = summary()["warnings"].dump(1);
  const std::regex place("block #[0-9]+ 'arch/[0-9]+' at [(]([-0-9.]+), ([-0-9.]+), ([-0-9.]+)[)] m falls");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(text, found, place)) << text;
  EXPECT_NEAR(std::hypot(std::stod(found[1]) - 1.0, std::stod(found[2])), 2.0, 0.04) << text;
}

// A block that is twisted about the vertical, and free to move. The moment of its support is opposite to that of the
// ground, as its spin is constant. Tolerance 1e-3, for vibrations.
TEST_F(Stages, RotationsThatAreDrivenHaveReactions) {
  const std::string scene = write(kBlocks + R"([[stage]]
name = "twist"
duration = 0.05
monitor = "bridge/Foundation"
[[stage.velocity]]
block = "bridge/Foundation"
velocity = ["free", "free", "free"]
omega = [0, 1e-3, 0]
)");
  ASSERT_EQ(run(scene), 0) << error_;
  const double moment = last("reaction_bridge/Foundation_my_Nm");
  std::printf("%g N m\n", moment);
  EXPECT_GT(moment, 1.0);
  EXPECT_NEAR(last("reaction_ground_my_Nm"), -moment, 1e-3 * moment);
}

// Three dry blocks of b/h = 0.5 on a table that tilts topple at atan(0.5) = 26.57 degrees, where friction is 60. By
// local damping they stood until 34. The bounds leave 1 degree before, for the springs of the joints, and 1.5 after,
// for the time in which they fall at 0.02 rad/s. So it is with local damping of 0.8 that is chosen, which is warned of.
TEST_F(Stages, RigidBlocksThatAreMovedHaveNoDragByDefault) {
  std::string text = dry_stone(60) +
                     "[output]\nframes = 0\nmonitor = \"b2\"\n[[block]]\nname = \"base\"\nmaterial = "
                     "\"stone\"\nfixed = true\nbox = { lower = [-1, -0.2, -1], size = [2, 0.2, 2] }\n";
  for (int i = 0; i < 3; ++i)
    text += fmt::format(
        "[[block]]\nname = \"b{}\"\nmaterial = \"stone\"\nbox = {{ lower = [0, {}, -0.15], size = [{}, "
        "{}, 0.3] }}\n",
        i, 0.1 * i, 0.15, 0.1);
  text += "[[stage]]\nname = \"weight\"\ngravity = [0, -9.81, 0]\nramp_time = 0.1\nduration = 0.3\n";
  const auto lean = [&](double degrees, const char* damping) {
    const double omega = 0.02, angle = degrees * M_PI / 180.0;
    const std::string scene =
        write(damping + text +
              fmt::format("[[stage]]\nname = \"tilt\"\nduration = {}\nramp_time = 0.1\n[[stage.velocity]]\nblock = "
                          "\"base\"\nvelocity = [0, 0, 0]\nomega = [0, 0, {}]\n",
                          angle / omega + 0.05, -omega));
    EXPECT_EQ(run(scene), 0) << error_;
    // Centre of the top block from that of the base, at (0, -0.1), turned with it.
    const double x = 0.075, y = 0.35, moved = x * std::cos(angle) + y * std::sin(angle) - x;
    return last("monitor_dx_m") - moved;
  };
  EXPECT_NEAR(lean(25.5, ""), 0.0, 1e-3);
  EXPECT_GT(lean(28.0, ""), 0.01);
  EXPECT_NEAR(lean(28.0, "[solver]\ndamping = \"local\"\n"), 0.0, 1e-3);
  EXPECT_NE(summary()["warnings"].dump().find("\"drag\""), std::string::npos);
}

// --set finds a stage without a name by its kind.
TEST_F(Stages, AStageWithoutANameIsCalledByItsKind) {
  std::string text = read_all(small_);
  text.erase(text.find("name = \"shear\"\n"), std::string("name = \"shear\"\n").size());
  const std::string scene = write(text);
  ASSERT_EQ(run(scene, {"--set", "stage.shear.displacement=0.00001"}), 0) << error_;
  EXPECT_EQ(summary()["settings"]["stages"][1]["displacement_m"], 1e-5);
  EXPECT_EQ(run(scene, {"--set", "stage.push.displacement=0.0001"}), 3);
  EXPECT_THAT(error_, HasSubstr("which has 2 ('precompression', 'shear')"));
}

TEST_F(Stages, ABlockIsFoundByTheLastPartOfItsName) {
  const std::string scene = write(kBlocks);
  EXPECT_EQ(run(scene, {"--set", "output.monitor=Foundation"}), 3);
  EXPECT_THAT(error_, HasSubstr("no block is called 'Foundation', did you mean 'bridge/Foundation'?"));
}

// A material needs stiffness only if its blocks are deformable.
TEST_F(Stages, RigidBlocksNeedNoStiffness) {
  ASSERT_EQ(run(write(kBlocks)), 0) << error_;  // its stone has only a density
  const std::string zoned =
      write(std::string(kBlocks) +
            "[[block]]\nmaterial = \"stone\"\nrigid = false\ndivisions = [1, 1, 1]\nbox = { lower "
            "= [1, 0, 0], size = [1, 1, 1] }\n");
  EXPECT_EQ(run(zoned), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr("scene.toml:2: materials.stone.young_modulus: missing"),
                            HasSubstr("materials.stone.poisson_ratio: missing")));
  // Deformable units, rigid beams of steel.
  EXPECT_EQ(quoin({"check", small_, "--set", "wall.rigid_units=true", "--set", "wall.zones=[1,1,1]"}), 3);
}

// With points only at corners joints with tensile strength are too stiff in bending, so check warns about that setting.
// Dry joints rotate about their corners.
TEST_F(Stages, CheckTellsOfJointsWithCornersAlone) {
  const std::string bonded =
      "[[joint_rule]]\nfamily = \"dry\"\n[[dry_wall]]\nname = \"wall\"\nmaterial = \"stone\"\ncourses = 3\n"
      "units_per_course = 1\nunit = [0.4, 0.2, 0.2]\norigin = [1, 0, 0]\n";
  const std::string scene = write(kBlocks + bonded);
  ASSERT_EQ(quoin({"check", scene}), 0) << error_;
  EXPECT_THAT(out_, Not(HasSubstr("at their corners alone")));
  EXPECT_THAT(out_, Not(HasSubstr("integrate bending exactly")));
  ASSERT_EQ(quoin({"check", scene, "--law", "elastic"}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("7 joints of rigid blocks have points that integrate bending exactly"));
  ASSERT_EQ(quoin({"check", scene, "--law", "elastic", "--set", "contact.cubic_points=false"}), 0) << error_;
  EXPECT_THAT(out_, AllOf(HasSubstr("warning: 7 joints of rigid blocks"), HasSubstr("contact.cubic_points = false")));
  ASSERT_EQ(quoin({"check", scene, "--law", "elastic", "--set", "contact.point_spacing=0.04"}), 0) << error_;
  EXPECT_THAT(out_, Not(HasSubstr("7 joints of rigid blocks")));
  ASSERT_EQ(quoin({"check", QUOIN_SCENES "/cube_wall_10.toml"}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("warning: 180 joints of rigid blocks"));
  ASSERT_EQ(quoin({"check", QUOIN_SCENES "/solid_wall_030.toml"}), 0) << error_;
  EXPECT_THAT(out_, Not(HasSubstr("at their corners alone")));
}

// Blocks that no joint ties to what is held are named: the first five, then dots.
TEST_F(Stages, CheckNamesBlocksThatMayFall) {
  std::string blocks;
  const auto checked = [&](int count) {
    blocks = kBlocks;
    for (int i = 0; i < count; ++i)
      blocks += fmt::format(
          "[[block]]\nname = \"stone {}\"\nmaterial = \"stone\"\nbox = {{ lower = [{}, 2, 0], size = "
          "[0.2, 0.2, 0.2] }}\n",
          i, i);
    EXPECT_EQ(quoin({"check", write(blocks)}), 0) << error_;
    return out_;
  };
  EXPECT_THAT(checked(0), Not(HasSubstr("may fall")));
  EXPECT_THAT(checked(2), AllOf(HasSubstr("2 of 4 blocks may fall, as no joint ties them to what is held: "),
                                HasSubstr("held: #2 'stone 0', #3 'stone 1'\n")));
  const std::string five = "#2 'stone 0', #3 'stone 1', #4 'stone 2', #5 'stone 3', #6 'stone 4'";
  EXPECT_THAT(checked(5), HasSubstr("held: " + five + "\n"));
  EXPECT_THAT(checked(7), HasSubstr("held: " + five + ", ...\n"));
}

}  // namespace
