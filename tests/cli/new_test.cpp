// `quoin new`: the program checks and runs its scenes, and files are not overwritten.
#include <gmock/gmock.h>

#include "program.h"

namespace {

using ::testing::HasSubstr;

class New : public Cli {
 protected:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
};

TEST_F(New, ScenesThatItWritesRun) {
  // With a short last stage.
  for (const auto& [kind, shorter] : {std::pair<std::string, std::string>{"wall", "stage.shear.displacement=1e-5"},
                                      {"arch", "stage.push.collapse.limit=0.201"},
                                      {"facade", "stage.earthquake.duration=0.01"}}) {
    const std::string scene = file(kind + ".toml");
    ASSERT_EQ(quoin({"new", kind, scene}), 0) << error_;
    EXPECT_THAT(read_all(scene), HasSubstr("quoin run " + scene));
    EXPECT_EQ(quoin({"check", scene}), 0) << error_;
    EXPECT_THAT(out_ + error_, ::testing::Not(HasSubstr("warning"))) << kind;
    EXPECT_EQ(quoin({"run", scene, "--out", out(), "--threads", "1", "--set", shorter, "--set", "output.frames=0"}), 0)
        << error_;
  }
}

// A facade that is longer than its ground causes a warning; one that stands on the ground does not.
TEST_F(New, AGroundThatIsTooShortIsWarnedOf) {
  const std::string scene = file("facade.toml");
  ASSERT_EQ(quoin({"new", "facade", scene}), 0) << error_;
  std::string text = read_all(scene);
  for (const auto& [units, warned] : {std::pair<std::string, bool>{"10", false}, {"13", true}}) {
    const std::size_t at = text.find("units_per_course = ");
    std::ofstream(scene) << text.substr(0, at) + "units_per_course = " + units + text.substr(text.find('\n', at));
    ASSERT_EQ(quoin({"check", scene}), 0) << error_;
    // The ground ends at 5.9 m: of the units of 0.6 m those from 6.0 m on have no support.
    EXPECT_EQ(out_.find("stand on no fixed block: #") != std::string::npos, warned) << out_;
    if (!warned) continue;
    EXPECT_THAT(out_, HasSubstr("warning: 3 blocks of the lowest course stand on no fixed block"));
  }
}

// Three blocks above each other along z, with gravity along -z: their feet along y are equal, and none hangs.
TEST_F(New, TheLowestCourseIsThatAlongGravity) {
  const std::string scene = file("upright.toml");
  std::ofstream stream(scene);
  stream << dry_stone(35.0);
  for (const auto& [name, z] : {std::pair("base", 0.0), std::pair("low", 1.0), std::pair("high", 2.0)})
    stream << "[[block]]\nname = \"" << name << "\"\nmaterial = \"stone\"\n"
           << (z == 0.0 ? "fixed = true\n" : "") << "box = { lower = [0, 0, " << z << "], size = [1, 1, 1] }\n";
  stream << "[[stage]]\ngravity = [0, 0, -9.81]\nduration = 0.1\n[solver]\nkernels = \"general\"\n";
  stream.close();
  ASSERT_EQ(quoin({"check", scene}), 0) << error_;
  EXPECT_THAT(out_, ::testing::Not(HasSubstr("stand on no fixed block")));
}

TEST_F(New, ALawThatItWritesIsBuiltByTheCommandAtItsHead) {
  const std::string law = file("my_law.c"), library = file("my_law.so");
  ASSERT_EQ(quoin({"new", "law", law}), 0) << error_;
  const std::string text = read_all(law), api = QUOIN_TESTS "/../plugin_api";
  EXPECT_THAT(text, HasSubstr(law + " -o my_law.so"));
  const std::string command = "cc -std=c99 -O2 -fPIC -shared -I " + api + "/include -Wl,--version-script=" + api +
                              "/quoin.map " + law + " -lm -o " + library;
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(quoin({"models", library}), 0) << error_;
}

TEST_F(New, NothingIsWrittenOver) {
  const std::string scene = file("mine.toml");
  std::ofstream(scene) << "mine";
  EXPECT_EQ(quoin({"new", "wall", scene}), 3);
  EXPECT_THAT(error_, HasSubstr("--force"));
  EXPECT_EQ(read_all(scene), "mine");
  EXPECT_EQ(quoin({"new", "wall", scene, "--force"}), 0) << error_;
  EXPECT_THAT(read_all(scene), HasSubstr("[wall]"));
}

TEST_F(New, UnknownKindsAndNamesAreRefused) {
  EXPECT_EQ(quoin({"new", "wal", file("a.toml")}), 3);
  EXPECT_THAT(error_, HasSubstr("did you mean 'wall'?"));
  EXPECT_EQ(quoin({"new", "wall", file("a.txt")}), 3);
  EXPECT_THAT(error_, HasSubstr(".toml"));
  EXPECT_EQ(quoin({"new", "wall", file("nowhere/a.toml")}), 3);
}

// `quoin help run` is what many programs have beside `quoin run --help`.
TEST_F(New, HelpIsACommandToo) {
  EXPECT_EQ(quoin({"run", "--help"}), 0);
  const std::string of_run = out_;
  EXPECT_EQ(quoin({"help", "run"}), 0);
  EXPECT_EQ(out_, of_run);
  EXPECT_EQ(quoin({"help"}), 0);
  EXPECT_THAT(out_, HasSubstr("Exit codes"));
  EXPECT_EQ(quoin({"help", "rum"}), 2);
  EXPECT_THAT(error_, HasSubstr("did you mean 'run'?"));
}

TEST_F(New, UnknownCommandsAndOptionsAreNamedWithTheNearest) {
  EXPECT_EQ(quoin({"rum", small_}), 2);
  EXPECT_THAT(error_, HasSubstr("rum: no such command, did you mean 'run'?"));
  EXPECT_EQ(quoin({"run", small_, "--reprot"}), 2);
  EXPECT_THAT(error_, HasSubstr("--reprot: no such option, did you mean '--report'?"));
  EXPECT_EQ(quoin({"check"}), 2);
  EXPECT_THAT(error_, ::testing::Not(HasSubstr("no such")));
}

}  // namespace
