// Evaluation of the studies: verdicts, tables and sentences for curves of known shape, against closed forms. Without
// simulations and pictures; reference values are those of host/reproduce/REFERENCE_DATA.md and of the scenes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>

#include "base/error.h"
#include "reproduce/building_layouts.h"
#include "reproduce/loops.h"
#include "reproduce/study.h"

namespace {

namespace fs = std::filesystem;
using namespace quoin::reproduce;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// Linear up to the peak and from there to the end; points every 0.005 mm. kN, mm.
struct Shape {
  double peak = 50.0, at = 2.0, end_force = 40.0, end = 5.0;
};

Curve curve_of(
    const Shape& s, const std::function<double(double)>& more = [](double) { return 0.0; }) {
  Curve c;
  for (int i = 0; i <= std::lround(s.end / 0.005); ++i) {
    const double d = 0.005 * i;
    c.stage.push_back(2);
    c.displacement.push_back(d);
    c.force.push_back(more(d) +
                      (d <= s.at ? s.peak * d / s.at : s.peak + (s.end_force - s.peak) * (d - s.at) / (s.end - s.at)));
    c.vertical.push_back(99.0);
    c.unbalanced.push_back(0.01);
  }
  return c;
}

// Returns the curve of an elastic and perfectly plastic spring in cycles: kN/mm, kN. more: additional force at a
// displacement.
Curve spring_curve(
    const quoin::Cycles& cycles, double stiffness, double yield,
    const std::function<double(double)>& more = [](double) { return 0.0; }) {
  const quoin::CyclicMotion motion(cycles);
  Curve c;
  double plastic = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = motion.duration() * i / kSteps, d = 1e3 * motion.position(t);
    double force = stiffness * (d - plastic);
    if (std::abs(force) > yield)
      plastic = d - std::copysign(yield / stiffness, force), force = std::copysign(yield, force);
    c.stage.push_back(2), c.displacement.push_back(d), c.force.push_back(force + more(d));
    c.half_cycle.push_back(motion.half_cycle(t)), c.vertical.push_back(99.0), c.unbalanced.push_back(0.01);
  }
  return c;
}

class Verdicts : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("quoin_studies_" + std::to_string(getpid()));
    if (const char* path = std::getenv("PATH")) path_ = path;
    setenv("PATH", "/nonexistent", 1);  // without gnuplot: a notice in place of a chart
  }
  void TearDown() override {
    setenv("PATH", path_.c_str(), 1);
    fs::remove_all(folder_);
  }

  // Makes every run of the study complete, with equal curves until a test changes them.
  void start(const std::string& id, const std::string& quality = "standard") {
    study_ = find_study(id);
    ASSERT_NE(study_, nullptr);
    for (const Quality& q : qualities())
      if (q.name == quality) quality_ = q;
    runs_.clear();
    for (const RunSpec& spec : study_->runs(quality_)) {
      RunResult r;
      r.spec = spec;
      r.folder = folder_ / "runs" / spec.name;
      r.complete = true;
      r.curve = curve_of({});
      r.steps = 1000;
      r.wall_clock = 60.0;
      r.time_step = 0.6e-6, r.critical_time_step = 1e-6;
      r.bed_area = 0.099;
      runs_[spec.name] = r;
    }
  }
  RunResult& run(const std::string& name) {
    EXPECT_TRUE(runs_.contains(name)) << name;
    return runs_[name];
  }
  void read() { report_ = study_->report(Findings(folder_, study_->id, quality_, runs_)); }
  const Verdict& verdict(const std::string& beginning) const {
    for (const Verdict& v : report_.verdicts)
      if (v.claim.starts_with(beginning)) return v;
    throw std::runtime_error("no verdict " + beginning);
  }
  // Returns the row that begins with this text, of any table.
  std::vector<std::string> row(const std::string& first) const {
    for (const Table& t : report_.tables)
      for (const auto& r : t.rows)
        if (r[0] == first) return r;
    return {};
  }
  // Returns the value of an override of a run.
  std::string set(const std::string& name, const std::string& key) {
    for (const std::string& o : run(name).spec.overrides)
      if (o.starts_with(key + "=")) return o.substr(key.size() + 1);
    return "";
  }

  const Study* study_ = nullptr;
  Quality quality_;
  std::map<std::string, RunResult> runs_;
  StudyReport report_;
  fs::path folder_;
  std::string path_;
};

TEST_F(Verdicts, LawMeetsTable1ToAThousandth) {
  start("law");
  read();
  ASSERT_EQ(report_.verdicts.size(), 10u);
  const double mu = std::tan(35.0 * M_PI / 180.0);
  for (const auto& [claim, value] : {std::pair{"peak in tension", 0.2},
                                     {"area under the tension", 15.0},
                                     {"peak in shear at 0.30", 0.3 + mu * 0.30},
                                     {"peak in shear at 2.12", 0.3 + mu * 2.12},
                                     {"work above friction at 0.30", 125.0},
                                     {"work above friction at 1.21", 125.0},
                                     {"work above friction at 2.12", 125.0},
                                     {"peak in compression", 5.0},
                                     {"area under the compression", 8000.0}}) {
    EXPECT_NEAR(verdict(claim).number / value, 1.0, 2e-3) << claim;  // 4000 steps on curves of a few segments
    EXPECT_NEAR(*verdict(claim).reference / value, 1.0, 1e-12) << claim;
    EXPECT_TRUE(verdict(claim).reproduced) << claim;
  }
}

// Peaks of the tests are the printed regression times 0.099 m2.
TEST_F(Verdicts, WallsAreHeldAgainstTheRegression) {
  start("walls");
  const std::pair<const char*, double> walls[] = {{"0.30 MPa", 0.30}, {"1.21 MPa", 1.21}, {"2.12 MPa", 2.12}};
  for (const auto& [name, pressure] : walls)
    run(name).curve = curve_of({1.10 * 99.0 * (0.45 + 0.24 * pressure), 2.3, 30.0, 5.0});
  run("1.21 MPa").curve = curve_of({1.16 * 99.0 * (0.45 + 0.24 * 1.21), 2.3, 30.0, 5.0});
  run("0.30 MPa").curve.vertical.assign(run("0.30 MPa").curve.size(), 99.0);
  read();
  for (const auto& [name, pressure] : walls) {
    const Verdict& v = verdict(std::string("peak of the solid wall at ") + name);
    EXPECT_NEAR(*v.reference, 99.0 * (0.45 + 0.24 * pressure), 0.05) << name;  // printed to 0.1 kN
    EXPECT_EQ(v.reproduced, pressure != 1.21) << name;
    EXPECT_THAT(v.text, HasSubstr("at 2.30 mm"));
    EXPECT_THAT(v.text, HasSubstr(pressure != 1.21 ? "+10 %" : "+16 %"));
    EXPECT_THAT(row(name)[4], HasSubstr("1.00 MPa")) << "99 kN on 0.099 m2";
  }
  EXPECT_THAT(report_.agrees, Not(Contains(HasSubstr("within 15 %"))));
  EXPECT_THAT(report_.differs, Contains(HasSubstr("by +10 to +16 %: not all within 15 %")));
  // host/reproduce/REFERENCE_DATA.md, mean vertical stress at the peak.
  EXPECT_THAT(row("0.30 MPa")[4], HasSubstr("tests 0.76 [D]"));
  EXPECT_THAT(row("1.21 MPa")[4], HasSubstr("tests 1.36 [D]"));
  EXPECT_THAT(row("2.12 MPa")[4], HasSubstr("tests 1.97 [D]"));
  EXPECT_THAT(row("0.30 MPa")[7], "51 kN");  // raw tests: 50 to 52, about 72, about 97
  EXPECT_THAT(row("1.21 MPa")[7], "72 kN");
  EXPECT_THAT(row("2.12 MPa")[7], "97 kN");
  const double ratio = (0.45 + 0.24 * 2.12) / (0.45 + 0.24 * 0.30);
  EXPECT_NEAR(verdict("strength grows").number, ratio, 1e-9);
  EXPECT_NEAR(*verdict("strength grows").reference, ratio, 2e-3);
  EXPECT_TRUE(verdict("strength grows").reproduced);
  run("2.12 MPa").curve = curve_of({1.19 * run("0.30 MPa").curve.peak(), 2.0, 30.0, 5.0});
  read();
  EXPECT_FALSE(verdict("strength grows").reproduced);
}

