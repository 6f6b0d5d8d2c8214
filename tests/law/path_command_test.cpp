// `quoin path` through its command line: tables in and out, path tests, and every kind of bad input.
#include "cli/path_command.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "base/error.h"
#include "law/csv_table.h"
#include "law/formula.h"
#include "law/path_file.h"

namespace quoin {
namespace {

class PathCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string("quoin_path_") + test->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    const std::string file = (folder_ / name).string();
    std::ofstream(file) << text;
    return file;
  }
  std::string out() const { return (folder_ / "out.csv").string(); }

  // Returns the exit code of main; message_ has the message of a refusal.
  int run(std::vector<std::string> words) {
    CLI::App app;
    int exit_code = 0;
    message_.clear();
    add_path_command(app, exit_code);
    words.insert(words.begin(), "path");
    std::reverse(words.begin(), words.end());  // CLI11 expects them in reverse order
    try {
      app.parse(words);
    } catch (const CLI::ParseError& error) {
      message_ = error.what();
      return static_cast<int>(Exit::usage);
    } catch (const Error& error) {
      message_ = error.what();
      return static_cast<int>(error.exit_code);
    }
    return exit_code;
  }
  int elastic(const std::string& jumps) {
    return run({"--law", "elastic", "--set", "normal_stiffness=2e9", "--set", "shear_stiffness=1e9", "--jumps", jumps,
                "--out", out()});
  }

  std::filesystem::path folder_;
  std::string message_;
};

TEST_F(PathCommand, WritesOneRowPerIncrement) {
  ASSERT_EQ(elastic(write("in.csv", "dn (m),ds,dt (m)\n-1e-6,0,0\n-2e-6,1e-6,-3e-6\n")), 0) << message_;
  std::ifstream stream(out());
  std::string header;
  std::getline(stream, header);
  EXPECT_TRUE(header.starts_with("dn,ds,dt,sigma,tau_s,tau_t")) << header;
  EXPECT_TRUE(header.ends_with(
      "flags,energy_stored,dissipated_tension,dissipated_cohesion,dissipated_friction,dissipated_crushing,work"))
      << header;
  const CsvTable table = read_csv(out());
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_DOUBLE_EQ(table.rows[1][3], -4e3);
  EXPECT_DOUBLE_EQ(table.rows[1][4], 1e3);
  EXPECT_DOUBLE_EQ(table.rows[1][5], -3e3);
  // kn dn^2/2 + ks (ds^2 + dt^2)/2: the trapezoidal rule is exact, since the law is linear.
  EXPECT_NEAR(table.rows[1][table.column("work")], 0.5 * (4e3 * 2e-6 + 1e3 * 1e-6 + 3e3 * 3e-6), 1e-15);
  EXPECT_NEAR(table.rows[1][table.column("energy_stored")], table.rows[1][table.column("work")], 1e-15);
}

TEST_F(PathCommand, NormalStressControl) {
  for (const char* header : {"sigma,ds,dt", "sigma (Pa),ds (m),dt (m)"}) {
    ASSERT_EQ(elastic(write("in.csv", header + std::string("\n-1e6,0,0\n-1e6,1e-6,0\n"))), 0) << message_;
    const CsvTable table = read_csv(out());
    EXPECT_NEAR(table.rows[1][0], -5e-4, 1e-13);
    EXPECT_NEAR(table.rows[1][3], -1e6, 1e-4);
  }
}

