#include "records/read_record.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "base/error.h"

namespace quoin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class ReadRecord : public testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& text) {
    const std::filesystem::path path = folder_ / name;
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
  std::string fault(const std::string& name, const std::string& text) {
    try {
      read_record(file(name, text));
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      return error.what();
    }
    return "read without a word";
  }
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

 private:
  std::filesystem::path folder_;
};

const char* const kPeer =
    "PEER NGA STRONG MOTION DATABASE RECORD\nSomewhere, 1/1/1980, Station, 270\nACCELERATION TIME SERIES IN UNITS OF "
    "G\n"
    "NPTS=      6, DT=   .0050 SEC,\n  .1000000E+00  -.2000000E+00   .0000000E+00\n   .1E-02   .0E+00   -.5E-01\n";

TEST_F(ReadRecord, Peer) {
  const GroundRecord record = read_record(file("a.AT2", kPeer));
  EXPECT_EQ(record.kind, MotionKind::acceleration);
  ASSERT_EQ(record.components.size(), 1u);
  EXPECT_EQ(record.components[0].name, "270");
  EXPECT_NEAR(record.components[0].value[1], -0.2 * 9.80665, 1e-12);
  EXPECT_NEAR(record.time[5], 0.025, 1e-15);
  EXPECT_TRUE(record.assumptions.empty());
}

TEST_F(ReadRecord, PeerOfTheOldFormAndVelocities) {
  const GroundRecord record =
      read_record(file("b.vt2",
                       "PEER STRONG MOTION DATABASE RECORD. PROCESSING BY PACIFIC ENGINEERING.\n"
                       "PLACE 01/01/80 0101, STATION, UP (USGS STATION 1)\n"
                       "VELOCITY TIME HISTORY IN UNITS OF CM/SEC. FILTER POINTS: HP=0.1 Hz LP=30 Hz\n"
                       "    3    .0100    NPTS, DT\n 1.0 2.0 3.0\n"));
  EXPECT_EQ(record.kind, MotionKind::velocity);
  EXPECT_THAT(record.components[0].value, ElementsAre(0.01, 0.02, 0.03));
  EXPECT_NEAR(record.time[2], 0.02, 1e-15);
}

TEST_F(ReadRecord, PeerThatIsCutOffIsRefused) {
  const std::string text = kPeer;
  EXPECT_THAT(fault("c.AT2", text.substr(0, text.size() - 10)),
              HasSubstr("the header states 6 values, the file has 5"));
  std::string in_metres = kPeer;
  in_metres.replace(in_metres.find("UNITS OF ") + 9, 1, "M");
  EXPECT_THAT(fault("e.AT2", in_metres), HasSubstr("its unit, m, is none of acceleration"));
  EXPECT_THAT(fault("d.AT2", "one\ntwo\nthree\nfour\nfive\n"), HasSubstr("do not state units and NPTS"));
}

std::string esm(const std::string& units, int count, const std::string& values) {
  std::string text = "EVENT_NAME: TEST\nSAMPLING_INTERVAL_S: 0.005000\nNDATA: " + std::to_string(count) +
                     "\nUNITS: " + units + "\nSTREAM: HNE\nDATA_TYPE: ACCELERATION\n";
  for (int i = 6; i < 64; ++i) text += "USER" + std::to_string(i) + ":\n";
  return text + values;
}

TEST_F(ReadRecord, Esm) {
  const GroundRecord record = read_record(file("e.ASC", esm("cm/s^2", 3, "1.5\n-2\n  0.25\n")));
  EXPECT_EQ(record.components[0].name, "HNE");
  EXPECT_THAT(record.components[0].value, ElementsAre(0.015, -0.02, 0.0025));
  EXPECT_NEAR(record.time[2], 0.01, 1e-15);
  EXPECT_THAT(fault("f.ASC", esm("furlongs", 3, "1\n2\n3\n")), HasSubstr("f.ASC:4: 'UNITS: furlongs'"));
  EXPECT_THAT(fault("g.ASC", esm("cm/s^2", 4, "1\n2\n3\n")), HasSubstr("states 4 values, the file has 3"));
  EXPECT_THAT(fault("h.ASC", esm("cm/s^2", 3, "1\nnan\n3\n")), HasSubstr("h.ASC:66"));
}