// Peaks on the line tau = 0.40 + 0.30 sigma, with a stress at the peak of 1.5 times the initial one.
TEST_F(Verdicts, EnvelopeFindsTheLineThatPeaksLieOn) {
  start("envelope");
  for (const auto& [name, pressure] : {std::pair{"0.30 MPa", 0.30}, {"1.21 MPa", 1.21}, {"2.12 MPa", 2.12}}) {
    Curve c = curve_of({99.0 * (0.40 + 0.30 * pressure), 2.0, 20.0, 5.0});
    c.vertical.assign(c.size(), 99.0 * 1.5 * pressure);
    run(name).curve = c;
  }
  read();
  EXPECT_NEAR(verdict("cohesion of the wall, initial").number, 0.40, 1e-9);
  EXPECT_NEAR(verdict("friction of the wall, initial").number, 0.30, 1e-9);
  EXPECT_NEAR(verdict("cohesion of the wall, stress at the peak").number, 0.40, 1e-9);
  EXPECT_NEAR(verdict("friction of the wall, stress at the peak").number, 0.20, 1e-9);
  EXPECT_NEAR(verdict("linear regressions").number, 1.0, 1e-12);
  // Equation 6: c and mu over 1 + mu 2 h/l of the bare brick.
  EXPECT_NEAR(verdict("Mann-Mueller cohesion").number, 0.3 / (1 + 0.7 * 2 * 50.0 / 204.0), 1e-12);
  EXPECT_NEAR(verdict("Mann-Mueller friction").number, 0.7 / (1 + 0.7 * 2 * 50.0 / 204.0), 1e-12);
  for (const auto& [claim, printed] : {std::pair{"cohesion of the wall, initial", 0.45},
                                       {"friction of the wall, initial", 0.24},
                                       {"cohesion of the wall, stress at the peak", 0.25},
                                       {"friction of the wall, stress at the peak", 0.36},
                                       {"Mann-Mueller cohesion", 0.22},
                                       {"Mann-Mueller friction", 0.52},
                                       {"linear regressions", 0.99}})
    EXPECT_EQ(verdict(claim).reference, printed) << claim;
  // Points of the tests in the chart are their regression, whose peaks are printed to 0.1 kN on 99 000 mm2.
  std::ifstream points(folder_ / "envelope/plots/envelope_3.dat");
  for (const double pressure : {0.30, 1.21, 2.12}) {
    double sigma = 0.0, tau = 0.0;
    points >> sigma >> tau;
    EXPECT_EQ(sigma, pressure);
    EXPECT_NEAR(tau, 0.45 + 0.24 * pressure, 0.05 / 99.0);
  }
  EXPECT_TRUE(verdict("cohesion of the wall, initial").reproduced);   // 11 % off
  EXPECT_FALSE(verdict("friction of the wall, initial").reproduced);  // 25 % off

  // Lines in the chart, to 2.4 MPa: two of the model, two of the tests, and that of Mann and Mueller.
  const double mann = 1 + 0.7 * 2 * 50.0 / 204.0;
  const std::pair<double, double> lines[] = {
      {0.40, 0.30}, {0.40, 0.20}, {0.45, 0.24}, {0.25, 0.36}, {0.3 / mann, 0.7 / mann}};
  for (int i = 0; i < 5; ++i) {
    std::ifstream ends(folder_ / fmt::format("envelope/plots/envelope_{}.dat", 5 + i));
    double x0 = -1.0, y0 = -1.0, x1 = -1.0, y1 = -1.0;
    ends >> x0 >> y0 >> x1 >> y1;
    EXPECT_EQ(x0, 0.0) << i;
    EXPECT_EQ(x1, 2.4) << i;
    EXPECT_NEAR(y0, lines[i].first, 1e-5) << i;
    EXPECT_NEAR(y1, lines[i].first + 2.4 * lines[i].second, 1e-5) << i;
  }

  // A point off the line: R2 is 1 - (sum of squared residuals)/(sum of squares about the mean), for least squares the
  // square of the correlation.
  run("1.21 MPa").curve.force.assign(run("1.21 MPa").curve.size(), 99.0 * 1.0);
  read();
  const double x[] = {1.5 * 0.30, 1.5 * 1.21, 1.5 * 2.12}, y[] = {0.40 + 0.30 * 0.30, 1.0, 0.40 + 0.30 * 2.12};
  const double xm = (x[0] + x[1] + x[2]) / 3, ym = (y[0] + y[1] + y[2]) / 3;
  double xx = 0.0, xy = 0.0, yy = 0.0, left = 0.0;
  for (int i = 0; i < 3; ++i) xx += (x[i] - xm) * (x[i] - xm), xy += (x[i] - xm) * (y[i] - ym);
  for (int i = 0; i < 3; ++i) {
    const double off = y[i] - ym - xy / xx * (x[i] - xm);
    yy += (y[i] - ym) * (y[i] - ym), left += off * off;
  }
  EXPECT_NEAR(verdict("linear regressions").number, 1 - left / yy, 1e-9);
  EXPECT_LT(verdict("linear regressions").number, 0.8);
  EXPECT_FALSE(verdict("linear regressions").reproduced);
}

