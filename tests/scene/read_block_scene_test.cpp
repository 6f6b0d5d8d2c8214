// Reader of scenes of blocks, and of their records of ground motion.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "one_block.h"
#include "records/read_record.h"
#include "scene/read_scene.h"

namespace quoin {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class ReadBlockScene : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("quoin_block_scene_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() +
               "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const char* name, const std::string& text) {
    const std::string file = (folder_ / name).string();
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
  Scene read(const std::vector<std::string>& overrides) { return read_scene(write("s.toml", kOneBlock), overrides); }
  template <typename Action>
  std::string refusal(Action&& action) {
    try {
      action();
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      return error.what();
    }
    ADD_FAILURE() << "accepted";
    return {};
  }
  std::string fault(const std::string& override) {
    return refusal([&] { read({override}); });
  }
  std::string record_fault(const std::string& text) {
    const std::string file = write("quake.csv", text);
    return refusal([&] { read_record(file); });
  }

  std::filesystem::path folder_;
};

TEST_F(ReadBlockScene, NumbersBeyondAllMeasureAreRefused) {
  for (const char* number : {"1e308", "1e-300"}) {
    EXPECT_THAT(fault(std::string("contact.skin=") + number), HasSubstr("allowed: a number, 1e-09 to 1000"));
    EXPECT_THAT(fault(std::string("contact.joint_tolerance=") + number), HasSubstr("allowed: a number, 1e-09 to 1000"));
  }
  EXPECT_THAT(fault("materials.stone.density=1e308"), HasSubstr("density"));
}

TEST_F(ReadBlockScene, DampingByBlockAndScaledInertiaAreTaken) {
  EXPECT_EQ(read({}).solver.damping, DampingKind::local);
  EXPECT_EQ(read({}).solver.deformation_inertia, 1.0);
  const SolverSettings s = read({"solver.damping=block", "solver.local_damping=0.3", "solver.deformation_inertia=64",
                                 "solver.deformation_damping=0.1", "solver.settling_damping=0.5"})
                               .solver;
  EXPECT_EQ(s.damping, DampingKind::block);
  EXPECT_EQ(s.deformation_inertia, 64.0);
  EXPECT_EQ(s.deformation_damping, 0.1);
  EXPECT_EQ(s.settling_damping, 0.5);
}

TEST_F(ReadBlockScene, InertiaThatCannotBeScaledIsRefused) {
  EXPECT_THAT(fault("solver.deformation_inertia=64"), HasSubstr("use damping = \"block\""));
  EXPECT_THAT(fault("solver.deformation_damping=0.1"), HasSubstr("only with damping = \"block\""));
  const auto of_stage = [&](const std::string& solver, const std::string& stage) {
    return refusal([&] { read_scene(write("s.toml", kOneBlock + ("solver = " + stage + "\n[solver]\n") + solver)); });
  };
  EXPECT_THAT(of_stage("damping = \"none\"\n", "{ damping = \"block\", deformation_inertia = 2 }"),
              HasSubstr("inertia is of the whole run; give it in [solver]"));
  EXPECT_THAT(of_stage("damping = \"none\"\n", "{ mass_scaling = 2 }"), HasSubstr("inertia is of the whole run"));
  EXPECT_THAT(of_stage("damping = \"block\"\ndeformation_inertia = 64\n", "{ damping = \"local\" }"),
              HasSubstr("damping other than \"local\""));
}

TEST_F(ReadBlockScene, RecordsMayHaveCommentsAndAHeader) {
  for (const char* text : {
           "# station 7\ntime, acceleration\n0, 0.5\n0.01, -1.5e0 # peak\n\n+0.02, 0\n",
           "\xEF\xBB\xBFTime (s); Acc (m/s2)\r\n0; 0.5\r\n0.01; -1.5\r\n0.02; 0\r\n",
           "% blanks\n  0 0.5\n0.01\t-1.5\n0.02   0",
       }) {
    const GroundRecord record = read_record(write("quake.csv", text));
    EXPECT_THAT(record.time, ElementsAre(0.0, 0.01, 0.02)) << text;
    EXPECT_THAT(record.components.at(0).value, ElementsAre(0.5, -1.5, 0.0)) << text;
  }
}

TEST_F(ReadBlockScene, NoLineOfARecordIsLeftOut) {
  for (const char* line : {"0.02", "0.02,", "0.02, 1, 2", "0,02 0,5", "x, 1", "0.02, 1e999", "0.02, inf", "nan, 1",
                           "inf, 1", "0.02 1.5g", "acceleration", "0.02: 1", "0x1p-5, 1"}) {
    EXPECT_THAT(record_fault("0, 0\n" + std::string(line) + "\n3, 0\n"),
                AllOf(HasSubstr("quake.csv:2: '" + std::string(line) + "'"), HasSubstr("allowed")))
        << line;
  }
  EXPECT_THAT(record_fault("0, 0\ntime, acceleration\n"), HasSubstr("quake.csv:2"));
  EXPECT_THAT(record_fault("-0.01, 0\n0, 1\n"), AllOf(HasSubstr("quake.csv:1"), HasSubstr("0 s or later")));
  for (const char* second : {"0.02, 1", "0.01, 1"}) {
    EXPECT_THAT(record_fault("0, 0\n0.02, 0\n" + std::string(second) + "\n0.03, 0\n"),
                AllOf(HasSubstr("quake.csv:3"), HasSubstr("times that increase"), Not(HasSubstr("quake.csv:4"))));
  }
  EXPECT_THAT(record_fault(""), HasSubstr("0 rows of numbers; allowed: at least 2"));
  EXPECT_THAT(record_fault("# nothing\ntime, acceleration\n"), HasSubstr("0 rows of numbers; allowed: at least 2"));
  EXPECT_THAT(refusal([&] { read_record((folder_ / "none.csv").string()); }), HasSubstr("no such file"));
  EXPECT_THAT(refusal([&] { read_record(folder_.string()); }), HasSubstr("it is a folder"));
}

TEST_F(ReadBlockScene, RecordsStandBesideTheScene) {
  write("quake.csv", "0, 0\n1, 2\n");
  const Scene s = read({"stage.1.ground_motion={direction=[1,0,0],file='quake.csv',scale=9.81}"});
  EXPECT_THAT(s.stages[0].ground->components.at(0).acceleration.value, ElementsAre(0.0, 19.62));
  // `quoin check` and the screen of a run print these notes.
  EXPECT_THAT(s.stages[0].ground->notes,
              ElementsAre(AllOf(HasSubstr("assumed: "), HasSubstr("values are accelerations in m/s2"))));
  write("named.csv", "time_s, x_cm_s2\n0, 0\n1, 200\n");
  const Scene named = read({"stage.1.ground_motion={direction=[1,0,0],file='named.csv'}"});
  EXPECT_THAT(named.stages[0].ground->components.at(0).acceleration.value, ElementsAre(0.0, 2.0));
  EXPECT_TRUE(named.stages[0].ground->notes.empty());
  write("quake.csv", "0, 0\n1, nan\n");
  EXPECT_THAT(fault("stage.1.ground_motion={direction=[1,0,0],file='quake.csv'}"),
              AllOf(HasSubstr("stage.1.ground_motion.file = 'quake.csv'"), HasSubstr("quake.csv:2: '1, nan'")));
  write("quake.csv", "0, 0\n1, 1e300\n");
  EXPECT_THAT(fault("stage.1.ground_motion={direction=[1,0,0],file='quake.csv',scale=1e10}"), HasSubstr("scale"));
  EXPECT_THAT(fault("stage.1.ground_motion={direction=[1,0,0],file='quake.csv',time=[0]}"),
              AllOf(HasSubstr("ground_motion.time"), HasSubstr("only without file")));
}

// A file with a unit is read in this unit. A second conversion from g would be ten times the earthquake, and has a
// message.
TEST_F(ReadBlockScene, RecordsThatStateTheirUnitAreConvertedOnce) {
  write("stated.csv", "time (s), x (g)\n0, 0\n1, 0.1\n");
  const auto keys = [](const std::string& scale) {
    return "stage.1.ground_motion={direction=[1,0,0],file='stated.csv',scale=" + scale + "}";
  };
  for (const char* scale : {"9.81", "9.80665", "9.8"})
    EXPECT_THAT(fault(keys(scale)), AllOf(HasSubstr("ground_motion.scale"), HasSubstr("convert it twice")));
  EXPECT_NEAR(read({keys("9.0")}).stages[0].ground->components.at(0).acceleration.value.at(1), 0.9 * 9.80665, 1e-12);
}

// The scale of all supports is a second conversion too, alone or times that of a group.
TEST_F(ReadBlockScene, RecordsOfSupportsAreConvertedOnce) {
  write("stated.csv", "time (s), x (g)\n0, 0\n1, 0.1\n");
  const auto keys = [](const std::string& whole, const std::string& group) {
    return "stage.1.ground_motion={scale=" + whole +
           ",support=[{blocks=['block'],direction=[1,0,0],file='stated.csv',scale=" + group + "}]}";
  };
  for (const auto& [whole, group] : {std::pair("9.81", "1"), {"1", "9.81"}, {"2", "4.905"}})
    EXPECT_THAT(fault(keys(whole, group)), AllOf(HasSubstr("support.1.scale"), HasSubstr("convert it twice")));
  EXPECT_NEAR(read({keys("2", "3")}).stages[0].ground->supports.at(0).components.at(0).acceleration.value.at(1),
              0.6 * 9.80665, 1e-12);
}

// A record of 1e308 m/s2 over 1e308 s ended at inf m/s. A pulse that overflows named scale, which was not given.
TEST_F(ReadBlockScene, GroundThatOverflowsNamesTheKeyThatDoesIt) {
  const std::pair<const char*, const char*> cases[] = {
      {"direction=[1,0,0],time=[0,1e308],acceleration=[1e308,1e308]", "ground_motion.acceleration = [ 1e+308"},
      {"direction=[1,0,0],pulse={shape='sine',amplitude=1e300,period=1e300}", "ground_motion.pulse = a table"},
      {"direction=[1,0,0],synthetic={ground_acceleration=1e308}", "ground_motion.synthetic = a table"},
      {"direction=[1,0,0],pulse={shape='sine',amplitude=1e300,period=1},scale=1e10", "ground_motion.scale = 1"},
      {"direction=[1,0,0],time=[0,1,2],acceleration=[0,1,0],pga=1e308,scale=1e10", "ground_motion.scale = 1"},
      {"direction=[1,0,0],time=[0,1,2],acceleration=[0,1e-10,0],pgv=1e308", "ground_motion.pgv = 1"},
      {"scale=1e300,support=[{blocks=['block'],direction=[1,0,0],time=[0,1],acceleration=[1e10,1]}]",
       "ground_motion.scale = 1"}};
  for (const auto& [keys, named] : cases)
    EXPECT_THAT(fault(fmt::format("stage.1.ground_motion={{{}}}", keys)),
                AllOf(HasSubstr(named), Not(HasSubstr("= ?"))))
        << keys;
}

// A key beside a missing one was "unknown".
TEST_F(ReadBlockScene, KeysOfAFillAreReadWithoutItsFrictionAngle) {
  EXPECT_THAT(fault("fill=[{block='block',surface=[0,1,0],unit_weight=1,stiffness=1,active=0.3,passive=2}]"),
              AllOf(HasSubstr("fill.1.friction_angle: missing"), Not(HasSubstr("unknown key"))));
}

// A triangle of less than the rounding of times did not stop the ground, in silence.
TEST_F(ReadBlockScene, GroundComesToRestInATimeThatCounts) {
  const auto keys = [](const std::string& time) {
    return "stage.1.ground_motion={direction=[1,0,0],time=[0,1,2],acceleration=[0,1,0],after='rest',rest_time=" + time +
           "}";
  };
  for (const char* time : {"1e-310", "1e-17", "1e-6"})
    EXPECT_THAT(fault(keys(time)), AllOf(HasSubstr("ground_motion.rest_time"), HasSubstr("at least 2e-06 s")));
  const TimeSeries stops = read({keys("1e-5")}).stages[0].ground->components.at(0).acceleration;
  EXPECT_NEAR(stops.integral(3.0), 0.0, 1e-9);
}

// Pulses and synthetic records in place of a file.
TEST_F(ReadBlockScene, GroundMotionIsMadeWithoutAFile) {
  const auto of = [&](const std::string& keys) {
    return read({"stage.1.ground_motion={direction=[1,0,0]," + keys + "}"})
        .stages[0]
        .ground->components.at(0)
        .acceleration;
  };
  const TimeSeries sine = of("pulse={shape='sine',amplitude=3,period=0.8}");
  EXPECT_NEAR(sine.at(0.2), 3.0, 1e-9);
  EXPECT_NEAR(sine.time.back(), 0.8, 1e-12);
  const TimeSeries rectangle = of("pulse={shape='rectangle',amplitude=3,period=0.8},scale=2");
  EXPECT_NEAR(rectangle.integral(1.0), 2 * 3 * 0.8, 1e-9);
  EXPECT_NEAR(of("pulse={shape='cosine',amplitude=3,period=0.8}").at(0.4), -3.0, 1e-9);
  EXPECT_NEAR(of("pulse={shape='ricker',amplitude=3,period=0.8}").at(1.2), 3.0, 1e-9);
  // Its velocity is amplitude cos(phase) in the middle, after half of gamma periods.
  EXPECT_NEAR(of("pulse={shape='mavroeidis',amplitude=0.5,period=0.8,gamma=2}").integral(0.8), 0.5, 1e-3);
  const TimeSeries made = of("synthetic={seed=3,duration=6},pga=2");
  EXPECT_NEAR(made.time.back(), 6.0, 1e-9);
  EXPECT_EQ(made.value, of("synthetic={seed=3,duration=6},pga=2").value);
  EXPECT_NE(made.value, of("synthetic={seed=3,number=1,duration=6},pga=2").value);
  const auto refused = [&](const std::string& keys) {
    return fault("stage.1.ground_motion={direction=[1,0,0]," + keys + "}");
  };
  EXPECT_THAT(refused("pulse={shape='sine',period=1},synthetic={}"), HasSubstr("only without pulse"));
  EXPECT_THAT(refused("pulse={shape='sine',period=1,gamma=2}"), HasSubstr("mavroeidis"));
  EXPECT_THAT(refused("pulse={shape='sine',period=1},time=[0,1]"), HasSubstr("only without pulse and synthetic"));
  EXPECT_THAT(refused("synthetic={duration=1}"), HasSubstr("synthetic.duration"));
}

// A file of several components by their names; files of one component each; part, strength and end of a record.
TEST_F(ReadBlockScene, RecordsHaveComponentsPartsAndTargets) {
  write("three.csv", "time (s), x (g), up (g), z (g)\n0, 0, 0, 0\n1, 0.1, 0.2, 0.3\n2, 0, 0, 0\n");
  const auto of = [&](const std::string& keys) {
    return *read({"stage.1.ground_motion={" + keys + "}"}).stages[0].ground;
  };
  const auto fault_of = [&](const std::string& keys) { return fault("stage.1.ground_motion={" + keys + "}"); };
  const GroundMotion named = of("file='three.csv'");  // the columns with names of axes
  ASSERT_EQ(named.components.size(), 2u);
  EXPECT_EQ(named.components[1].direction, (Vec3{0, 0, 1}));
  EXPECT_NEAR(named.components[1].acceleration.value[1], 0.3 * 9.80665, 1e-12);
  const GroundMotion all = of("file='three.csv',x='z',y='up',z='x',pga=1.0,scale=2");
  ASSERT_EQ(all.components.size(), 3u);
  EXPECT_NEAR(all.components[0].acceleration.value[1], 2.0,
              1e-12);  // the strongest component has the target, times scale
  EXPECT_NEAR(all.components[2].acceleration.value[1], 2.0 / 3, 1e-12);
  EXPECT_THAT(fault_of("direction=[1,0,0],file='three.csv'"), HasSubstr("x, up, z"));
  EXPECT_EQ(of("direction=[1,0,0],file='three.csv',column='up'").components.size(), 1u);

  write("a.csv", "time (s), a (m/s2)\n0, 0\n1, 2\n2, 0\n");
  const GroundMotion files = of("x='a.csv',y='a.csv'");
  ASSERT_EQ(files.components.size(), 2u);
  EXPECT_EQ(files.components[1].direction, (Vec3{0, 1, 0}));
  const TimeSeries part = of("direction=[1,0,0],file='a.csv',start=0.5,until=1.5").components[0].acceleration;
  EXPECT_THAT(part.time, ElementsAre(0.0, 0.5, 1.0));
  EXPECT_THAT(part.value, ElementsAre(1.0, 2.0, 1.0));
  EXPECT_THAT(fault_of("direction=[1,0,0],file='a.csv',start=3"), HasSubstr("0 to 2 s"));
  // 2 m/s at the end of the record, which falls to rest over 1 s.
  const GroundMotion::Component rest = of("direction=[1,0,0],file='a.csv',after='rest',rest_time=1").components[0];
  EXPECT_NEAR(rest.velocity.at(rest.acceleration, 2.0), 2.0, 1e-12);
  EXPECT_NEAR(rest.velocity.at(rest.acceleration, 3.0), 0.0, 1e-12);
  EXPECT_NEAR(rest.acceleration.integral(2.3), rest.velocity.at(rest.acceleration, 2.3), 1e-12);
  EXPECT_THAT(fault_of("direction=[1,0,0],file='a.csv',pga=1,sa=2"), HasSubstr("one of pga, pgv and sa"));
  EXPECT_THAT(fault_of("direction=[1,0,0],file='a.csv',sa=2"), HasSubstr("sa_period"));
  EXPECT_NEAR(of("direction=[1,0,0],file='a.csv',pgv=1").components[0].acceleration.value[1], 1.0, 1e-12);
  EXPECT_NEAR(of("direction=[1,0,0],file='a.csv',baseline='linear'").components[0].acceleration.value[1], 4.0 / 3,
              1e-9);
}

TEST_F(ReadBlockScene, SeriesInTheSceneKeepTheSameRules) {
  const auto ground = [](const char* series) {
    return std::string("stage.1.ground_motion={direction=[1,0,0],") + series + "}";
  };
  for (const char* series :
       {"time=[0,nan],acceleration=[0,1]", "time=[0,1],acceleration=[0,inf]", "time=[0,0],acceleration=[0,1]",
        "time=[1,0],acceleration=[0,1]", "time=[-1,0],acceleration=[0,1]", "time=[],acceleration=[]",
        "time=[0,1],acceleration=[0,'1']", "time=[0,1],acceleration=[0]", "time=0,acceleration=0"}) {
    EXPECT_THAT(fault(ground(series)), HasSubstr("stage.1.ground_motion")) << series;
  }
  const Scene s = read({ground("time=[0, 9007199254740993],acceleration=[9007199254740993,0]")});
  EXPECT_EQ(s.stages[0].ground->components.at(0).acceleration.time[1], 9007199254740992.0);
  EXPECT_EQ(s.stages[0].ground->components.at(0).acceleration.value[0], 9007199254740992.0);
}

TEST_F(ReadBlockScene, PlacesDirectionsAndLoadsAreNumbersOfThisWorld) {
  for (const char* setting : {
           "block.1.rotation=[1e300, 0, 0]",
           "block.1.rotation=[nan, 0, 0]",
           "block.1.position=[0, 1e300, 0]",
           "block.1.position=[0, -9007199254740993, 0]",
           "block.1.box.size=[1e200, 1, 1]",
           "block.1.scale=2.0",
           "materials.stone.density=-9007199254740993",
           "stage.1.velocity=[{block='block', velocity=[nan, 0, 0]}]",
           "stage.1.velocity=[{block='block', velocity=[0, -inf, 0]}]",
           "stage.1.velocity=[{block='block', velocity=[0, true, 0]}]",
           "stage.1.velocity=[{block='block', velocity=[0, 0]}]",
           "stage.1.ground_motion={direction=[0,0,0], time=[0,1], acceleration=[0,1]}",
           "stage.1.collapse={direction=[0,0,0]}",
           "stage.1.collapse={start=3.0}",
           "stage.1.pressure=[{block='block', normal=[0,0,0], pressure=1}]",
       }) {
    const std::string text = setting;
    EXPECT_THAT(fault(text), AllOf(HasSubstr("--set: " + text.substr(0, text.find('='))), HasSubstr("allowed")));
  }
  EXPECT_THAT(fault("block.1.rotation=[1e300, 0, 0]"), Not(HasSubstr("\n")));  // a fault is one line
  const Scene s = read({"stage.1.velocity=[{block='block', velocity=[9007199254740993, 'free', 0]}]"});
  EXPECT_EQ(s.stages[0].controls.at(0).velocity, (Vec3{9007199254740992.0, 0, 0}));
  EXPECT_EQ(s.stages[0].controls[0].kind, (std::array{DofKind::velocity, DofKind::free, DofKind::velocity}));
}

TEST_F(ReadBlockScene, VerticesAndFaces) {
  std::string text = kOneBlock;
  const std::string box = "box = { lower = [0, 0, 0], size = [1, 1, 1] }";
  const auto with = [&](const std::string& vertices, const std::string& faces) {
    std::string other = text;
    other.replace(other.find(box), box.size(), "vertices = " + vertices + "\nfaces = " + faces);
    return write("s.toml", other);
  };
  const std::string corners = "[[0,0,0],[1,0,0],[0,1,0],[0,0,1]]";
  const Scene s = read_scene(with(corners, "[[0,2,1],[0,1,3],[1,2,3],[0,3,2]]"));
  EXPECT_THAT(s.blocks->blocks[0].faces[0], ElementsAre(0, 2, 1));
  for (const char* wrong : {"4294967297", "1.7", "1.0", "-1", "4", "true", "9223372036854775807", "nan"}) {
    const std::string file = with(corners, "[[0,2," + std::string(wrong) + "],[0,1,3],[1,2,3],[0,3,2]]");
    EXPECT_THAT(refusal([&] { read_scene(file); }),
                AllOf(HasSubstr("s.toml:13: block.1.faces"), HasSubstr("less than 4")))
        << wrong;
  }
  for (const char* wrong : {"nan", "inf", "1e300", "'x'", "9007199254740993"}) {
    const std::string file = with("[[0,0," + std::string(wrong) + "],[1,0,0],[0,1,0],[0,0,1]]", "[]");
    EXPECT_THAT(refusal([&] { read_scene(file); }), HasSubstr("s.toml:12: block.1.vertices")) << wrong;
  }
}

// Empty tables are refused (also in tests/fuzz/corpus/model: no_joints.toml, no_stages.toml).
TEST_F(ReadBlockScene, TablesOfNothingAreRefused) {
  for (const std::string kind : {"joints", "materials"}) {
    std::string text = kOneBlock;
    const size_t first = text.find("[" + kind + "."), last = text.find("\n[", first);
    text.replace(first, last - first, "[" + kind + "]");
    EXPECT_THAT(refusal([&] { read_scene(write("s.toml", text)); }),
                AllOf(HasSubstr("s.toml:"), HasSubstr(kind), HasSubstr("at least one table [" + kind + ".NAME]")));
  }
  EXPECT_THAT(refusal([&] { read({"stage=[]"}); }),
              AllOf(HasSubstr("stage = []"), HasSubstr("tables [[stage]], at least one")));
}

TEST_F(ReadBlockScene, RulesOfJointsNameTwoBeginnings) {
  const auto scene = [&](const std::string& rule) {
    return read_scene(write("rules.toml", kOneBlock + "[[joint_rule]]\nfamily = \"dry\"\n" + rule));
  };
  const JointRule any = scene("").blocks->rules.at(0);
  EXPECT_EQ(any.normal, "any");
  EXPECT_THAT(any.between, ElementsAre("", ""));
  const JointRule rule = scene("normal = \"vertical\"\nbetween = [\"arch\", \"pier\"]\n").blocks->rules.at(0);
  EXPECT_EQ(rule.family, "dry");
  EXPECT_EQ(rule.normal, "vertical");
  EXPECT_THAT(rule.between, ElementsAre("arch", "pier"));
  for (const char* wrong : {"[\"a\"]", "[\"a\", 1]", "[1, \"a\"]", "[\"a\", \"b\", \"c\"]", "\"a\""})
    EXPECT_THAT(refusal([&] { scene(std::string("between = ") + wrong + "\n"); }),
                AllOf(HasSubstr("joint_rule.1.between"), HasSubstr("two beginnings of block names")));
}

TEST_F(ReadBlockScene, DeformableBlocksAreDividedOneWayOrTheOther) {
  EXPECT_THAT(fault("block.1.rigid=false"),
              HasSubstr("a deformable block needs zone_edge (m), divisions or tetrahedra"));
  EXPECT_EQ(read({"block.1.rigid=false", "block.1.zone_edge=0.5"}).blocks->blocks.at(0).zone_edge, 0.5);
  EXPECT_THAT(read({"block.1.rigid=false", "block.1.divisions=[1, 1, 1]"}).blocks->blocks.at(0).divisions,
              ElementsAre(1, 1, 1));
  EXPECT_THAT(fault("block.1.divisions=[1, 1, 1]"), HasSubstr("only with rigid = false"));
}

TEST_F(ReadBlockScene, LargeMotionFromTheStartIsNoLattice) {
  EXPECT_THAT(refusal([&] {
                read({"solver.kernels='lattice'", "contact.small_displacement=0"});
              }),
              HasSubstr("0 is large motion from the start"));
  EXPECT_EQ(read({"solver.kernels='lattice'", "contact.small_displacement=0.01"}).blocks->contact.small_displacement,
            0.01);
  EXPECT_EQ(read({"contact.small_displacement=0"}).blocks->contact.small_displacement, 0.0);
}

// Defaults are those of host/scenes/BLOCKS.md.
TEST_F(ReadBlockScene, WhatIsLeftOutIsAsThePageSays) {
  const Scene least = read_scene(write("least.toml", kOneBlock + R"(collapse = { displacement = 0.1 }
[[dry_wall]]
material = "stone"
courses = 2
units_per_course = 3
unit = [0.4, 0.2, 0.3]
opening = [{ from = 0.4, to = 0.8, sill = 0.0, head = 0.2 }]
[[arch]]
material = "stone"
radius = 1.0
thickness = 0.2
depth = 0.5
voussoirs = 9
[[block]]
material = "stone"
mesh = "stone.off"
)"));
  const BlocksSpec& blocks = least.blocks.value();
  const BlockSpec &box = blocks.blocks.at(0), &mesh = blocks.blocks.at(1);
  EXPECT_TRUE(box.rigid);
  EXPECT_FALSE(box.fixed);
  EXPECT_THAT(box.position, ElementsAre(0.0, 0.0, 0.0));
  EXPECT_THAT(box.rotation, ElementsAre(0.0, 0.0, 0.0));
  EXPECT_EQ(mesh.scale, 1.0);
  const DryWallSpec& wall = blocks.walls.at(0);
  EXPECT_TRUE(wall.rigid);
  EXPECT_FALSE(wall.mid_unit_joints);
  EXPECT_EQ(wall.bond, "running");
  EXPECT_EQ(wall.first_course, "whole");
  EXPECT_THAT(wall.origin, ElementsAre(0.0, 0.0, 0.0));
  EXPECT_EQ(wall.direction, 0.0);
  EXPECT_THAT(wall.trim_start, ElementsAre(0.0, 0.0));
  EXPECT_THAT(wall.trim_end, ElementsAre(0.0, 0.0));
  EXPECT_EQ(wall.openings.at(0).bearing, 0.0);
  const ArchSpec& arch = blocks.arches.at(0);
  EXPECT_TRUE(arch.rigid && arch.abutments);
  EXPECT_THAT(arch.centre, ElementsAre(0.0, 0.0, 0.0));
  EXPECT_THAT(arch.angles, ElementsAre(0.0, 180.0));
  EXPECT_EQ(blocks.contact.small_displacement, 0.005);
  EXPECT_FALSE(least.cubic_points.has_value());
  EXPECT_EQ(blocks.default_joint, "dry");
}

TEST_F(ReadBlockScene, SettingsAndStagesThatAreLeftOutAreAsThePageSays) {
  const Scene s = read_scene(write("stages.toml", kOneBlock + "[[stage]]\ncollapse = {}\n"), {});
  EXPECT_EQ(s.solver.damping, DampingKind::local);
  EXPECT_EQ(s.solver.local_damping, 0.8);
  EXPECT_EQ(s.solver.time_step_fraction, 0.6);
  EXPECT_EQ(s.solver.deformation_inertia, 1.0);
  EXPECT_EQ(s.solver.unit_inertia, 1.0);
  const Stage &first = s.stages.at(0), &last = s.stages.at(1);
  EXPECT_EQ(first.kind, "custom");
  EXPECT_EQ(first.ramp_time, 0.0);
  EXPECT_EQ(first.duration, 0.1);
  EXPECT_FALSE(first.equilibrium_ratio || first.displacement || first.collapse || first.ground);
  ASSERT_TRUE(last.collapse);
  EXPECT_EQ(last.collapse->direction, (Vec3{1, 0, 0}));
  EXPECT_EQ(last.collapse->start, 0.0);
  EXPECT_EQ(last.collapse->rate, 0.01);
  EXPECT_EQ(last.collapse->displacement, 0.01);
  EXPECT_EQ(last.collapse->limit, 2.0);
}

TEST_F(ReadBlockScene, AMeshInMillimetresIsScaled) {
  const auto scale = [&](const char* value) {
    return read_scene(write("scale.toml", kOneBlock + "[[block]]\nmaterial = \"stone\"\nmesh = " +
                                              "\"stone.off\"\nscale = " + value + "\n"))
        .blocks->blocks.at(1)
        .scale;
  };
  EXPECT_EQ(scale("0.001"), 0.001);
  EXPECT_THAT(refusal([&] { scale("0"); }), HasSubstr("block.2.scale"));
  EXPECT_THAT(fault("block.1.scale=0.001"), HasSubstr("only with mesh; remove it"));
}

// The inner radius of an arch must be above 0.
TEST_F(ReadBlockScene, ArchesAreThinnerThanTwiceTheirRadius) {
  const auto arch = [&](const char* thickness) {
    return read_scene(
        write("arch.toml", kOneBlock + "[[arch]]\nname = \"arch\"\nmaterial = \"stone\"\n" +
                               "radius = 1.0\ndepth = 0.5\nangles = [0, 180]\nvoussoirs = 9\nthickness = " + thickness +
                               "\n"));
  };
  EXPECT_EQ(arch("1.9").blocks->arches.at(0).thickness, 1.9);
  EXPECT_THAT(refusal([&] { arch("2.0"); }), HasSubstr("less than twice the radius"));
}

// Faults of arches and dry walls ended in messages about hulls and overlaps, or whole courses vanished.
TEST_F(ReadBlockScene, ArchesAndWallsThatCannotBeAreRefusedWithTheirKeys) {
  const auto arch = [&](const char* angles) {
    read_scene(write("arch.toml", kOneBlock +
                                      "[[arch]]\nname = \"arch\"\nmaterial = \"stone\"\nradius = 1.0\ndepth = 0.5\n"
                                      "thickness = 0.2\nvoussoirs = 9\nangles = " +
                                      angles + "\n"));
  };
  EXPECT_THAT(refusal([&] { arch("[90, 90]"); }), HasSubstr("arch.1.angles"));
  EXPECT_THAT(refusal([&] { arch("[0, 360]"); }), HasSubstr("arch.1.angles"));
  EXPECT_NO_THROW(arch("[0, 290]"));  // 354 degrees with the abutments
  const auto wall = [&](const char* keys) {
    read_scene(write("wall.toml", kOneBlock +
                                      "[[dry_wall]]\nname = \"wall\"\nmaterial = \"stone\"\ncourses = 2\n"
                                      "units_per_course = 4\nunit = [0.5, 0.2, 0.2]\norigin = [10, 0, 0]\n" +
                                      keys));
  };
  EXPECT_THAT(refusal([&] { wall("trim_start = [0, 3]"); }), HasSubstr("less than the length of the wall, 2 m"));
  EXPECT_THAT(refusal([&] { wall("trim_start = [1, 0]\ntrim_end = [1, 0]"); }), HasSubstr("trim_end"));
  EXPECT_THAT(refusal([&] { wall("trim_end = [-3, 0]"); }), HasSubstr("dry_wall.1.trim_end"));
  EXPECT_THAT(refusal([&] { wall("bond = \"third\"\nfirst_course = \"half\""); }), HasSubstr("first_course"));
}

TEST_F(ReadBlockScene, StagesThatEndByDisplacementNeedAMonitor) {
  EXPECT_THAT(fault("stage.1.displacement=0.01"),
              HasSubstr("--set: stage.1.displacement = 0.01: allowed: only with a block to measure; give monitor"));
  EXPECT_EQ(read({"stage.1.displacement=0.01", "stage.1.monitor=block"}).stages.at(0).monitor, "block");
  EXPECT_EQ(read({"stage.1.displacement=0.01", "output.monitor=block"}).output.monitor, "block");
}

// A stage of kind rest ends by equilibrium, within many steps unless it says how many.
TEST_F(ReadBlockScene, StagesOfRestHaveTheirOwnEnd) {
  std::string text = kOneBlock;
  text.replace(text.find("duration = 0.1"), 14, "kind = \"rest\"");
  const Stage usual = read_scene(write("s.toml", text)).stages.at(0);
  EXPECT_EQ(usual.max_steps, 1000000);
  EXPECT_EQ(usual.equilibrium_ratio, 1e-4);
  EXPECT_EQ(usual.ramp_time, 0.0);
  const Stage given = read_scene(write("s.toml", text + "max_steps = 7\nequilibrium_ratio = 1e-3\n")).stages.at(0);
  EXPECT_EQ(given.max_steps, 7);
  EXPECT_EQ(given.equilibrium_ratio, 1e-3);
  EXPECT_THAT(refusal([&] { read_scene(write("s.toml", text + "ramp_time = 0.1\n")); }), HasSubstr("none with kind"));
}

// The end of a stage that is given with a fault is named once, as in stages of walls.
TEST_F(ReadBlockScene, AFaultyEndIsNoMissingEnd) {
  const std::string text = refusal([&] { read({"stage=[{name='s',gravity=[0,-9.81,0],collapse=3}]"}); });
  EXPECT_THAT(text, AllOf(HasSubstr("stage.1.collapse"), Not(HasSubstr("never ends"))));
  EXPECT_THAT(refusal([&] { read({"stage=[{name='s',gravity=[0,-9.81,0]}]"}); }), HasSubstr("never ends"));
}

}  // namespace
}  // namespace quoin
