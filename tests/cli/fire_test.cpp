// Adverse conditions: files without end, full disks, signals, laws that crash. In all of them the program ends in time
// and keeps its results. It has a documented exit code and a message with place and remedy.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <map>
#include <sstream>
#include <thread>

#include "program.h"

namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Fire : public Cli {
 protected:
  // Ends a process with SIGALRM after this many seconds; finish() then returns 142.
  static void in_time(unsigned seconds = 60) { alarm(seconds); }
  int quoin_in_time(const std::vector<std::string>& words) {
    return quoin(words, [] { in_time(); });
  }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  // Values of the last row of history.csv by column.
  std::map<std::string, std::string> last_row() const {
    std::istringstream rows(read_all(out() + "/history.csv"));
    std::string names, row, last;
    std::getline(rows, names);
    while (std::getline(rows, row)) last = row;
    std::istringstream names_left(names), values_left(last);
    std::map<std::string, std::string> values;
    for (std::string name; std::getline(names_left, name, ',');) std::getline(values_left, values[name], ',');
    return values;
  }
  // Returns the path of the small wall with one text replaced.
  std::string wall_with(const std::string& from, const std::string& to) const {
    std::string text = read_all(small_);
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return write("changed.toml", text.replace(at, from.size(), to));
  }
  std::vector<std::string> short_run(const std::string& scene, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"run", scene, "--out", out(), "--threads", "1", "--set", "stage.2.displacement=1e-5",
                               "--set", "output.frames=0", "--set", "output.plots=false"});
    return more;
  }
  // Starts a run that would take minutes and waits until it is in its last stage.
  pid_t start_long(const std::function<void()>& before = {}) {
    const pid_t child = start({QUOIN_PROGRAM, "run", small_, "--out", out(), "--threads", "1", "--set",
                               "stage.shear.velocity=1e-6", "--set", "output.plots=false"},
                              -1, [before] {
                                in_time(120);
                                if (before) before();
                              });
    while (read_all(folder_ / "stderr").find("2/2 shear") == std::string::npos && waitpid(child, nullptr, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return child;
  }
  std::vector<std::string> parts() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(out()))
      if (entry.path().extension() == ".part") names.push_back(entry.path().string());
    return names;
  }
};

// A pipe without a writer, a device without end, a folder, and a very large file are refused as input.
TEST_F(Fire, WhatIsNoFileIsNoInput) {
  const fs::path pipe = folder_ / "pipe", zero = folder_ / "zero.off", large = folder_ / "large.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", zero);
  std::ofstream(large) << "dn,ds,dt\n";
  fs::resize_file(large, std::uintmax_t{1} << 30);  // a sparse file, which uses few bytes of the disk
  const auto expect_refused = [&](const std::vector<std::string>& words, const std::string& file) {
    EXPECT_EQ(quoin_in_time(words), 3) << error_;
    EXPECT_THAT(error_, AllOf(HasSubstr(file + ": cannot read it"), Not(HasSubstr("internal error")))) << words[0];
  };
  for (const fs::path& file : {pipe, fs::path("/dev/zero"), folder_, large}) {
    expect_refused({"check", file.string()}, file.string());
    expect_refused({"run", file.string(), "--out", out()}, file.string());
    expect_refused({"path", file.string()}, file.string());
    expect_refused({"path", "--law", "elastic", "--set", "normal_stiffness=1e9", "--jumps", file.string(), "--out",
                    (folder_ / "out.csv").string()},
                   file.string());
  }
  std::string blocks = read_all(QUOIN_SCENES "/arch.toml");
  blocks += "\n[[block]]\nname = \"mesh\"\nmaterial = \"stone\"\nmesh = \"zero.off\"\n";
  const std::string scene = write("mesh.toml", blocks);
  EXPECT_EQ(quoin_in_time({"check", scene}), 3);
  EXPECT_THAT(error_, HasSubstr("zero.off"));
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(Fire, InitialStatesAreToldByFileAndLine) {
  const std::string scene =
      wall_with("law = \"fracture_energy\"", "initial_state = \"wet\"\nlaw = \"fracture_energy\"");
  for (const char* command : {"check", "run"}) {
    EXPECT_EQ(quoin({command, scene}), 3);
    EXPECT_THAT(error_,
                AllOf(HasSubstr("changed.toml:10: joints.mortar.initial_state = 'wet'"), HasSubstr("bonded, dry")));
  }
}

// Before the first load the unbalanced ratio has no value; a history then has an empty cell.
TEST_F(Fire, HistoriesHoldFiniteNumbersOnly) {
  ASSERT_EQ(quoin(short_run(small_)), 0) << error_;
  EXPECT_THAT(read_all(out() + "/history.csv"), AllOf(Not(HasSubstr("inf")), Not(HasSubstr("nan"))));
}