// Drops of the force by 5 % of the peak before 1.2 mm count as an oscillation; drops by 1 % do not.
TEST_F(Verdicts, RateReadsOscillationsAndDistances) {
  start("rate");
  for (const auto& [name, r] : runs_) EXPECT_EQ(set(name, "stage.shear.displacement"), "0.0025") << name;
  // Ramps have an equal distance of 0.05 mm, if they are not longer than 50 ms.
  EXPECT_EQ(set("10 mm/s", "stage.shear.ramp_time"), "0.01");
  EXPECT_EQ(set("1 mm/s", "stage.shear.ramp_time"), "0.05");
  EXPECT_EQ(set("320 mm/s", "stage.shear.ramp_time"), "0.0003125");
  const auto fall = [](double part) {
    return [part](double d) { return d > 0.5 && d < 0.5 + 1e-9 + 0.005 ? -part * 50.0 - 0.005 * 25.0 : 0.0; };
  };
  run("10 mm/s, at once").curve = curve_of({50.0, 2.0, 40.0, 2.5}, fall(0.05));
  run("160 mm/s").curve = curve_of({50.0, 2.0, 40.0, 2.5}, fall(0.03));
  run("320 mm/s").curve = curve_of({50.0, 2.0, 40.0, 2.5}, fall(0.04));
  run("80 mm/s").curve.unbalanced.assign(run("80 mm/s").curve.size(), 0.08);
  run("1 mm/s").curve.unbalanced.assign(run("1 mm/s").curve.size(), 0.005);
  run("10 mm/s").curve = curve_of({50.0, 2.0, 40.0, 2.5}, [](double d) { return d > 1.0 ? 3.0 : 0.0; });
  run("1 mm/s").curve.force = curve_of({50.0, 2.0, 40.0, 5.0}).force;
  read();
  EXPECT_NEAR(verdict("10 mm/s oscillates").number, 5.0, 0.01);
  EXPECT_TRUE(verdict("10 mm/s oscillates").reproduced);
  EXPECT_THAT(verdict("10 mm/s oscillates").text, HasSubstr("begins at 160 mm/s"));
  EXPECT_NEAR(verdict("unbalanced ratio").number, 16.0, 1e-9);
  EXPECT_FALSE(verdict("unbalanced ratio").reproduced) << "20 mm/s has as much as 10 mm/s";
  // The distance is largest at 2.45 mm, relative to the peak of the slower run. From 2 mm on the curves fall by 20 and
  // 10/3 kN/mm, with 3 kN between them.
  EXPECT_NEAR(verdict("10 mm/s and 1 mm/s agree").number, 100.0 * (0.45 * (20.0 - 10.0 / 3.0) - 3.0) / 50.0, 0.35);
  EXPECT_THAT(report_.differs, Not(Contains(HasSubstr("10 mm/s does oscillate"))));

  // A sudden velocity causes a wave into the wall, A v sqrt(5 rho G), with bricks and bed joints in series (Table 1).
  run("10 mm/s, at once").curve = curve_of({50.0, 2.0, 40.0, 2.5}, fall(0.01));
  read();
  EXPECT_FALSE(verdict("10 mm/s oscillates").reproduced);
  const double shear_modulus = 16.7e9 / (2 * 1.15), joints = 36e9 / 16, series = 1 / (1 / shear_modulus + 1 / joints);
  const double wave = 0.099 * 0.01 * std::sqrt(5 * 1900.0 * series) / 1e3;  // 16 joints in a metre
  EXPECT_THAT(report_.differs, Contains(AllOf(HasSubstr("10 mm/s does oscillate"), HasSubstr("the 2 %"),
                                              HasSubstr(fmt::format("rho G): {:.1f} kN", wave)))));
  EXPECT_THAT(row("10 mm/s, at once")[1], "0.60");
  run("10 mm/s, at once, step 0.8").complete = false;
  run("10 mm/s, at once, step 0.8").steps = 4321;
  read();
  EXPECT_THAT(row("10 mm/s, at once, step 0.8")[2], "numerical failure at step 4321");
}

TEST_F(Verdicts, RatioOfUnbalancedForcesFallsWithEveryStepDown) {
  start("rate");
  double ratio = 0.01;
  for (const char* name : {"1 mm/s", "10 mm/s", "20 mm/s", "40 mm/s", "80 mm/s", "160 mm/s", "320 mm/s"})
    run(name).curve.unbalanced.assign(run(name).curve.size(), ratio *= 2);
  read();
  EXPECT_TRUE(verdict("unbalanced ratio").reproduced);
  EXPECT_NEAR(verdict("unbalanced ratio").number, 16.0, 1e-9);
}

TEST_F(Verdicts, BrittleIsLowerAndRougher) {
  start("brittle");
  EXPECT_EQ(run("brittle, 1.21 MPa").spec.law, "coulomb_slip");
  EXPECT_EQ(set("no crushing, 1.21 MPa", "joints.mortar.compressive_strength"), "inf");
  EXPECT_EQ(set("no crushing, 1.21 MPa", "joints.unit.compressive_strength"), "inf");
  EXPECT_EQ(set("brittle, 1.21 MPa", "stage.shear.velocity"), "") << "standard is slow enough for brittle walls";
  for (const auto& [name, r] : runs_)
    if (name.ends_with("as printed") || name.ends_with("step 0.8")) {
      EXPECT_EQ(set(name, "stage.shear.displacement"), "0.0025") << name;
      EXPECT_EQ(r.spec.law, name.starts_with("brittle") ? "coulomb_slip" : "") << name;
      EXPECT_EQ(set(name, "stage.shear.velocity"), name.ends_with("0.8") ? "0.01" : "0.001") << name;
      EXPECT_EQ(set(name, "solver.time_step_fraction"), name.ends_with("0.8") ? "0.8" : "0.6") << name;
    }
  // Constant from 0.05 mm on, with waves of ten points each, whose highest point is at 72 degrees.
  const auto level = [](double force, double amplitude, double end = 5.0) {
    return curve_of({force, 0.05, force, end}, [=](double d) { return amplitude * std::sin(2 * M_PI * d / 0.05); });
  };
  const auto peak = [](double force, double amplitude) { return force + amplitude * std::sin(0.4 * M_PI); };
  const auto rough = [&](double force, double amplitude) { return amplitude / peak(force, amplitude); };
  for (const char* w : {"0.30 MPa", "1.21 MPa", "2.12 MPa"}) {
    run(w).curve = level(50.0, 0.1);
    run(std::string("brittle, ") + w).curve = level(40.0, 0.4);
  }
  run("brittle, 2.12 MPa").curve = level(49.0, 0.12);
  run("no crushing, 2.12 MPa").curve = curve_of({55.0, 2.0, 50.0, 5.0});
  run("softening, 0.30 MPa, as printed").curve = level(50.0, 0.1, 2.5);
  run("brittle, 0.30 MPa, as printed").curve = level(50.0, 0.5, 2.5);
  read();
  EXPECT_NEAR(verdict("brittle is lower at 1.21").number, peak(40.0, 0.4) / peak(50.0, 0.1), 1e-9);
  EXPECT_TRUE(verdict("brittle is lower at 1.21").reproduced);
  EXPECT_FALSE(verdict("brittle is lower at 2.12").reproduced);
  EXPECT_NEAR(verdict("brittle is irregular at 1.21").number, rough(40.0, 0.4) / rough(50.0, 0.1), 0.01);
  EXPECT_NEAR(verdict("brittle is irregular at 0.30").number, rough(50.0, 0.5) / rough(50.0, 0.1), 0.05)
      << "as printed";
  EXPECT_THAT(verdict("brittle is irregular at 0.30").text, HasSubstr("of this quality, at 20 mm/s"));
  // Waves with equal shares of their peaks at both velocities.
  EXPECT_THAT(verdict("brittle is irregular at 0.30").text,
              AllOf(HasSubstr("roughness 0.74 against 0.15 % of the peak at 1 mm/s"),
                    HasSubstr("at 20 mm/s, 0.74 against 0.15 %,")));
  EXPECT_TRUE(verdict("brittle is irregular at 1.21").reproduced);
  EXPECT_FALSE(verdict("brittle is irregular at 2.12").reproduced);
  EXPECT_THAT(report_.differs, Contains(AllOf(HasSubstr("(49.1 against 50.1 kN)"), HasSubstr("reaches 55.0 kN"),
                                              HasSubstr("crushing is the cause"))));
  run("no crushing, 2.12 MPa").curve = curve_of({45.0, 2.0, 40.0, 5.0});
  read();
  EXPECT_THAT(report_.differs, Contains(HasSubstr("crushing alone does not explain it")));
}