TEST_F(ReadRecord, CsvWithUnits) {
  const GroundRecord record =
      read_record(file("i.csv", "# of a shake table\ntime (ms), east (g), up (cm/s2)\n0, 0.1, 5\n10, -0.1, -5\n"));
  EXPECT_THAT(record.time, ElementsAre(0.0, 0.01));
  ASSERT_EQ(record.components.size(), 2u);
  EXPECT_THAT(fault("k.csv", "time_s,x_g,x_g\n0,0,0\n1,0,0\n"),
              HasSubstr("k.csv:1: 'time_s,x_g,x_g': two columns 'x'"));
  EXPECT_THAT(fault("k.csv", "time_s,x_g,x_cm/s2\n0,0,0\n1,0,0\n"), HasSubstr("two columns 'x'"));
  EXPECT_EQ(record.components[0].name, "east");
  EXPECT_NEAR(record.components[0].value[0], 0.980665, 1e-12);
  EXPECT_THAT(record.components[1].value, ElementsAre(0.05, -0.05));
  EXPECT_TRUE(record.assumptions.empty());
  EXPECT_EQ(recorded_units(record), "g, cm/s2");
  const GroundRecord underscores = read_record(file("j.csv", "time_s;x_mm\n0;1\n1;2\n"));
  EXPECT_EQ(underscores.kind, MotionKind::displacement);
  EXPECT_THAT(underscores.components[0].value, ElementsAre(0.001, 0.002));
}

// As monitors.csv and spectrum.csv of the program name their columns. The last part alone, "s2", is no unit: such a
// column was taken for m/s2.
TEST_F(ReadRecord, UnitsWithUnderscoresAreUnits) {
  struct Case {
    const char* tail;
    double factor;
    MotionKind kind;
  };
  for (const Case& c : std::initializer_list<Case>{{"m_s2", 1.0, MotionKind::acceleration},
                                                   {"cm_s2", 1e-2, MotionKind::acceleration},
                                                   {"mm_s2", 1e-3, MotionKind::acceleration},
                                                   {"CM_SEC_SEC", 1e-2, MotionKind::acceleration},
                                                   {"m_s", 1.0, MotionKind::velocity},
                                                   {"cm_s", 1e-2, MotionKind::velocity},
                                                   {"mm_s", 1e-3, MotionKind::velocity},
                                                   {"m", 1.0, MotionKind::displacement},
                                                   {"cm", 1e-2, MotionKind::displacement},
                                                   {"mm", 1e-3, MotionKind::displacement}}) {
    for (const char* name : {"x", "top_floor_x"}) {
      for (const bool bracketed : {false, true}) {
        const std::string head = std::string(name) + (bracketed ? " (" : "_") + c.tail + (bracketed ? ")" : "");
        const GroundRecord record = read_record(file("u.csv", "time_s," + head + "\n0,0\n1,2\n"));
        EXPECT_EQ(record.kind, c.kind) << head;
        EXPECT_EQ(record.components[0].name, name) << head;
        EXPECT_NEAR(record.components[0].value[1], 2.0 * c.factor, 1e-15) << head;
        EXPECT_TRUE(record.assumptions.empty()) << head;
      }
    }
  }
  for (const char* tail : {"ft_s2", "ft/s2", "in", "km_s", "mgal", "m_s_2"})
    EXPECT_THAT(fault("v.csv", std::string("time_s,top_x_") + tail + "\n0,0\n1,2\n"),
                HasSubstr(std::string("the unit '") + tail + "' of column 2 is unknown; allowed: m/s2"));
  for (const char* name : {"acc_n_s", "s2", "north_s_wave"})
    EXPECT_THAT(read_record(file("w.csv", std::string("time_s,") + name + "\n0,0\n1,2\n")).assumptions,
                ElementsAre(HasSubstr(std::string("column '") + name + "' is an acceleration in m/s2")));
}

// "%" begins a comment, but "%g" is a unit: "a (%g)" was read as "a (" in m/s2, 10.2 times too large.
TEST_F(ReadRecord, PercentOfGravityIsNoComment) {
  for (const char* name : {"a (%g)", "a [%g]", "a_%g", "a %g", "a %G"})
    EXPECT_THAT(fault("p.csv", fmt::format("time (s),{}\n0,0\n1,2\n", name)), HasSubstr("of column 2 is unknown"));
  const GroundRecord record = read_record(file("q.csv", "% a record\ntime_s,a_g % by hand\n0,0 % begins\n1,2\n"));
  EXPECT_NEAR(record.components[0].value[1], 2.0 * 9.80665, 1e-12);
}

// The spline of a displacement that ends at 0.1 m/s stops within a step. Its acceleration there was 45 times the
// largest of the motion, 1 - cos of 2 rad/s, and scaling to a PGA was wrong by as much.
TEST_F(ReadRecord, DisplacementsThatStopWithinAStepAreRefused) {
  const auto motion = [](double seconds) {
    std::string text = "time_s,u_m\n";
    for (int i = 0; i * 0.01 <= seconds; ++i)
      text += fmt::format("{},{:.12g}\n", i * 0.01, 0.05 * (1 - std::cos(2.0 * i * 0.01)));
    return text;
  };
  EXPECT_THAT(fault("r.csv", motion(2.4)), HasSubstr("does not end at rest"));
  EXPECT_EQ(read_record(file("s.csv", motion(std::numbers::pi))).kind, MotionKind::displacement);
}