TEST_F(Fire, LawsWithoutTextsRunAsOthers) {
  const auto with_bad_law = [] {
    in_time();
    setenv("QUOIN_BAD_LAW", "null texts", 1);
  };
  std::vector<std::string> words = short_run(small_, {"--law", QUOIN_BAD_LAW_LIBRARY});
  ASSERT_EQ(quoin(words, with_bad_law), 0) << error_;
  EXPECT_EQ(summary()["laws"]["mortar"]["version"], "");
  EXPECT_EQ(quoin({"check", small_, "--law", QUOIN_BAD_LAW_LIBRARY}, with_bad_law), 0) << error_;
  EXPECT_EQ(quoin({"models", QUOIN_BAD_LAW_LIBRARY}, with_bad_law), 0) << error_;
}

TEST_F(Fire, IdsOfStatesDoNotTearVtuFiles) {
  ASSERT_EQ(quoin({"run", small_, "--out", out(), "--threads", "1", "--law", QUOIN_BAD_LAW_LIBRARY, "--set",
                   "stage.2.displacement=1e-5", "--set", "output.frames=1", "--set", "output.plots=false"},
                  [] { setenv("QUOIN_BAD_LAW", "odd state", 1); }),
            0)
      << error_;
  const std::string file = read_all(out() + "/joints_0000.vtu");
  EXPECT_THAT(file.substr(0, file.find("<AppendedData")), HasSubstr("Name=\"state_a&lt;b&gt;&amp;&quot;c&quot;\""));
}

// A plot program that never ends, and no plot program.
TEST_F(Fire, PicturesDoNotHoldResults) {
  const fs::path tools = folder_ / "tools";
  fs::create_directories(tools);
  std::ofstream(tools / "gnuplot") << "#!/bin/sh\nexec sleep 1000\n";
  fs::permissions(tools / "gnuplot", fs::perms::owner_all);
  const std::vector<std::string> words{
      "run",   small_,           "--out", out(), "--threads", "1", "--set", "stage.2.displacement=1e-5",
      "--set", "output.frames=0"};
  ASSERT_EQ(quoin(words,
                  [&] {
                    in_time();
                    setenv("PATH", (tools.string() + ":/usr/bin:/bin").c_str(), 1);
                    setenv("QUOIN_PLOT_SECONDS", "0.5", 1);
                  }),
            0)
      << error_;
  EXPECT_THAT(error_, HasSubstr("no curve.png: gnuplot was stopped after 0.5 s"));
  EXPECT_EQ(summary()["status"], "done");
  EXPECT_FALSE(fs::exists(out() + "/curve.png"));
  EXPECT_THAT(parts(), IsEmpty());
  ASSERT_EQ(quoin(words, [&] { setenv("PATH", folder_.c_str(), 1); }), 0) << error_;
  EXPECT_THAT(error_, HasSubstr("no curve.png: gnuplot is not installed"));
  EXPECT_EQ(summary()["status"], "done");
}