// An opening is in the middle of 9 half bricks and 16 courses, or half of a half brick beside it.
TEST_F(Verdicts, HollowWallsHaveOpeningsInTheMiddle) {
  start("hollow");
  int openings = 0;
  const std::regex words("(\\d) half bricks?(, (\\d) courses)?.*");
  for (const auto& [name, r] : runs_) {
    if (name.find("printed") != std::string::npos) {
      EXPECT_EQ(set(name, "stage.shear.displacement"), "0.005");
      continue;
    }
    if (name.find("hexahedra") != std::string::npos) continue;
    ++openings;
    std::smatch reported;
    ASSERT_TRUE(std::regex_match(name, reported, words)) << name;
    const std::string opening = "wall.opening.1.";
    const int half_units = std::stoi(set(name, opening + "half_units")),
              courses = std::stoi(set(name, opening + "courses"));
    EXPECT_EQ(half_units, std::stoi(reported[1])) << name;
    EXPECT_EQ(courses, reported[3].matched ? std::stoi(reported[3]) : 6) << name;
    const double middle = std::stoi(set(name, opening + "first_half_unit")) + 0.5 * half_units;
    EXPECT_NEAR(middle, 4.5, half_units % 2 == 0 ? 0.5 : 0.0) << name;
    EXPECT_EQ(std::stoi(set(name, opening + "first_course")) + 0.5 * courses, 8.0) << name;
    EXPECT_EQ(
        set(name, "stage.shear.displacement"),
        name == "2 half bricks" || name == "3 half bricks" || name == "2 half bricks, the other way" ? "" : "0.006")
        << name;
  }
  EXPECT_EQ(openings, 8);
  // One of even width is half of a half brick beside the middle, and its variant on the other side.
  EXPECT_EQ(set("2 half bricks", "wall.opening.1.first_half_unit"), "4");
  EXPECT_EQ(set("2 half bricks, the other way", "wall.opening.1.first_half_unit"), "3");

  run("2 half bricks").curve = curve_of({45.0, 3.0, 30.0, 20.0});
  run("1 half brick").curve = curve_of({60.0, 3.0, 30.0, 6.0});
  run("3 half bricks").curve = curve_of({33.0, 3.0, 30.0, 6.0});
  run("2 half bricks, 8 x 4 x 2 hexahedra").curve = curve_of({70.0, 3.0, 30.0, 6.0});
  run("2 half bricks, as printed").curve = curve_of({20.0, 3.0, 10.0, 5.0});
  read();
  const Verdict& v = verdict("peak in the range of the tests");
  EXPECT_NEAR(v.number, 45.0, 1e-9);
  EXPECT_EQ(v.reference, 30.0);  // the middle of 20 to 40
  EXPECT_FALSE(v.reproduced);
  EXPECT_THAT(v.text, AllOf(HasSubstr("45.0 kN at 3.0 mm"), HasSubstr("as printed 20.0 kN, finer zones 70.0 kN"),
                            HasSubstr("other openings 33.0 to 60.0 kN")));
  EXPECT_THAT(report_.differs, Contains(HasSubstr("33.0 kN with half a brick more")));
  EXPECT_THAT(row("2 half bricks")[3], "30.0 kN at 20 mm");
  run("2 half bricks").curve = curve_of({40.0, 3.0, 30.0, 20.0});
  read();
  EXPECT_TRUE(verdict("peak in the range of the tests").reproduced);
  EXPECT_TRUE(report_.differs.empty());
  run("2 half bricks").curve = curve_of({19.9, 3.0, 10.0, 20.0});
  read();
  EXPECT_FALSE(verdict("peak in the range of the tests").reproduced);
}

TEST_F(Verdicts, ContactPointsAreComparedWithTheFinest) {
  start("contact_points");
  run("B2T4").curve = curve_of({56.0, 2.0, 40.0, 5.0});
  run("B2T8").curve = curve_of({52.0, 2.0, 40.0, 5.0});
  read();
  EXPECT_NEAR(verdict("moderate equals fine").number, 4.0, 1e-9);
  EXPECT_TRUE(verdict("moderate equals fine").reproduced);
  EXPECT_NEAR(verdict("few points").number, 12.0, 1e-9);
  EXPECT_TRUE(verdict("few points").reproduced);
  // The number of points along the edge of a half brick is one more than that of hexahedra.
  EXPECT_EQ(set("B2T4", "wall.zones"), "[2, 1, 1]");
  EXPECT_EQ(set("B2T16", "wall.zones"), "[8, 4, 2]");
  EXPECT_EQ(row("B2T4")[2], "3");
  EXPECT_EQ(row("B2T8")[2], "5");
  EXPECT_EQ(row("B2T16")[2], "9");
  // A difference of more than 5 % of the 50 kN of the finest zones.
  run("B2T4").curve = curve_of({52.25, 2.0, 40.0, 5.0});
  read();
  EXPECT_FALSE(verdict("few points").reproduced);
  run("B2T4").curve = curve_of({52.75, 2.0, 40.0, 5.0});
  read();
  EXPECT_TRUE(verdict("few points").reproduced);
}

TEST_F(Verdicts, StiffnessIsATimesThatOfTheMortarJoint) {
  start("stiffness");
  for (const int ratio : {1, 2, 3, 4, 6, 10})
    for (const char* key : {"joints.unit.normal_stiffness", "joints.unit.shear_stiffness"})
      for (const std::string& name : {fmt::format("{}", ratio), fmt::format("{}, as printed", ratio)})
        if (runs_.contains(name)) {
          EXPECT_DOUBLE_EQ(std::stod(set(name, key)), ratio * 82e9) << name;  // mortar: 82 GPa/m
        }
  for (const auto& [name, r] : runs_)
    if (name.find("printed") != std::string::npos) {
      EXPECT_EQ(set(name, "stage.shear.displacement"), "0.0025") << name;
    }
  run("1").curve = curve_of({45.0, 2.0, 40.0, 5.0});
  run("3").curve = curve_of({90.0, 2.0, 40.0, 5.0});
  run("4").curve = curve_of({50.5, 2.0, 40.4, 5.0});                             // 1 % more everywhere
  run("6").curve = curve_of({}, [](double d) { return d > 2.2 ? -3.0 : 0.0; });  // only after the peak
  run("4, as printed").curve = curve_of({}, [](double d) { return d > 2.1 && d < 2.25 ? -4.0 : 0.0; });
  run("6, as printed").curve = curve_of({}, [](double d) { return d > 2.3 ? -2.0 : 0.0; });
  run("4, as printed, step 0.8").complete = false;
  read();
  EXPECT_NEAR(verdict("peaks are the same from ratio 4").number, 1.0, 1e-9);
  EXPECT_THAT(verdict("peaks are the same from ratio 4").text, HasSubstr("at 1 -10.0 %"));
  EXPECT_NEAR(verdict("curves are the same from ratio 4").number, 6.0, 0.02);  // 3 of 50 kN
  EXPECT_FALSE(verdict("curves are the same from ratio 4").reproduced);
  EXPECT_THAT(verdict("curves are the same from ratio 4").text,
              HasSubstr("as printed 8.0 %: at the drop; there 0.0 % up to 2 mm and 4.0 % from 2.3 mm on"));
  EXPECT_THAT(report_.differs, Contains(HasSubstr("differ by 6 % of the peak")));
  EXPECT_THAT(report_.differs, Contains(HasSubstr("Up to 2 mm they differ by 1.0 %")));
  EXPECT_EQ(row("4, as printed, step 0.8")[1], "numerical failure at step 1000");
  EXPECT_EQ(row("1")[4], "4.700 mm");  // 45 to 40 kN from 2 to 5 mm: 0.9 of the peak
  EXPECT_EQ(row("2")[4], "3.500 mm");
}