TEST_F(ReadRecord, WhatAFileDoesNotStateIsAnAssumption) {
  const GroundRecord bare = read_record(file("k.csv", "0 1\n0.5 2\n"));
  EXPECT_THAT(bare.components[0].value, ElementsAre(1.0, 2.0));
  EXPECT_THAT(bare.assumptions, ElementsAre(HasSubstr("accelerations in m/s2")));
  const GroundRecord named = read_record(file("l.csv", "time, ground_floor\n0, 1\n1, 2\n"));
  EXPECT_EQ(named.components[0].name, "ground_floor");
  EXPECT_EQ(named.assumptions.size(), 2u);
}

TEST_F(ReadRecord, FaultsAreNamedWithTheirPlace) {
  EXPECT_THAT(fault("m.csv", "time_s,x_g\n0,1\n0,2\n"), HasSubstr("m.csv:3: '0,2': the time 0 s does not lie after"));
  EXPECT_THAT(fault("n.csv", "time_s,x_g\n0,1\n1\n"), HasSubstr("n.csv:3"));
  EXPECT_THAT(fault("o.csv", "time_s,x_g\n0,1\n1,inf\n"), HasSubstr("'inf'; allowed: a finite number"));
  EXPECT_THAT(fault("p.csv", "time_s,x_g,y_mm\n0,1,1\n1,1,1\n"),
              AllOf(HasSubstr("column 3 is in mm, column 2 in g"), HasSubstr("not a mixture")));
  EXPECT_THAT(fault("q.csv", "time (h), x (g)\n0,1\n1,1\n"), HasSubstr("the unit 'h' of the time"));
  EXPECT_THAT(fault("r.csv", "time (s), x (ft/s2)\n0,1\n1,1\n"), HasSubstr("unit 'ft/s2'"));
  EXPECT_THAT(fault("s.csv", "time_s,x_g\n0,1\n"), HasSubstr("1 rows of numbers"));
  EXPECT_THAT(fault("t.csv", ""), HasSubstr("0 rows of numbers"));
  EXPECT_THAT(fault("u.csv", "time_s,x_g\n-1,1\n0,1\n"), HasSubstr("negative"));
}

// Of monitors.csv: `step` was taken for the time, so 2 s of a record became 200 s, and time_s for an acceleration.
TEST_F(ReadRecord, TablesOfRunsGiveTheirAccelerations) {
  const GroundRecord record = read_record(file("m.csv",
                                               "step,time_s,top_dx_m,top_ax_m_s2,top_az_m_s2,top_drift_x\n"
                                               "1,0.01,0.5,,,\n2,0.02,0.6,1.5,-2,\n3,0.03,0.7,2.5,-3,0.1\n"));
  EXPECT_THAT(record.time, ElementsAre(0.02, 0.03));
  ASSERT_EQ(record.components.size(), 2u);
  EXPECT_EQ(record.components[0].name, "top_ax");
  EXPECT_THAT(record.components[0].value, ElementsAre(1.5, 2.5));
  EXPECT_THAT(record.components[1].value, ElementsAre(-2.0, -3.0));
  EXPECT_THAT(record.assumptions, ElementsAre(HasSubstr("of its 6 columns the 2 that state a unit of acceleration")));
  EXPECT_THAT(fault("n.csv", "step,time_s,x_m\n1,0,0\n2,1,0\n"), HasSubstr("no column states a unit of acceleration"));
  EXPECT_THAT(fault("o.csv", "step,ax_m_s2\n1,0\n2,1\n"), HasSubstr("the first column is 'step'"));
  EXPECT_THAT(fault("p.csv", "step,time_s,ax_m_s2\n1,0,0\n2,1,\n"), HasSubstr("p.csv:3"));
  EXPECT_THAT(fault("q.csv", "time_s,time_s,x_g\n0,0,0\n1,1,1\n"), HasSubstr("the unit 's' of column 2 is unknown"));
}

TEST_F(ReadRecord, ComponentsFromSeveralFilesNeedOneTime) {
  const std::string x = file("x.csv", "time_s,x_g\n0,1\n1,2\n"), y = file("y.csv", "time_s,y_g\n0,3\n1,4\n");
  const GroundRecord record = read_record({x, y});
  ASSERT_EQ(record.components.size(), 2u);
  EXPECT_EQ(record.components[1].name, "y");
  const std::string late = file("z.csv", "time_s,y_g\n0,3\n2,4\n"), v = file("v.csv", "time_s,y_m/s\n0,3\n1,4\n");
  EXPECT_THROW(read_record({x, late}), Error);
  EXPECT_THROW(read_record({x, v}), Error);
  EXPECT_THROW(read_record(std::vector<std::string>{}), Error);
}

}  // namespace
}  // namespace quoin