// A dilating joint under constant pressure p. With linear softening, tau = c0 (1 - x) + mu p at the slip x su gives x.
// Uplift less closing is dn = tan(psi) su (x - x^2/2) - p/kn for x <= 1. No step of the law can lift a joint by more
// than its closing, 13 um; a row of these lifts it by up to 45 um. Exact, but for 1e-10 of the stress.
TEST_F(PathCommand, NormalStressControlFollowsDilationInRowsOfAnyLength) {
  constexpr double kKn = 30e9, kKs = 12e9, kP = 4e5, kC0 = 0.1e6, kG2 = 50.0, kRadian = M_PI / 180;
  std::vector<std::string> words = {"--law", "fracture_energy", "--out", out(), "--jumps", ""};
  for (const char* set : {"normal_stiffness=30e9", "shear_stiffness=12e9", "friction_angle=33", "dilation_angle=10",
                          "cohesion=0.1e6", "fracture_energy_shear=50"})
    words.insert(words.end(), {"--set", set});
  for (const char* law : {"fracture_energy", "cyclic_joint"}) {
    words[1] = law;
    std::map<int, CsvTable> tables;
    for (const int rows : {4, 10, 400}) {
      std::string text = "sigma,ds,dt\n-4e5,0,0\n";
      for (int i = 1; i <= rows; ++i) text += fmt::format("-4e5,{},0\n", 1.2e-3 * i / rows);
      words[5] = write("in.csv", text);
      ASSERT_EQ(run(words), 0) << law << ", " << rows << " rows: " << message_;
      const CsvTable& table = tables[rows] = read_csv(out());
      ASSERT_EQ(table.rows.size(), rows + 1u);
      EXPECT_GT(table.rows.back()[table.column("dissipated_friction")], 0.0);
      for (const std::vector<double>& row : table.rows) EXPECT_NEAR(row[3], -kP, 1e-9 * kP);
      if (law == std::string("cyclic_joint")) continue;  // its dilation has a length of its own
      const double su = kG2 / (kC0 / 2), mu = std::tan(33 * kRadian);
      for (const std::vector<double>& row : table.rows) {
        const double slip = std::max(0.0, (row[1] - (kC0 + mu * kP) / kKs) / (1 - kC0 / (kKs * su)));
        const double x = std::min(1.0, slip / su);
        EXPECT_NEAR(row[0], std::tan(10 * kRadian) * su * (x - x * x / 2) - kP / kKn, 1e-9 * su) << "ds = " << row[1];
      }
    }
    // What is dissipated is a sum over the parts of a row.
    for (const char* column : {"dn", "dissipated_friction", "dissipated_cohesion"}) {
      const int k = tables[4].column(column);
      const double fine = tables[400].rows.back()[k];
      EXPECT_NEAR(tables[4].rows.back()[k], fine, 1e-6 * std::abs(fine)) << law << ", " << column;
    }
  }
}

TEST_F(PathCommand, FractureEnergyColumnsAreThoseOfIssue2) {
  const std::string jumps = write("in.csv", "dn,ds,dt\n-1e-6,0,0\n-1e-6,1e-4,0\n-1e-6,3e-4,0\n");
  std::vector<std::string> words = {"--law", "fracture_energy", "--jumps", jumps, "--out",
                                    out(),   "--initial",       "bonded"};
  for (const char* set : {"normal_stiffness=82e9", "shear_stiffness=36e9", "cohesion=0.2e6", "friction_angle=30",
                          "fracture_energy_shear=30", "softening=table", "softening_table=0:1,0.3:0.5,1:0"}) {
    words.insert(words.end(), {"--set", set});
  }
  ASSERT_EQ(run(words), 0) << message_;
  std::ifstream stream(out());
  std::string header;
  std::getline(stream, header);
  EXPECT_EQ(header,
            "dn,ds,dt,sigma,tau_s,tau_t,xi_t,xi_s,w,v,slip,flags,energy_stored,dissipated_tension,dissipated_cohesion,"
            "dissipated_friction,dissipated_crushing,work");
  const CsvTable table = read_csv(out());
  ASSERT_EQ(table.rows.size(), 3u);
  const double slip = table.rows[1][table.column("slip")];
  EXPECT_NEAR(table.rows[1][4], 36e9 * (1e-4 - slip), 1e-6);
  // cumulative, never falling
  EXPECT_GE(table.rows[2][table.column("dissipated_cohesion")], table.rows[1][table.column("dissipated_cohesion")]);
  words[7] = "dry";
  ASSERT_EQ(run(words), 0) << message_;
  EXPECT_LT(read_csv(out()).rows[1][4], 0.06e6) << "a dry joint has friction alone";
  words[7] = "wet";
  EXPECT_EQ(run(words), 3);
}

TEST_F(PathCommand, BadTablesNameFileLineAndValue) {
  const auto refused = [&](const std::string& text, std::initializer_list<const char*> words) {
    EXPECT_EQ(elastic(write("bad.csv", text)), 3) << text;
    for (const char* word : words) EXPECT_NE(message_.find(word), std::string::npos) << word << " in: " << message_;
    EXPECT_FALSE(std::filesystem::exists(out())) << "nothing may be written for bad input";
  };
  refused("dn,ds,dt\n0,0,0\n0,zero,0\n", {"bad.csv:3", "zero", "ds"});
  refused("dn,ds,dt\n0,0\n", {"bad.csv:2", "2 values"});
  refused("dn,ds,dt\n0,nan,0\n", {"bad.csv:2", "nan", "finite"});
  refused("dn,ds,dt\n0,inf,0\n", {"bad.csv:2", "inf"});
  refused("dn,ds\n0,0\n", {"bad.csv", "dn (m), ds (m), dt (m)"});
  refused("dn (mm),ds,dt\n0,0,0\n", {"bad.csv", "with these units or without"});
  refused("dn,ds,ds\n0,0,0\n", {"bad.csv:1", "twice"});
  refused("dn,ds,dt\n", {"bad.csv", "no row"});
  refused("", {"bad.csv", "empty"});
  EXPECT_EQ(elastic((folder_ / "none.csv").string()), 3);
  EXPECT_NE(message_.find("no such file"), std::string::npos);
}