TEST_F(Verdicts, BlockSizesSpreadAndFall) {
  start("block_size");
  const auto peaks = [&](double a, double b, double c, double d) {
    const char* names[] = {"60 blocks", "144 blocks", "240 blocks", "576 blocks"};
    const double values[] = {a, b, c, d};
    for (int i = 0; i < 4; ++i) run(names[i]).curve = curve_of({values[i], 2.0, 40.0, 5.0});
  };
  run("576 blocks").wall_clock = 600.0;
  peaks(105.0, 104.0, 101.5, 100.0);
  read();
  EXPECT_NEAR(verdict("peaks within 6 %").number, 5.0, 1e-9);
  EXPECT_TRUE(verdict("peaks within 6 %").reproduced);
  EXPECT_NEAR(verdict("the peak falls").number, 100.0 * (100.0 / 105.0 - 1.0), 1e-9);
  EXPECT_TRUE(verdict("the peak falls").reproduced);
  EXPECT_THAT(verdict("the peak falls").text,
              HasSubstr("60: 105.0, 144: 104.0, 240: 101.5, 576: 100.0 kN, each to 1 %"));
  EXPECT_NEAR(verdict("240 and 576 blocks").number, 1.5, 1e-9);
  EXPECT_EQ(verdict("240 and 576 blocks").text, "101.5 and 100.0 kN: +1.5 %");
  EXPECT_TRUE(verdict("240 and 576 blocks").reproduced);
  EXPECT_NEAR(verdict("time for the 576-block wall").number, 10.0, 1e-12);
  EXPECT_THAT(verdict("time for the 576-block wall").text, HasSubstr("14.0 times as fast"));
  EXPECT_THAT(row("0")[6], "60 s");
  peaks(100.0, 100.9, 101.8, 102.7);  // each is above the last one by less than its error of 1 %
  read();
  EXPECT_TRUE(verdict("the peak falls").reproduced);
  peaks(100.0, 101.1, 100.0, 106.5);
  read();
  EXPECT_FALSE(verdict("the peak falls").reproduced);
  EXPECT_FALSE(verdict("peaks within 6 %").reproduced);
  EXPECT_FALSE(verdict("240 and 576 blocks").reproduced);
}

TEST_F(Verdicts, EnergiesAreFactorsOnTable1) {
  start("energy");
  for (const double f : {0.5, 2.0, 4.0}) {
    const std::string name = fmt::format("x {}", f);
    EXPECT_DOUBLE_EQ(std::stod(set(name, "joints.mortar.fracture_energy_tension")), 15 * f);
    EXPECT_DOUBLE_EQ(std::stod(set(name, "joints.mortar.fracture_energy_shear")), 125 * f);
  }
  EXPECT_EQ(set("x 1", "joints.mortar.fracture_energy_shear"), "") << "as in the scene";
  // 80 % of the peak is on a line from the peak at 2 mm to half of the peak.
  const auto shape = [](double peak, double end) { return curve_of({peak, 2.0, 0.5 * peak, end}); };
  run("x 0.5").curve = shape(46.0, 3.0);  // at 2.4 mm
  run("x 1").curve = shape(50.0, 4.0);
  run("x 2").curve = shape(53.0, 5.0);
  run("x 4").curve = curve_of({53.5, 2.0, 50.0, 6.0});  // never: 6 mm
  read();
  EXPECT_NEAR(verdict("the peak changes").number, -8.0, 1e-9);
  EXPECT_TRUE(verdict("the peak changes").reproduced);
  EXPECT_THAT(verdict("the peak changes").text, HasSubstr("-8.0 %, at factor 0.5"));
  EXPECT_NEAR(verdict("ductility grows").number, 6.0 / 2.4, 0.01);
  EXPECT_TRUE(verdict("ductility grows").reproduced);
  EXPECT_EQ(row("4")[4], "not before the end");
  EXPECT_EQ(row("1")[5], "0.50");
  run("x 2").curve = shape(60.0, 2.5);
  read();
  EXPECT_FALSE(verdict("the peak changes").reproduced);
  EXPECT_FALSE(verdict("ductility grows").reproduced);
}

TEST_F(Verdicts, BuildingIsHeldAgainstTheTestAndTable2) {
  start("building");
  // The slowest run is the converged one; the cost of runs is proportional to their time.
  const char* slow_d = "wall D, 2.5 mm/s";
  const char* slow_abc = "walls A + B + C, 2.5 mm/s";
  EXPECT_DOUBLE_EQ(run(slow_d).spec.cost, 8.0 * run("wall D").spec.cost);
  EXPECT_EQ(set("wall D", "stage.push.velocity"), "0.02");
  EXPECT_EQ(set(slow_d, "stage.push.velocity"), "0.0025");
  EXPECT_EQ(set(slow_d, "stage.push.displacement"), "0.018");
  EXPECT_EQ(set("wall D", "stage.push.displacement"), "");
  // Lintels have a factor on the 2.4 GPa of units; every opening of wall D (4) and of wall B (6) has one.
  for (const auto& [name, factor, openings] : {std::tuple{"wall D, lintels x 3", 3.0, 4},
                                               {"wall D, lintels x 12", 12.0, 4},
                                               {"walls A + B + C, lintels x 12", 12.0, 6}}) {
    EXPECT_THAT(set(name, "materials.lintel"), HasSubstr(fmt::format("young_modulus = {:g},", factor * 2.4e9)));
    for (int i = 1; i <= openings; ++i)
      EXPECT_EQ(set(name, fmt::format("building.wall.1.opening.{}.lintel_material", i)), "lintel") << name << i;
    EXPECT_EQ(set(name, fmt::format("building.wall.1.opening.{}.lintel_material", openings + 1)), "");
  }
  for (int i = 1; i <= 4; ++i)
    EXPECT_EQ(set("wall D, no lintels", fmt::format("building.wall.1.opening.{}.bearing", i)), "0");
  EXPECT_NEAR(std::tan(std::stod(set("wall D, joints of the pier tests", "joints.mortar.friction_angle")) * M_PI / 180),
              0.58, 1e-4);

  for (auto& [name, r] : runs_) r.curve = curve_of({100.0, 10.0, 60.0, 18.0});
  run("wall D").curve = curve_of({170.0, 10.0, 85.0, 0.0043 * 5760.0});
  run(slow_d).curve = curve_of({180.0, 10.0, 60.0, 18.0});
  run(slow_d).blocks = 980, run(slow_d).beams = 17, run(slow_d).zones = 81600;
  run("walls A + B + C").curve = curve_of({150.0, 10.0, 75.0, 0.0041 * 5760.0});
  run(slow_abc).curve = curve_of({181.9, 10.0, 60.0, 18.0});
  run(slow_abc).blocks = 2700;
  run("wall D, lintels x 3").curve = curve_of({187.0, 10.0, 60.0, 18.0});
  read();
  EXPECT_NEAR(verdict("capacity of wall D").number, 20.0, 1e-9);  // 180 on 150 kN
  EXPECT_EQ(verdict("capacity of wall D").reference, 0.0);
  EXPECT_FALSE(verdict("capacity of wall D").reproduced) << "15 points are allowed";
  EXPECT_NEAR(verdict("capacity of walls A + B + C").number, 100 * (181.9 / 140 - 1), 1e-9);  // the paper: +15 %
  EXPECT_EQ(verdict("capacity of walls A + B + C").reference, 15.0);
  EXPECT_TRUE(verdict("capacity of walls A + B + C").reproduced);
  EXPECT_EQ(verdict("number of blocks of wall D").number, 996.0);  // Table 2; the ground is a beam
  EXPECT_EQ(verdict("number of blocks of wall D").reference, 996.0);
  EXPECT_TRUE(verdict("number of blocks of wall D").reproduced);
  EXPECT_EQ(verdict("number of blocks of walls").reference, 2506.0);
  EXPECT_FALSE(verdict("number of blocks of walls").reproduced);
  EXPECT_THAT(row("wall D")[2], "81600 (81600)");
  EXPECT_NEAR(verdict("wall D follows the drift").number, 0.43, 1e-4);  // of 5.76 m
  EXPECT_TRUE(verdict("wall D follows the drift").reproduced);
  EXPECT_THAT(verdict("wall D follows the drift").text, HasSubstr("50 % of the peak left"));
  EXPECT_FALSE(verdict("walls A + B + C follows the drift").reproduced);
  EXPECT_THAT(report_.differs, Contains(AllOf(HasSubstr("wall D: 180 kN"), HasSubstr("+20 % of the recalled"))));
  EXPECT_THAT(report_.agrees,
              Contains(AllOf(HasSubstr("walls A + B + C: 182 kN"), HasSubstr("+30 % of the recalled"))));
  EXPECT_THAT(report_.tables,
              Contains(::testing::Field(
                  &Table::rows, Contains(std::vector<std::string>{"wall D", "lintels 3 times as stiff as units",
                                                                  "187 kN at 10.0 mm", "+10 %"}))));  // 187 on 170 kN
}