// At Ctrl-C the plot program ends, with what it has started, and the rest of the results is written. The run was
// "done", so that pictures could not be had any more.
TEST_F(Fire, CtrlCEndsAPlotProgramThatHangsAndResumeDraws) {
  const fs::path tools = folder_ / "tools", sleeper = tools / "sleeper";
  fs::create_directories(tools);
  std::ofstream(tools / "gnuplot") << "#!/bin/sh\nsleep 1000 &\necho $! > '" << sleeper.string() << "'\nwait\n";
  fs::permissions(tools / "gnuplot", fs::perms::owner_all);
  const pid_t child = start({QUOIN_PROGRAM, "run", small_, "--out", out(), "--threads", "1", "--set",
                             "stage.2.displacement=1e-5", "--set", "output.frames=0"},
                            -1, [&] {
                              in_time(120);
                              setenv("PATH", (tools.string() + ":/usr/bin:/bin").c_str(), 1);
                            });
  for (int i = 0; i < 600 && read_all(sleeper).empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  kill(child, SIGINT);
  EXPECT_EQ(finish(child), 130);
  EXPECT_EQ(summary()["status"], "interrupted");
  EXPECT_EQ(summary()["interrupted"], true);
  EXPECT_THAT(error_, HasSubstr("quoin run --resume " + out()));
  EXPECT_THAT(parts(), IsEmpty());
  const std::string process = read_all(sleeper);
  ASSERT_FALSE(process.empty());
  EXPECT_THAT(read_all("/proc/" + process.substr(0, process.find('\n')) + "/cmdline"), IsEmpty()) << "it has ended";
  const std::string history = read_all(out() + "/history.csv");
  EXPECT_EQ(quoin_in_time({"run", "--resume", out(), "--threads", "1"}), 0) << error_;
  EXPECT_THAT(error_, HasSubstr("resumed at step"));
  EXPECT_TRUE(fs::exists(out() + "/curve.png") || error_.find("gnuplot is not installed") != std::string::npos)
      << error_;
  EXPECT_EQ(read_all(out() + "/history.csv"), history);
  EXPECT_EQ(summary()["status"], "done");
  EXPECT_FALSE(fs::exists(out() + "/checkpoint.bin"));
}

// Files are limited to 40 kB, as on a nearly full disk: pictures and frames fail, history and summary are kept.
TEST_F(Fire, FullDisksLeaveNoFileThatIsNotWhole) {
  const auto small_files = [] {
    in_time();
    const rlimit limit{40000, 40000};
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  EXPECT_EQ(quoin({"run", QUOIN_SCENES "/solid_wall_030.toml", "--out", out(), "--threads", "1", "--set",
                   "stage.shear.displacement=1e-6", "--set", "output.frames=1", "--set", "stage.1.record_interval=1000",
                   "--set", "stage.2.record_interval=1000"},
                  small_files),
            3)
      << error_;
  EXPECT_THAT(error_, AllOf(HasSubstr("no more frames for ParaView"), HasSubstr("curve.png")));
  EXPECT_THAT(parts(), IsEmpty());
  EXPECT_EQ(summary()["status"], "done");
  for (const auto& entry : fs::recursive_directory_iterator(out())) {
    const bool empty = entry.is_regular_file() && entry.file_size() == 0;
    EXPECT_FALSE(empty && entry.path().extension() != ".log") << entry.path();
    EXPECT_NE(entry.path().extension(), ".png");
    EXPECT_NE(entry.path().extension(), ".vtu");
  }
}

TEST_F(Fire, ResultsThatDoNotFitAreRefusedBeforeTheWork) {
  const std::vector<std::string> words{"run",   QUOIN_SCENES "/solid_wall_030.toml",
                                       "--out", out(),
                                       "--set", "output.frames=100000",
                                       "--set", "wall.zones=[16,8,8]"};
  const double most = 144.0 * 16 * 8 * 8 * 5 * 77 * 1e5;
  if (static_cast<double>(fs::space(folder_).available) > most) GTEST_SKIP() << "the disk takes " << most << " bytes";
  EXPECT_EQ(quoin(words, [] { in_time(300); }), 3) << error_;
  EXPECT_THAT(error_, AllOf(HasSubstr("output.frames = 100000"), ContainsRegex("need about .* MB and .* MB are free")));
  EXPECT_FALSE(fs::exists(out() + "/history.csv"));
}

// Commands that write one file wrote over their own input, which was lost.
TEST_F(Fire, NamedOutputsAreNoInputs) {
  const std::string jumps = write("in.csv", "dn,ds,dt\n-1e-6,0,0\n"),
                    couplet = write("cpl.csv", "dn,sigma\n1e-6,1e4\n");
  const fs::path test = folder_ / "test.toml";
  fs::copy_file(QUOIN_TESTS "/law/paths/couplet.toml", test);
  const auto refused = [&](const std::vector<std::string>& words, const std::string& input) {
    const std::string before = read_all(input);
    EXPECT_EQ(quoin_in_time(words), 3) << error_;
    EXPECT_THAT(error_, HasSubstr("is an input of this command")) << input;
    EXPECT_EQ(read_all(input), before);
  };
  refused({"path", "--law", "elastic", "--set", "normal_stiffness=1e9", "--set", "shear_stiffness=1e9", "--jumps",
           jumps, "--out", (folder_ / "." / "in.csv").string()},
          jumps);
  refused({"path", test.string(), "--out", test.string()}, test.string());
  refused({"fit", "--couplet", couplet, "--set", "normal_stiffness=8e10", "--set", "shear_stiffness=36e9", "--out",
           couplet},
          couplet);
}

// Output to a device or a link does not replace it; a folder and a dangling link are refused.
TEST_F(Fire, NamedOutputsDoNotReplaceDevicesAndLinks) {
  const std::string jumps = write("in.csv", "dn,ds,dt\n-1e-6,0,0\n");
  const auto path_to = [&](const std::string& file) {
    return quoin_in_time({"path", "--law", "elastic", "--set", "normal_stiffness=1e9", "--set", "shear_stiffness=1e9",
                          "--jumps", jumps, "--out", file});
  };
  const fs::path target = folder_ / "target.csv", link = folder_ / "link.csv", dangling = folder_ / "dangling.csv",
                 device = folder_ / "null";
  write("target.csv", "old");
  fs::create_symlink(target, link);
  fs::create_symlink(folder_ / "nothing", dangling);
  ASSERT_EQ(path_to(link.string()), 0) << error_;
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_THAT(read_all(target), HasSubstr("dn,ds,dt,sigma"));
  EXPECT_EQ(path_to(dangling.string()), 3);
  EXPECT_THAT(error_, HasSubstr("leads to no file"));
  EXPECT_EQ(path_to(folder_.string()), 3);
  EXPECT_THAT(error_, HasSubstr("is a folder"));
  ASSERT_EQ(path_to("/dev/stdout"), 0) << error_;
  EXPECT_THAT(out_ + read_all(folder_ / "stdout"), HasSubstr("dn,ds,dt,sigma"));
  if (mknod(device.c_str(), S_IFCHR | 0600, makedev(1, 3)) != 0) GTEST_SKIP() << "only root makes devices";
  EXPECT_EQ(path_to(device.string()), 0) << error_;
  EXPECT_TRUE(fs::is_character_file(device));
  const fs::path full = folder_ / "full";
  ASSERT_EQ(mknod(full.c_str(), S_IFCHR | 0600, makedev(1, 7)), 0);
  EXPECT_EQ(path_to(full.string()), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr("cannot be written"), HasSubstr("No space left")));
  EXPECT_TRUE(fs::is_character_file(full));
}

// With standard output or error closed or full the results are written, and the exit code reports the lost output.
TEST_F(Fire, OutputsThatAreGoneDoNotLoseTheRun) {
  const auto to = [](int descriptor, const char* file) {
    return [descriptor, file] {
      in_time();
      close(descriptor);
      if (*file != '\0') open(file, O_WRONLY);
    };
  };
  for (const char* file : {"", "/dev/full"}) {
    EXPECT_EQ(quoin(short_run(small_), to(STDOUT_FILENO, file)), 3) << error_;
    EXPECT_THAT(error_, HasSubstr("standard output cannot be written"));
    EXPECT_EQ(summary()["status"], "done");
    fs::remove_all(out());
    EXPECT_EQ(quoin(short_run(small_), to(STDERR_FILENO, file)), 0);
    EXPECT_EQ(summary()["status"], "done");
    EXPECT_THAT(read_all(out() + "/history.csv"), Not(HasSubstr("stage 1/2"))) << "words in the place of another file";
    fs::remove_all(out());
    EXPECT_EQ(quoin({"models"}, to(STDOUT_FILENO, file)), 3);
    EXPECT_EQ(quoin({"--help"}, to(STDOUT_FILENO, file)), 3);
    EXPECT_EQ(quoin({"run", "/nowhere.toml"}, to(STDERR_FILENO, file)), 3);
  }
}

TEST_F(Fire, SignalsOfTheTerminalKeepWhatWasComputed) {
  for (const int signal : {SIGHUP, SIGPIPE, SIGTERM}) {
    const pid_t child = start_long();
    kill(child, signal);
    EXPECT_EQ(finish(child), 130) << error_;
    EXPECT_TRUE(summary()["interrupted"]);
    EXPECT_TRUE(fs::exists(out() + "/history.csv"));
    EXPECT_THAT(parts(), IsEmpty());
  }
  // Under nohup a run continues without its terminal.
  const pid_t child = start_long([] { std::signal(SIGHUP, SIG_IGN); });
  kill(child, SIGHUP);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "it runs on";
  kill(child, SIGINT);
  EXPECT_EQ(finish(child), 130);
}

// Two signals at once, or while files are written, end no program: a shell and mpirun repeat those of a terminal.
TEST_F(Fire, ASecondSignalLeavesResultsAndACheckpoint) {
  for (const auto& [second, gap] : {std::pair{SIGINT, 0}, {SIGTERM, 5}, {SIGINT, 20}}) {
    SCOPED_TRACE(fmt::format("signal {} after {} ms", second, gap));
    fs::remove_all(out());
    const pid_t child = start_long();
    kill(child, SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(gap));
    kill(child, second);
    kill(child, second);
    ASSERT_EQ(finish(child), 130) << error_;
    EXPECT_THAT(error_, HasSubstr("what was computed is kept"));
    EXPECT_TRUE(summary()["interrupted"]);
    EXPECT_THAT(parts(), IsEmpty());
    const std::string history = read_all(out() + "/history.csv");
    EXPECT_GT(history.size(), 200u);
    ASSERT_TRUE(fs::exists(out() + "/checkpoint.bin"));
    const pid_t again = start({QUOIN_PROGRAM, "run", "--resume", out(), "--threads", "1"}, -1, [] { in_time(120); });
    while (read_all(folder_ / "stderr").find("resumed at step") == std::string::npos &&
           waitpid(again, nullptr, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    kill(again, SIGINT);
    ASSERT_EQ(finish(again), 130) << error_;
    const std::string but_the_end = history.substr(0, history.rfind('\n', history.size() - 2) + 1);
    EXPECT_TRUE(read_all(out() + "/history.csv").starts_with(but_the_end)) << "it goes on where it was";
  }
}

// The second signal comes while the pictures are drawn, which takes long: they are left out.
TEST_F(Fire, ASecondSignalEndsPicturesAlone) {
  const fs::path tools = folder_ / "tools", draws = tools / "draws";
  fs::create_directories(tools);
  std::ofstream(tools / "gnuplot") << "#!/bin/sh\ntouch '" << draws.string() << "'\nexec sleep 1000\n";
  fs::permissions(tools / "gnuplot", fs::perms::owner_all);
  const pid_t child = start({QUOIN_PROGRAM, "run", small_, "--out", out(), "--threads", "1", "--set",
                             "stage.shear.velocity=1e-6", "--set", "output.frames=0"},
                            -1, [&] {
                              in_time(120);
                              setenv("PATH", (tools.string() + ":/usr/bin:/bin").c_str(), 1);
                            });
  while (read_all(folder_ / "stderr").find("2/2 shear") == std::string::npos && waitpid(child, nullptr, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  kill(child, SIGINT);
  while (!fs::exists(draws) && waitpid(child, nullptr, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  kill(child, SIGINT);
  EXPECT_EQ(finish(child), 130);
  EXPECT_TRUE(summary()["interrupted"]);
  EXPECT_TRUE(fs::exists(out() + "/history.csv") && fs::exists(out() + "/checkpoint.bin"));
  EXPECT_THAT(parts(), IsEmpty());
}

// A law that does not return keeps a run from stopping. The third signal ends it, two seconds after the first.
TEST_F(Fire, AThirdSignalTwoSecondsLaterEndsTheProgram) {
  std::vector<std::string> words = short_run(small_, {"--law", QUOIN_BAD_LAW_LIBRARY});
  words.insert(words.begin(), QUOIN_PROGRAM);
  const pid_t child = start(words, -1, [] {
    in_time(60);
    setenv("QUOIN_BAD_LAW", "wait", 1);
  });
  while (read_all(folder_ / "stderr").find("1/2 precompression") == std::string::npos &&
         waitpid(child, nullptr, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  for (const int milliseconds : {100, 100, 2100}) {
    EXPECT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "it runs on";
    kill(child, SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
  }
  EXPECT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "it runs on";
  kill(child, SIGINT);
  EXPECT_EQ(finish(child), 130);
  EXPECT_FALSE(fs::exists(out() + "/summary.json"));
}

// Output into a pipe whose reader has ended.
TEST_F(Fire, AReaderThatLeavesStopsTheRunAsCtrlCDoes) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t child = start({QUOIN_PROGRAM, "run", small_, "--out", out(), "--threads", "1", "--set",
                             "stage.shear.velocity=1e-6", "--set", "output.plots=false"},
                            ends[1], [&] {
                              in_time(120);
                              close(ends[0]);
                            });
  close(ends[1]);
  char buffer[100];
  EXPECT_GT(read(ends[0], buffer, sizeof buffer), 0);
  close(ends[0]);
  EXPECT_EQ(finish(child), 130);
  EXPECT_TRUE(summary()["interrupted"]);
}

TEST_F(Fire, ThreadsThatDoNotStartAreToldAndDoneWithout) {
#ifdef QUOIN_SANITIZED
  GTEST_SKIP() << "a sanitizer wants to be the first library";
#endif
  EXPECT_EQ(quoin({"run", small_, "--out", out(), "--threads", "600", "--set", "stage.2.displacement=1e-6", "--set",
                   "output.frames=0"},
                  [] {
                    in_time();
                    setenv("LD_PRELOAD", QUOIN_FEW_THREADS_LIBRARY, 1);
                  }),
            0)
      << error_;
  EXPECT_THAT(error_, HasSubstr("warning: the machine started 2 threads of the 600 wanted"));
  EXPECT_EQ(summary()["threads"], 2) << "one thread more watches laws";
  EXPECT_TRUE(fs::exists(out() + "/plots/curve.gp")) << "written without a thread of its own";
}

// If a law ends the program, the message has its name, and the exit code is not 0.
TEST_F(Fire, LawsThatEndTheProgramAreNamed) {
  const std::string library = QUOIN_BAD_LAW_LIBRARY;
  const auto doing = [](const char* what) {
    return [what] {
      in_time();
      const rlimit none{0, 0};
      setrlimit(RLIMIT_CORE, &none);
      setenv("QUOIN_BAD_LAW", what, 1);
      setenv("ASAN_OPTIONS", "handle_segv=0:detect_leaks=0", 1);  // otherwise a sanitizer would report the crash
    };
  };
  for (const auto& [what, words] :
       {std::pair{"crash", "crashed (SIGSEGV)"}, {"exit", "called exit()"}, {"abort", "aborted"}}) {
    for (const char* threads : {"1", "2"}) {
      std::vector<std::string> run = short_run(small_, {"--law", library});
      run[5] = threads;
      EXPECT_EQ(quoin(run, doing(what)), 5) << what << error_;
      EXPECT_THAT(error_, AllOf(HasSubstr("law of " + library), HasSubstr(words)));
      EXPECT_FALSE(fs::exists(out() + "/summary.json"));
    }
  }
  for (const auto& [what, words] : {std::pair{"crash at load", "crashed (SIGSEGV) while it was loaded"},
                                    {"exit at load", "called exit(0) or _exit(0) while"}}) {
    EXPECT_EQ(quoin({"check", small_, "--law", library}, doing(what)), 4) << what << error_;
    EXPECT_THAT(error_, AllOf(HasSubstr(library), HasSubstr(words)));
  }
  for (const char* what : {"huge text", "growing text"})
    EXPECT_EQ(quoin(short_run(small_, {"--law", library}), doing(what)), 0) << what << error_;
}

// A law in C++ may throw. One that went on to throw lost the summary and was reported as a fault of Quoin.
TEST_F(Fire, LawsThatThrowAreNamedAndResultsAreKept) {
  const std::string library = QUOIN_BAD_LAW_LIBRARY;
  const auto throwing = [](const char* what) {
    return [what] {
      in_time();
      setenv("QUOIN_BAD_LAW", what, 1);
    };
  };
  const auto names_the_law =
      AllOf(HasSubstr("the law 'bad_law' of " + library + " threw an exception"), Not(HasSubstr("internal error")));
  for (const auto& [what, words] : {std::pair{"throw", "no std::exception"}, {"throw words", "\"words of a law\""}}) {
    for (const char* threads : {"1", "2"}) {
      for (const char* motion : {"never", "always"}) {
        std::vector<std::string> run =
            short_run(small_, {"--law", library, "--set", std::string("solver.large_motion=") + motion});
        run[5] = threads;
        EXPECT_EQ(quoin(run, throwing(what)), 5) << what << error_;
        EXPECT_THAT(error_,
                    AllOf(names_the_law, HasSubstr(words),
                          ContainsRegex("step [0-9]+, contact points [0-9]+ to [0-9]+ of joint family 'mortar'")));
        EXPECT_EQ(summary()["status"], "failed") << "what was computed is kept";
        EXPECT_TRUE(summary()["contact_points_by_state"]["open"].is_null());
      }
    }
  }
  for (const char* what : {"throw at once", "throw at creation", "throw at start"}) {
    EXPECT_EQ(quoin(short_run(small_, {"--law", library}), throwing(what)), 4) << what << error_;
    EXPECT_THAT(error_, AllOf(names_the_law, HasSubstr("words of a law"))) << what;
  }
}

// Energies that a law does not compute were zeros, and the run warned that -100 % had no source.
TEST_F(Fire, EnergiesThatALawDoesNotComputeAreEmpty) {
  for (const char* motion : {"never", "always"}) {
    ASSERT_EQ(quoin(short_run(small_, {"--law", QUOIN_BAD_LAW_LIBRARY, "--set", "output.energy=true", "--set",
                                       std::string("solver.large_motion=") + motion}),
                    [] { setenv("QUOIN_BAD_LAW", "no energies", 1); }),
              0)
        << error_;
    EXPECT_THAT(error_, Not(HasSubstr("energies do not balance"))) << motion;
    EXPECT_TRUE(summary()["watch"]["energy_missing_over_moved"].is_null()) << motion;
    EXPECT_TRUE(summary()["energy_J"]["dissipated"].is_null()) << motion;
    const std::map<std::string, std::string> last = last_row();
    for (const char* column : {"contact_energy_J", "dissipated_tension_J", "dissipated_cohesion_J",
                               "dissipated_friction_J", "dissipated_crushing_J", "energy_balance_error_J"})
      EXPECT_EQ(last.at(column), "") << motion << column;
    for (const char* column : {"kinetic_energy_J", "strain_energy_J", "external_work_J"})
      EXPECT_NE(last.at(column), "") << motion << column;
  }
}

// Broken libraries beside good ones: a message for each, and the good ones are listed.
TEST_F(Fire, BrokenLibrariesDoNotHideTheOthers) {
  const fs::path laws = folder_ / "laws";
  fs::create_directories(laws);
  const fs::path good = fs::path(QUOIN_PROGRAM).parent_path() / "laws" / "elastic.so";
  const std::string whole = read_all(good);
  std::ofstream(laws / "a_half.so") << whole.substr(0, whole.size() / 2);
  std::ofstream(laws / "a_little_less.so") << whole.substr(0, whole.size() - 1);
  std::ofstream(laws / "an_empty.so");
  fs::copy_file(QUOIN_BAD_LAW_LIBRARY, laws / "bad_law.so");
  for (const auto& [what, words] :
       {std::pair{"crash at load", "bad_law +cannot be used: .*crashed .SIGSEGV. while it was loaded"},
        {"exit at load", "bad_law +cannot be used: .*called exit.0. or _exit.0. while"},
        {"wait at load", "bad_law +cannot be used: .*did not come back within 10 s"}}) {
    EXPECT_EQ(quoin({"models"},
                    [&, what = what] {  // clang 14 does not capture structured bindings
                      in_time();
                      setenv("QUOIN_LAW_PATH", laws.c_str(), 1);
                      setenv("QUOIN_BAD_LAW", what, 1);
                    }),
              0)
        << error_;
    EXPECT_THAT(out_, AllOf(ContainsRegex("a_half +cannot be used: .*it is not whole"),
                            ContainsRegex("a_little_less +cannot be used: .*it is not whole"),
                            ContainsRegex("an_empty +cannot be used: .*the file is empty"), ContainsRegex(words),
                            ContainsRegex("\nfracture_energy +[0-9]"), ContainsRegex("\nelastic +[0-9]")));
  }
  EXPECT_EQ(quoin(short_run(small_, {"--law", (laws / "a_half.so").string()})), 4);
  EXPECT_THAT(error_, AllOf(HasSubstr("a_half.so"), HasSubstr("it is not whole"), HasSubstr("build it again")));
}

// With selective_time_step a promotion is not possible, since large motion has no such step.
TEST_F(Fire, LargeMotionRefusesASelectiveTimeStepBeforeTheLatticeIsLeft) {
  EXPECT_EQ(quoin({"run", small_, "--out", out(), "--threads", "1", "--set", "solver.selective_time_step=0.5", "--set",
                   "output.plots=false"},
                  [] { in_time(); }),
            5)
      << error_;
  EXPECT_THAT(error_, AllOf(HasSubstr("stage 'shear'"), HasSubstr("large motion"),
                            HasSubstr("takes no solver.selective_time_step; make that smaller than 0.5 s")));
  EXPECT_EQ(summary()["status"], "failed") << "what was computed is kept";
}

// TOML that would exhaust the parser's stack or memory is refused before parsing, with less than half a gigabyte.
TEST_F(Fire, TomlBeyondAllMeasureIsRefusedBeforeItIsParsed) {
  std::string key = "a", tables, list = "x = [";
  for (int i = 0; i < 100000; ++i) key += ".a";
  for (int i = 0; i < 2000000; ++i) tables += "[[stage]]\n";
  for (int i = 0; i < 5000000; ++i) list += "1,";
  const auto in_little_memory = [] {
    in_time();
#ifndef QUOIN_SANITIZED
    const rlimit memory{1ul << 29, 1ul << 29};
    setrlimit(RLIMIT_AS, &memory);
#endif
  };
  for (const auto& [text, words] : {std::pair{"# \"\nb = 'it' # '''\n" + key + " = 1\n", ":3: a key has more than 100"},
                                    {"c = '''\n.\n'''\n[" + key + "]\n", ":4: a key has more than 100 parts"},
                                    {"x = { " + key + " = 1 }\n", ":1: a key has more than 100 parts"},
                                    {tables, ":200001: more than 200000 tables"},
                                    {list + "1]\n", ":1: more than 4000000 values"}}) {
    const std::string file = write("large.toml", text);
    for (const char* const command : {"check", "path"}) {
      EXPECT_EQ(quoin({command, file}, in_little_memory), 3) << error_;
      EXPECT_THAT(error_, HasSubstr(file + words)) << command;
    }
  }
  // An argument of a command line has at most 128 KB.
  EXPECT_EQ(quoin({"check", small_, "--set", key.substr(0, 100001) + "=1"}, in_little_memory), 3);
  EXPECT_THAT(error_, HasSubstr("the key has more than 100 parts"));
}

// Control characters in names and titles of scenes and meshes, and on the command line, are escaped on the terminal.
TEST_F(Fire, ControlCharactersDoNotReachTheTerminal) {
  for (const char* const escape : {"\\u001b[31m", "\\U0000009b31m", "\\b", "\x7f", "\xc2\x9b"}) {
    const std::string file = write("title.toml", std::string("# \x1b in a comment\ntitle = \"red ") + escape + "\"\n");
    EXPECT_EQ(quoin({"check", file}), 3) << escape;
    EXPECT_THAT(error_, HasSubstr(file + ":2: a text holds a control character")) << escape;
  }
  EXPECT_EQ(quoin({"check", write("fine.toml", "title = \"caf\u00e9 \\u00e9 \\n\\t '\\\\b'\"\n")}), 3);
  EXPECT_THAT(error_, Not(HasSubstr("control character"))) << "wanting all else";
  EXPECT_EQ(quoin({"check", folder_ / "no\x1b[31m.toml"}), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr("no\\x1b[31m.toml"), Not(HasSubstr("\x1b"))));
}

// Copying a new version over the file of a law during a run does not end the run.
TEST_F(Fire, LawsMayBeOverwrittenWhileTheyRun) {
  const fs::path law = folder_ / "my_law.so";
  fs::copy_file(fs::path(QUOIN_PROGRAM).parent_path() / "laws" / "fracture_energy.so", law);
  ASSERT_EQ(quoin(short_run(small_, {"--law", law.string()})), 0) << error_;
  const std::string undisturbed = read_all(out() + "/history.csv");
  const pid_t child = start({QUOIN_PROGRAM, "run", small_, "--out", out(), "--threads", "1", "--law", law.string(),
                             "--set", "stage.shear.velocity=1e-6", "--set", "output.plots=false"},
                            -1, [] { in_time(120); });
  while (read_all(folder_ / "stderr").find("2/2 shear") == std::string::npos && waitpid(child, nullptr, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::ofstream(law, std::ios::trunc) << "short";  // in place, as cp does
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  kill(child, SIGINT);
  EXPECT_EQ(finish(child), 130) << error_;
}

// Models, paths and steps that are too large for any machine are refused immediately, with numbers.
TEST_F(Fire, WorkWithoutAnEndIsRefusedBeforeItBegins) {
  const std::string deformable = write("block.toml", R"([materials.stone]
young_modulus = 10e9
poisson_ratio = 0.2
density = 2000.0
[joints.dry]
law = "elastic"
normal_stiffness = 1e10
shear_stiffness = 1e10
[[block]]
material = "stone"
rigid = false
divisions = [200, 200, 200]
box = { size = [1, 1, 1] }
[[block]]
material = "stone"
rigid = false
divisions = [200, 200, 200]
box = { lower = [0, 1, 0], size = [1, 1, 1] }
[[stage]]
gravity = [0, -9.81, 0]
duration = 1
)");
  const std::string path = write("path.toml",
                                 "law = \"elastic\"\n[properties]\nnormal_stiffness = 1e9\n[[point]]\n"
                                 "dn = 1e-6\nsteps = 1e8\n");
  const auto here = [](double gigabytes) {
    return [gigabytes] {
      in_time(20);
      const rlimit limit{static_cast<rlim_t>(gigabytes * 1e9), static_cast<rlim_t>(gigabytes * 1e9)};
      setrlimit(RLIMIT_AS, &limit);
    };
  };
#ifdef QUOIN_SANITIZED
  GTEST_SKIP() << "sanitizers take all addresses";
#endif
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"check", deformable},
        {"check", small_, "--set", "wall.courses=10000", "--set", "wall.units_per_course=10000"},
        {"run", small_, "--out", out(), "--set", "wall.zones=[64,64,64]", "--set", "wall.courses=100"},
        {"path", path}}) {
    EXPECT_EQ(quoin(words, here(16)), 3) << words[1];
    EXPECT_THAT(error_, AllOf(ContainsRegex("about .* GB of memory|at most can be numbered"),
                              AnyOf(HasSubstr("--force"), HasSubstr("smaller"))));
  }
  // A wall that fits in 8 GB, and not in a smaller memory.
  EXPECT_EQ(quoin({"check", QUOIN_SCENES "/solid_wall_030.toml"}, here(8)), 0) << error_;
  EXPECT_THAT(out_, ContainsRegex("memory of the model about [1-9] MB of 8000 MB here"));
  const std::vector<std::string> larger{"check", QUOIN_SCENES "/solid_wall_030.toml", "--set", "wall.zones=[32,16,16]"};
  EXPECT_EQ(quoin(larger, here(0.25)), 3);
  EXPECT_THAT(error_, HasSubstr("--force"));
  EXPECT_EQ(quoin({"check", small_, "--set", "joints.mortar.normal_stiffness=1e300"}, here(8)), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr("joints.mortar"), HasSubstr("1e+300"), HasSubstr("0 to 1e+20 Pa/m"),
                            HasSubstr("lower the stiffness")));
}

// Estimated times of very long and of short runs are printed with numbers.
TEST_F(Fire, TimeIsToldBeforeTheWork) {
  EXPECT_EQ(quoin_in_time({"check", small_}), 0) << error_;
  EXPECT_THAT(out_, ContainsRegex("computing time about [0-9.]+ s, .* steps with [0-9]+ threads here"));
  const std::vector<std::string> slow{"check", small_, "--set", "stage.shear.velocity=1e-12"};
  EXPECT_EQ(quoin_in_time(slow), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr("steps of"), HasSubstr("30.0 days"), HasSubstr("--force")));
  std::vector<std::string> forced = slow;
  forced.emplace_back("--force");
  EXPECT_EQ(quoin_in_time(forced), 0) << error_;
}

TEST_F(Fire, FormulasHaveAnEnd) {
  const auto with_formula = [&](const std::string& formula) {
    const std::string file = write("path.toml",
                                   "law = \"elastic\"\n[properties]\nnormal_stiffness = 1e9\nshear_stiffness = 1e9\n"
                                   "[[point]]\ndn = \"" +
                                       formula + "\"\n");
    return quoin_in_time({"path", file});
  };
  EXPECT_EQ(with_formula(std::string(100, '(') + "1e-9" + std::string(100, ')')), 0) << error_;
  for (const std::string& deep : {std::string(20000, '(') + "1" + std::string(20000, ')'), std::string(4000, '(') + "1",
                                  std::string(20000, '-') + "1", std::string(9000, '-') + "1"}) {
    EXPECT_EQ(with_formula(deep), 3);
    EXPECT_THAT(error_, AllOf(HasSubstr("path.toml:6"), AnyOf(HasSubstr("deep"), HasSubstr("characters"))));
    EXPECT_LT(error_.size(), 1000u);
  }
  std::string sum = "0", power = "1";
  for (int i = 0; i < 100000; ++i) sum += "+1";
  for (int i = 0; i < 4000; ++i) power += "^1";
  EXPECT_EQ(with_formula(sum), 3);
  EXPECT_EQ(with_formula(power), 3);
}

}  // namespace