TEST_F(PathCommand, UsageAndRefusalsHaveTheirExitCodes) {
  const std::string jumps = write("in.csv", "dn,ds,dt\n0,0,0\n");
  EXPECT_EQ(run({}), 2);
  EXPECT_EQ(run({"--law", "elastic", "--jumps", jumps}), 2);
  EXPECT_EQ(run({"--nonsense"}), 2);
  EXPECT_EQ(run({"--law", "no_such_law", "--jumps", jumps, "--out", out()}), 4);
  EXPECT_EQ(run({"--law", "elastic", "--set", "normal_stiffness=-1", "--set", "shear_stiffness=1", "--jumps", jumps,
                 "--out", out()}),
            4);
  EXPECT_NE(message_.find("--set normal_stiffness"), std::string::npos) << message_;
  // The law lists its properties: they are not at fault.
  EXPECT_EQ(run({"--law", "elastic", "--set", "normal_stiffness=1e9", "--set", "shear_stiffness=1e9", "--set",
                 "nokey=1", "--jumps", jumps, "--out", out()}),
            4);
  EXPECT_NE(message_.find("--set nokey: nokey: unknown property"), std::string::npos) << message_;
  EXPECT_EQ(message_.find("--set normal_stiffness"), std::string::npos) << message_;
  EXPECT_EQ(run({"--law", "elastic", "--set", "normal_stiffness=x", "--jumps", jumps, "--out", out()}), 3);
}

constexpr char kElasticPath[] = R"toml(title = "Elastic"
law = "elastic"
let = ["twice = 2*kn"]
plot = ["dn sigma"]
[properties]
normal_stiffness = 2e9
shear_stiffness = 1e9
[[point]]
dn = 1e-6
steps = 4
along = ["sigma = kn*dn"]
expect = [{check = "sigma = twice*dn/2", value = 2e3}, "tau_s = 0"]
[[point]]
ds = "1e-6*sin(pi/2*part)"
dt = "1e-6*(1 - cos(pi/2*part))"
steps = 10
along = ["tau_s = ks*ds", {check = "tau <= 1.5*ks*1e-6"}]
)toml";

TEST_F(PathCommand, PathTestsPassAndFail) {
  EXPECT_EQ(run({write("good.toml", kElasticPath)}), 0) << message_;
  std::string wrong = kElasticPath;
  wrong.replace(wrong.find("kn*dn\""), 6, "3*dn\"");
  const PathOutcome outcome = run_path(read_path_file(write("wrong.toml", wrong)));
  EXPECT_EQ(outcome.failures.size(), 4u);
  EXPECT_EQ(run({write("wrong.toml", wrong)}), 5);
  const std::string good = write("good.toml", kElasticPath);
  EXPECT_EQ(run({good, write("wrong.toml", wrong)}), 5) << "the first was right";
  EXPECT_EQ(run({good, good, "--out", out()}), 2);
  EXPECT_EQ(message_, "path: --out takes one path test");
  EXPECT_EQ(run({good, "--out", out()}), 0) << message_;
}

// 2^53 + 1 rounds to 2^53.
TEST_F(PathCommand, IntegersThatNoDoubleEqualsAreRounded) {
  std::string text = kElasticPath;
  const std::string given = "shear_stiffness = 1e9";
  text.replace(text.find(given), given.size(), "shear_stiffness = 9007199254740993");
  std::vector<double> read;
  for (const PropertySetting& property : read_path_file(write("large.toml", text)).properties) {
    if (property.id == "shear_stiffness") read = property.numbers;
  }
  EXPECT_EQ(read, std::vector<double>{9007199254740992.0});
}

TEST_F(PathCommand, PlotsBesideTheClosedForm) {
  EXPECT_EQ(run({write("good.toml", kElasticPath), "--plot", folder_.string()}), 0) << message_;
  EXPECT_GT(std::filesystem::file_size(folder_ / "good.png"), 1000u);
}