// Widths within half of a half unit of 0.94 m; doors of at least 1.7 m, windows of at least 0.7 m; courses of 0.16 m.
TEST(LayoutRules, AreGeometry) {
  EXPECT_EQ(why_not(DoorLayout{5, 12, 5, 6}), "");
  EXPECT_THAT(why_not(DoorLayout{4, 12, 5, 6}), HasSubstr("openings 0.8 m wide"));
  EXPECT_THAT(why_not(DoorLayout{5, 12, 6, 6}), HasSubstr("openings 1.2 m wide"));
  EXPECT_EQ(why_not(DoorLayout{5, 11, 5, 6}), "");
  EXPECT_THAT(why_not(DoorLayout{5, 10, 5, 6}), HasSubstr("doors 1.60 m high"));
  EXPECT_EQ(why_not(DoorLayout{5, 12, 5, 5}), "");
  EXPECT_THAT(why_not(DoorLayout{5, 12, 5, 4}), HasSubstr("windows 0.64 m high"));
  // 40 courses of 30 half units, two doors and two windows; a lintel of 7 half units is one block.
  const Count scene = DoorLayout{5, 12, 5, 6}.count();
  EXPECT_EQ(scene.half_units, 30 * 40 - 2 * 5 * (12 + 6));
  EXPECT_EQ(scene.blocks, scene.half_units - 4 * 6);

  // 5.5 m over the columns of wall B between the corners; sill at course 6, floor at 17, one lintel.
  EXPECT_EQ(why_not(WindowLayout{28, 19, 6, false}), "");
  EXPECT_EQ(why_not(WindowLayout{28, 19, 10, false}), "");
  EXPECT_THAT(why_not(WindowLayout{28, 19, 11, false}), HasSubstr("no room for windows 1.76 m"));
  EXPECT_THAT(why_not(WindowLayout{28, 19, 4, false}), HasSubstr("windows 0.64 m high"));
  EXPECT_THAT(why_not(WindowLayout{26, 19, 6, false}), HasSubstr("half units of 0.212 m"));
  EXPECT_THAT(why_not(WindowLayout{28, 17, 6, false}), HasSubstr("half units of 0.221 m"));
  EXPECT_NEAR((WindowLayout{28, 19, 6, false}.depth()), 4.0, 1e-12);
}

// Windows of 5 half units on two floors: the outer piers are equal, the others within one column of them and each
// other.
TEST(LayoutRules, PiersBetweenWindowsAreAlike) {
  for (int columns = 24; columns <= 32; ++columns) {
    const auto settings = WindowLayout{columns, 19, 6, false}.overrides();
    const auto first = [&](int opening) {
      const std::string key = fmt::format("building.wall.1.opening.{}.first_half_unit=", opening);
      for (const std::string& s : settings)
        if (s.starts_with(key)) return std::stoi(s.substr(key.size()));
      return -1;
    };
    const int pier[4] = {first(1), first(2) - first(1) - 5, first(3) - first(2) - 5, columns - first(3) - 5};
    EXPECT_EQ(pier[0], pier[3]) << columns;
    for (const int p : pier) {
      EXPECT_GE(p, pier[0]) << columns;
      EXPECT_LE(p, pier[0] + 2) << columns;
    }
    EXPECT_LE(std::abs(pier[1] - pier[2]), 1) << columns;
    for (const int i : {1, 2, 3}) EXPECT_EQ(first(i + 3), first(i)) << "above each other";
  }
}

TEST_F(Verdicts, PiersAreBetweenTheirTwoDirections) {
  start("blind");
  run("ISP1").curve = curve_of({1.14 * 82.8, 3.0, 40.0, 5.0});
  run("ISP3").curve = curve_of({0.84 * 72.05, 3.0, 40.0, 5.0});
  read();
  EXPECT_NEAR(*verdict("peak of ISP1").reference, (81.4 + 84.2) / 2, 1e-9);
  EXPECT_NEAR(*verdict("peak of ISP3").reference, (71.9 + 72.2) / 2, 1e-9);
  EXPECT_TRUE(verdict("peak of ISP1").reproduced);
  EXPECT_FALSE(verdict("peak of ISP3").reproduced);
  EXPECT_THAT(verdict("peak of ISP1").text, HasSubstr("+14 %"));
  // Rigid rocking: lever arm to the middle, less half of the crushed toe of 0.6/(0.85 fc) of the length.
  for (const auto& [pier, height] : {std::pair{"ISP1", 1.35}, {"ISP3", 2.0}})
    EXPECT_EQ(row(pier)[7], fmt::format("{:.1f} kN", 150.0 / height * (1 - 0.6 / (0.85 * 6.2)))) << pier;
}

// Six half cycles, elastic except for the last, which is a rectangle. Only the first exceeds the monotonic curve, by 2
// %.
TEST_F(Verdicts, CyclesLoseWorkAndDoNotExceedOneWay) {
  start("cyclic");
  for (const char* name : {"solid wall", "pier ISP1"}) {
    Curve c;
    const auto add = [&](int half, double d, double f) {
      c.stage.push_back(2), c.half_cycle.push_back(half), c.displacement.push_back(d), c.force.push_back(f);
      c.vertical.push_back(0.0), c.unbalanced.push_back(0.0);
    };
    for (int half = 0; half < 6; ++half) {
      const double sign = half % 2 == 0 ? 1.0 : -1.0, force = half == 0 ? 51.0 : 30.0 + half;
      add(half, 0.0, half == 5 ? sign * force : 0.0);
      add(half, sign * 1.0, sign * force);
      add(half, sign * 1.0, half == 5 ? sign * force : sign * force);
      // In the other direction before its end: the part from there to the next half cycle belongs to neither.
      if (half < 5) add(half, half == 4 ? 0.1 * sign : 0.0, -sign * 60.0);
    }
    run(name).curve = c;
  }
  run("pier ISP1, one way").curve = curve_of({49.0, 2.0, 40.0, 5.0});
  read();
  EXPECT_NEAR(verdict("cycles do not exceed loading one way: solid wall").number, 51.0, 1e-12);
  EXPECT_EQ(verdict("cycles do not exceed loading one way: solid wall").reference, 50.0);
  EXPECT_TRUE(verdict("cycles do not exceed loading one way: solid wall").reproduced);
  EXPECT_FALSE(verdict("cycles do not exceed loading one way: pier ISP1").reproduced);
  EXPECT_THAT(verdict("cycles do not exceed loading one way: solid wall").text,
              HasSubstr("+51.0 and -35.0 kN in cycles, 50.0 kN one way"));
  EXPECT_NEAR(verdict("half cycles lose work: solid wall").number, 1.0, 1e-12);
  EXPECT_TRUE(verdict("half cycles lose work: solid wall").reproduced);
  ASSERT_EQ(report_.tables[0].rows.size(), 12u);
  EXPECT_EQ(report_.tables[0].rows[5], (std::vector<std::string>{"solid wall", "6", "-1.00 mm", "-35.0 kN", "1.00"}));
  start("cyclic", "fast");
  EXPECT_EQ(set("solid wall", "stage.cycles.velocity"), "0.02");
}

// Springs in place of walls and piers, with loops in closed form: secant F/a, residual a - F/k, dissipated 4 F (a -
// F/k).
class LoopVerdicts : public Verdicts {
 protected:
  static double damping(double stiffness, double yield, double amplitude) {
    return 2 / M_PI * (1 - yield / (stiffness * amplitude));
  }
  void swing(const std::string& name, double stiffness, double yield) {
    run(name).cycles = cycles_;
    run(name).curve = spring_curve(cycles_, stiffness, yield);
  }
  quoin::Cycles cycles_{{0.002, 0.003}, {2, 1}, 0.01, 0.05, {}};
};

TEST_F(LoopVerdicts, WallsInCycles) {
  start("cyclic_wall", "fast");
  EXPECT_EQ(set("solid wall, cyclic_joint", "stage.cycles.velocity"), "0.02");
  start("cyclic_wall", "reference");
  EXPECT_EQ(set("solid wall, cyclic_joint", "stage.cycles.velocity"), "0.005");
  start("cyclic_wall");
  EXPECT_EQ(set("solid wall, fracture_energy", "stage.cycles.velocity"), "0.01");
  EXPECT_EQ(set("solid wall, fracture_energy", "joints.mortar.compressive_yield"), "") << "no property of that law";
  EXPECT_DOUBLE_EQ(std::stod(set("solid wall, cyclic_joint", "joints.mortar.compressive_yield")), 5e6 / 3);
  EXPECT_EQ(set("solid wall, cyclic_joint", "stage.cycles.cycles"), "2");
  EXPECT_EQ(run("solid wall, cyclic_joint").spec.law, "cyclic_joint");

  swing("solid wall, fracture_energy", 100.0, 40.0);
  swing("solid wall, cyclic_joint", 100.0, 36.0);
  run("solid wall, one way").curve = curve_of({39.0, 2.0, 30.0, 5.0});
  read();
  const std::string claim = "solid wall, fracture_energy: ";
  EXPECT_NEAR(verdict(claim + "cycles do not exceed").number, 40.0, 1e-9);
  EXPECT_EQ(verdict(claim + "cycles do not exceed").reference, 39.0);
  EXPECT_TRUE(verdict(claim + "cycles do not exceed").reproduced) << "2.6 % more; 3 % are allowed";
  EXPECT_NEAR(verdict(claim + "stiffness falls").number, 100.0 * 2 / 3, 1e-3) << "40 kN at 2 and at 3 mm";
  EXPECT_TRUE(verdict(claim + "stiffness falls").reproduced);
  EXPECT_NEAR(verdict("solid wall: cyclic_joint leaves").number, 3.0 - 36.0 / 100.0, 1e-3);
  EXPECT_NEAR(*verdict("solid wall: cyclic_joint leaves").reference, 3.0 - 0.4, 1e-3);
  EXPECT_TRUE(verdict("solid wall: cyclic_joint leaves").reproduced);
  ASSERT_EQ(report_.tables.at(0).rows.size(), 6u);
  EXPECT_EQ(report_.tables[0].rows[2],
            (std::vector<std::string>{
                "solid wall", "fracture_energy", "3 mm, 1", "+3.00 / -3.00 mm (0.30 %)", "+40.0 / -40.0 kN", "416.0 J",
                fmt::format("{:.1f} %", 100 * damping(100.0, 40.0, 3.0)), "13.3 kN/mm", "2.60 mm"}));
  EXPECT_THAT(report_.notes, Contains(HasSubstr("with fracture_energy: 0.0 % at 2 mm, 0.0 % at 3 mm")));

  // Stiffer with displacement, and stronger than the monotonic curve; the other law has a smaller residual.
  run("solid wall, fracture_energy").curve =
      spring_curve(cycles_, 100.0, 40.0, [](double d) { return 10 * d * std::abs(d); });
  swing("solid wall, cyclic_joint", 100.0, 60.0);
  read();
  EXPECT_FALSE(verdict(claim + "stiffness falls").reproduced);
  EXPECT_NEAR(verdict(claim + "cycles do not exceed").number, 40.0 + 90.0, 1e-3);
  EXPECT_FALSE(verdict(claim + "cycles do not exceed").reproduced);
  EXPECT_TRUE(verdict("solid wall, cyclic_joint: stiffness falls").reproduced);
}

TEST_F(LoopVerdicts, PiersInCyclesAreHeldAgainstTheTests) {
  start("cyclic_piers");
  for (const char* pier : {"ISP1", "ISP3"}) {
    const std::string name = pier, with_cycles = name + ", cyclic_joint";
    EXPECT_DOUBLE_EQ(std::stod(set(with_cycles, "joints.mortar.compressive_yield")), 6.2e6 / 3);
    EXPECT_EQ(set(with_cycles, "stage.cycles.velocity"), "0.01");
    EXPECT_EQ(set(with_cycles, "stage.cycles.cycles"), "2");
  }
  // Means of the two sides of the tests: 82.8 and 72.05 kN.
  swing("ISP1, fracture_energy", 160.0, 1.14 * 82.8);
  swing("ISP1, cyclic_joint", 160.0, 0.84 * 82.8);
  swing("ISP3, fracture_energy", 80.0, 1.0 * 72.05);
  swing("ISP3, cyclic_joint", 600.0, 1.14 * 72.05);
  read();
  EXPECT_NEAR(*verdict("ISP1, fracture_energy: forces of both sides").reference, 82.8, 1e-9);
  EXPECT_NEAR(*verdict("ISP3, fracture_energy: forces of both sides").reference, 72.05, 1e-9);
  EXPECT_NEAR(verdict("ISP1, fracture_energy: forces of both sides").number, 1.14 * 82.8, 1e-6);
  EXPECT_TRUE(verdict("ISP1, fracture_energy: forces of both sides").reproduced);
  EXPECT_FALSE(verdict("ISP1, cyclic_joint: forces of both sides").reproduced);
  EXPECT_THAT(verdict("ISP1, cyclic_joint: forces of both sides").text, HasSubstr("-16 %"));
  const Verdict& more = verdict("fracture_energy: the pier that sheared damps more");
  EXPECT_NEAR(more.number, 100 * damping(160.0, 1.14 * 82.8, 3.0), 0.05);
  EXPECT_NEAR(*more.reference, 100 * damping(80.0, 72.05, 3.0), 0.05);
  EXPECT_TRUE(more.reproduced);
  EXPECT_FALSE(verdict("cyclic_joint: the pier that sheared damps more").reproduced);
  // Drifts over the heights of the piers, 1.35 and 2.002 m.
  EXPECT_EQ(report_.tables.at(0).rows[2][3], "+3.00 / -3.00 mm (0.22 %)");
  EXPECT_EQ(report_.tables[0].rows[8][3], "+3.00 / -3.00 mm (0.15 %)");
}