TEST_F(PathCommand, BadPathFilesNameFileLineAndKey) {
  const auto refused = [&](const std::string& from, const std::string& to, std::initializer_list<const char*> words) {
    std::string text = kElasticPath;
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    EXPECT_EQ(run({write("bad.toml", text)}), 3) << to;
    for (const char* word : words) EXPECT_NE(message_.find(word), std::string::npos) << word << " in: " << message_;
  };
  refused("steps = 4", "stepz = 4", {"bad.toml:10", "stepz"});
  refused("steps = 4", "steps = 0.5", {"bad.toml:10", "0.5"});
  refused("steps = 4", "steps = 500000000", {"bad.toml:10", "500000000", "1 to 1e+08"});
  refused("sigma = kn*dn", "sigma = kn*nonsense", {"bad.toml:11", "nonsense"});
  refused("sigma = kn*dn", "sigma = kn*(dn", {"bad.toml:11", "')'"});
  refused("sigma = kn*dn", "sigma : kn*dn", {"bad.toml:11", "quantity = formula"});
  refused("twice = 2", "part = 2", {"bad.toml:3", "already has a meaning"});
  refused("tau_s = 0", "tension = 0", {"bad.toml:12", "tension"});
  refused("dn = 1e-6", "dn = 1e-6\nsigma = 0.0", {"bad.toml:8", "not both"});
  refused("law = \"elastic\"", "", {"bad.toml", "law is missing"});
  refused("title = \"Elastic\"", "title = Elastic", {"bad.toml:1"});
  refused("dn = 1e-6", "dn = inf", {"bad.toml:9", "dn = inf"});
  refused("steps = 4", "steps = 9007199254740993", {"bad.toml:10", "steps"});
  // A plot with one name or an empty name is refused and causes no std::out_of_range.
  for (const char* axes : {"plot = [\"dn \"]", "plot = [\"dn\"]", "plot = [\" sigma\"]"})
    refused("plot = [\"dn sigma\"]", axes, {"bad.toml:4", "write \"dn sigma\""});
  refused("value = 2e3", "value = nan", {"bad.toml:12", "value must be a number"});
}

TEST(Formula, Arithmetic) {
  const Variables variables{{"x", 3.0}, {"y", -2.0}};
  const auto value = [&](const char* text) { return Formula(text)(variables); };
  EXPECT_EQ(value("1 + 2*x^2 - y"), 21.0);
  EXPECT_EQ(value("-x^2"), -9.0);
  EXPECT_EQ(value("2^3^2"), 512.0);
  EXPECT_EQ(value("8/2/2"), 2.0);
  EXPECT_EQ(value("if(x > y, max(x, y), 7)"), 3.0);
  EXPECT_NEAR(value("tan(deg(45))"), 1.0, 1e-15);
  EXPECT_THROW(Formula("1 +"), std::invalid_argument);
  EXPECT_THROW(Formula("min(1)"), std::invalid_argument);
  EXPECT_THROW(Formula("1 2"), std::invalid_argument);
  EXPECT_THROW(value("z"), std::invalid_argument);
}

// Values to 1e-15: each is that of the C++ library, or exact.
TEST(Formula, EachFunctionIsThatOfItsName) {
  const Variables variables{{"a", 0.7}, {"b", -1.3}};
  const std::pair<const char*, double> cases[] = {
      {"a / b", 0.7 / -1.3},
      {"a^3", 0.343},
      {"a < b", 0.0},
      {"b < a", 1.0},
      {"a < a", 0.0},
      {"a > b", 1.0},
      {"a > a", 0.0},
      {"a <= a", 1.0},
      {"a <= b", 0.0},
      {"a >= a", 1.0},
      {"b >= a", 0.0},
      {"if(a < b, 2, 3)", 3.0},
      {"if(-1, 2, 3)", 2.0},
      {"sqrt(a)", std::sqrt(0.7)},
      {"exp(b)", std::exp(-1.3)},
      {"log(a)", std::log(0.7)},
      {"sin(b)", std::sin(-1.3)},
      {"cos(b)", std::cos(-1.3)},
      {"tan(b)", std::tan(-1.3)},
      {"atan(b)", std::atan(-1.3)},
      {"atan2(b, a)", std::atan2(-1.3, 0.7)},
      {"abs(b)", 1.3},
      {"min(a, b)", -1.3},
      {"max(b, a)", 0.7},
      {"hypot(3, 4)", 5.0},
      {"deg(180)", 3.14159265358979324},
      {"pi + .5e-1", 3.19159265358979324},
  };
  for (const auto& [text, expected] : cases) EXPECT_NEAR(Formula(text)(variables), expected, 1e-15) << text;
  EXPECT_TRUE(Formula("1 + min(a, 2*b)").uses("b"));
  EXPECT_FALSE(Formula("1 + min(a, 2*b)").uses("c"));
}

}  // namespace
}  // namespace quoin