TEST_F(LoopVerdicts, TheBuildingInCyclesIsHeldAgainstTheTest) {
  start("cyclic_building");
  EXPECT_EQ(set("wall D, cyclic_joint", "stage.cycles.velocity"), "0.02");
  cycles_.amplitudes = {0.010, 0.0043 * 5.76};
  swing("wall D, fracture_energy", 100.0, 172.0);
  swing("wall D, cyclic_joint", 100.0, 127.0);
  read();
  EXPECT_NEAR(verdict("wall D, fracture_energy: base shear").number, 172.0, 1e-9);
  EXPECT_EQ(verdict("wall D, fracture_energy: base shear").reference, 150.0);
  EXPECT_TRUE(verdict("wall D, fracture_energy: base shear").reproduced) << "14.7 % more";
  EXPECT_FALSE(verdict("wall D, cyclic_joint: base shear").reproduced) << "15.3 % less";
  EXPECT_NEAR(verdict("wall D, cyclic_joint: roof drift").number, 0.43, 1e-4);
  EXPECT_TRUE(verdict("wall D, cyclic_joint: roof drift").reproduced);
  cycles_.amplitudes.back() = 0.0039 * 5.76;
  swing("wall D, cyclic_joint", 100.0, 128.0);
  read();
  EXPECT_TRUE(verdict("wall D, cyclic_joint: base shear").reproduced) << "14.7 % less";
  EXPECT_FALSE(verdict("wall D, cyclic_joint: roof drift").reproduced);
}

TEST_F(LoopVerdicts, RestrainedDilationIsReadFromPeaksAndThrusts) {
  start("restrained_dilation");
  for (const char* law : {"fracture_energy", "cyclic_joint"}) {
    const std::string with = std::string("dilation, ") + law, without = "no " + with;
    for (const std::string& name : {with, without}) {
      EXPECT_EQ(set(name, "stage.cycles.vertical"), "held") << name;
      EXPECT_EQ(run(name).spec.law, law) << name;
      swing(name, 80.0, 40.0);
    }
    EXPECT_NEAR(std::tan(std::stod(set(with, "joints.mortar.dilation_angle")) * M_PI / 180), 0.3, 1e-7);
    EXPECT_EQ(set(without, "joints.mortar.dilation_angle"), "");
  }
  EXPECT_EQ(set("dilation, cyclic_joint", "joints.mortar.dilation_pressure"), "1.5e6");
  swing("dilation, fracture_energy", 80.0, 41.0);
  swing("dilation, cyclic_joint", 80.0, 40.6);
  run("dilation, fracture_energy").curve.vertical.back() = 90.0;
  run("dilation, cyclic_joint").curve.vertical.back() = 80.0;
  run("dilation, cyclic_joint").curve.vertical[5] = 123.0;
  read();
  EXPECT_NEAR(verdict("restrained dilation raises the strength: fracture").number, 41.0, 1e-9);
  EXPECT_NEAR(*verdict("restrained dilation raises the strength: fracture").reference, 40.0, 1e-9);
  EXPECT_TRUE(verdict("restrained dilation raises the strength: fracture").reproduced);
  EXPECT_FALSE(verdict("restrained dilation raises the strength: cyclic").reproduced) << "1.5 %; 2 % are asked for";
  EXPECT_EQ(verdict("uplift that comes down").number, 80.0);
  EXPECT_EQ(verdict("uplift that comes down").reference, 90.0);
  EXPECT_TRUE(verdict("uplift that comes down").reproduced);
  EXPECT_EQ(row("dilation, cyclic_joint"),
            (std::vector<std::string>{"dilation, cyclic_joint", "40.6 kN", "123 kN", "80 kN",
                                      fmt::format("{:.0f} J", 4 * 40.6 * (3.0 - 40.6 / 80.0))}));
}

// A loop ends where the next half cycle passes zero; the row after that belongs to the next loop. Tested with few rows:
// a spring of 10 kN/mm, and 99 kN after the end.
TEST(Loops, EndWhereTheNextHalfCyclePassesZero) {
  const quoin::Cycles cycles{{0.001}, {1}, 0.01, 0.0, {}};
  Curve c;
  const auto add = [&c](int half, double displacement, double force) {
    c.stage.push_back(2), c.displacement.push_back(displacement), c.force.push_back(force);
    c.half_cycle.push_back(half), c.vertical.push_back(99.0), c.unbalanced.push_back(0.01);
  };
  for (const double d : {0.0, 0.5, 1.0}) add(0, d, 10 * d);
  for (const double d : {0.5, 0.0, -0.5, -1.0}) add(1, d, 10 * d);
  for (const double d : {-0.5, 0.0}) add(2, d, 10 * d);
  for (const double d : {0.5, 0.9}) add(2, d, 99.0);
  const std::vector<Loop> loops = loops_of(c, cycles);
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].largest, 10.0);
  EXPECT_EQ(loops[0].lowest, -10.0);
  EXPECT_NEAR(loops[0].dissipated, 0.0, 1e-12);
}

// Elastic and perfectly plastic: 40 kN from 0.5 mm on.
TEST(Loops, AreThoseOfAnElasticPlasticSpring) {
  const quoin::Cycles cycles{{0.002, 0.003}, {2, 1}, 0.01, 0.05, {}};
  const Curve c = spring_curve(cycles, 80.0, 40.0);
  const std::vector<Loop> loops = loops_of(c, cycles);
  ASSERT_EQ(loops.size(), 3u);
  for (std::size_t i = 1; i < 3; ++i) {
    const double a = i == 1 ? 2.0 : 3.0;
    EXPECT_EQ(loops[i].repetition, i == 1 ? 1 : 0);
    EXPECT_NEAR(loops[i].farthest, a, 1e-6);
    EXPECT_NEAR(loops[i].back, -a, 1e-6);
    EXPECT_NEAR(loops[i].largest, 40.0, 1e-9);
    EXPECT_NEAR(loops[i].stiffness, 40.0 / a, 1e-6);
    EXPECT_NEAR(loops[i].residual(), a - 0.5, 1e-3);
    EXPECT_NEAR(loops[i].damping(), loops[i].dissipated / (2 * M_PI * 40.0 * a), 1e-9);
    // A parallelogram of height 80 kN and base 2 (a - 0.5 mm), for any earlier cycles.
    EXPECT_NEAR(loops[i].dissipated, 80.0 * 2 * (a - 0.5), 0.1);
  }
  const Curve envelope = envelope_of(c, cycles);
  ASSERT_EQ(envelope.size(), 4u);
  EXPECT_NEAR(envelope.force[0], -40.0, 1e-9);
  EXPECT_NEAR(envelope.force[3], 40.0, 1e-9);
  EXPECT_LT(envelope.displacement[0], envelope.displacement[1]);

  // In the opposite direction, with less force at 3 mm: each amplitude has its force on both sides.
  quoin::Cycles backwards = cycles;
  backwards.velocity = -cycles.velocity;
  const Curve other = envelope_of(
      spring_curve(backwards, 80.0, 40.0, [](double d) { return std::abs(d) > 2.5 ? -std::copysign(5.0, d) : 0.0; }),
      backwards);
  ASSERT_EQ(other.size(), 4u);
  for (const std::size_t i : {0u, 1u, 2u, 3u}) EXPECT_NEAR(other.force[i], i < 2 ? -40.0 : 40.0, 1e-9) << i;
  for (const std::size_t i : {0u, 3u}) EXPECT_LE(std::abs(other.displacement[i]), 2.5 + 1e-9) << "where it is largest";
}

}  // namespace
