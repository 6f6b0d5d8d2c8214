// Faulty plug-ins. For any metadata and results of a law the program ends in time and keeps its results. It has a
// documented exit code and a message with the name of the law.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <thread>

#include "../cli/program.h"
#include "base/error.h"
#include "law/law_library.h"
#include "law/material_point.h"

namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class Plugins : public Cli {
 protected:
  std::vector<std::string> run_with(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"run", small_, "--out", out(), "--threads", "2", "--law", QUOIN_HOSTILE_LAW, "--set",
                               "output.frames=0", "--set", "output.plots=false", "--set", "stage.2.displacement=1e-5"});
    return more;
  }
  static std::function<void()> doing(std::string deed) {
    return [deed = std::move(deed)] {
      alarm(60);
      const rlimit none{0, 0};
      setrlimit(RLIMIT_CORE, &none);
      setenv("QUOIN_HOSTILE", deed.c_str(), 1);
    };
  }
  long rows() const {
    std::ifstream history(out() + "/history.csv");
    return std::count(std::istreambuf_iterator<char>(history), {}, '\n');
  }
};

// Uses a law as `quoin models`, `quoin check` and a first step do, which read all its tables. Returns the exit code.
int use_law(const std::string& hostile) {
  setenv("QUOIN_HOSTILE", hostile.c_str(), 1);
  try {
    const quoin::Law law = quoin::Law::find(QUOIN_HOSTILE_LAW);
    std::string all = quoin::law_text(law.library->info().name);
    for (const char* text : {law.law->name, law.law->version, law.law->citation, law.law->description})
      all += quoin::law_text(text);
    for (std::uint64_t i = 0; i < law.law->property_count; ++i) {
      const quoin_property_info& p = *law.law->properties[i];
      for (const char* text : {p.symbol, p.unit, p.description, p.default_from, p.default_text})
        all += quoin::law_text(text);
    }
    quoin::PropertySetting stiffness;
    stiffness.id = "normal_stiffness";
    stiffness.numbers = {1e9};
    const auto material = std::make_shared<const quoin::Material>(law, std::vector{stiffness});
    quoin::MaterialPoint point(material, law.law->initial_states[0]);
    point.move_to(-1e-6, 0.0, 0.0);
    return 0;
  } catch (const quoin::Error& error) {
    return std::string(error.what()).size() > 20 ? static_cast<int>(error.exit_code) : 99;
  }
}

// Replaces each word of each table by invalid values: null, a low pointer, an invalid pointer, a huge count.
TEST_F(Plugins, GarbageInEveryFieldIsRefusedOrHarmless) {
#ifdef QUOIN_SANITIZED
  GTEST_SKIP() << "a count beyond a list is read as far as there is memory: a sanitizer stops there";
#endif
  int refused = 0, harmless = 0;
  for (const auto& [table, words] : {std::pair{"library", sizeof(quoin_library) / 8},
                                     {"law", sizeof(quoin_law) / 8},
                                     {"property", sizeof(quoin_property_info) / 8},
                                     {"state", sizeof(quoin_state_info) / 8},
                                     {"convention", sizeof(quoin_convention) / 8}}) {
    for (std::size_t word = 0; word < words; ++word) {
      for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{0x1000},
                                        std::uint64_t{0x4141414141414141}, ~std::uint64_t{0}}) {
        const std::string hostile = fmt::format("{} {} {:x}", table, word, value);
        const pid_t child = fork();
        if (child == 0) {
          alarm(10);
          const rlimit none{0, 0};
          setrlimit(RLIMIT_CORE, &none);
          _exit(use_law(hostile));
        }
        int status = 0;
        waitpid(child, &status, 0);
        ASSERT_TRUE(WIFEXITED(status)) << hostile << ": signal " << WTERMSIG(status);
        const int code = WEXITSTATUS(status);
        EXPECT_TRUE(code == 0 || code == 4 || code == 5) << hostile << ": " << code;
        ++(code == 0 ? harmless : refused);
      }
    }
  }
  // Most words are sizes, ids, counts, functions, lists and signs, for which such values are refused.
  EXPECT_GT(refused, harmless);
  EXPECT_EQ(use_law(""), 0);
}

TEST_F(Plugins, WrongAnswersAreNamed) {
  for (const auto& [deed, words] : {std::pair{"nan", "gave the traction sigma = nan"},
                                    {"infinite", "gave the traction tau_s = inf"},
                                    {"status", "refused a batch with status 77"},
                                    {"counts", "points failed, and names none"}}) {
    EXPECT_EQ(quoin(run_with(), doing(deed)), 5) << deed << error_;
    EXPECT_THAT(error_, AllOf(HasSubstr("'hostile_law'"), HasSubstr(words), Not(HasSubstr("internal error")))) << deed;
    EXPECT_EQ(summary()["status"], "failed");
    EXPECT_GT(rows(), 1) << "what was computed is kept";
  }
  for (const auto& [deed, words] : {std::pair{"state", "gave the state 'count' = -7, outside of [0, 1e+09]"},
                                    {"state nan", "gave the state 'count' = nan"}}) {
    EXPECT_EQ(quoin(run_with({"--set", "stage.2.displacement=1e-3"}), doing(deed)), 0) << error_;
    EXPECT_THAT(error_, AllOf(HasSubstr("warning: law 'hostile_law'"), HasSubstr(words),
                              HasSubstr("(family 'mortar'), contact point at (0.2200, 0.0000, 0.0000) m")))
        << deed;
    EXPECT_EQ(summary()["warnings"][0]["about"], "law_states");
  }
  // A run that ends before the next check of states, which are rare.
  for (const char* const motion : {"never", "always"}) {
    EXPECT_EQ(quoin(run_with({"--set", std::string("solver.large_motion=") + motion}), doing("state nan")), 0)
        << error_;
    EXPECT_THAT(error_, AllOf(HasSubstr("warning: law 'hostile_law' gave the state 'count' = nan"),
                              HasSubstr("family 'mortar'"), HasSubstr("contact point at (")))
        << motion;
  }
}

// Texts of laws, properties and libraries are printed without control sequences.
TEST_F(Plugins, ControlCharactersOfALawDoNotReachTheTerminal) {
  const std::string bare = "\x1b", reported = "\\x1b[31mred\\xff";
  EXPECT_EQ(quoin(run_with({"--set", "joints.mortar.normal_stiffness=-1"}), doing("escape in words")), 4);
  EXPECT_THAT(error_, AllOf(HasSubstr(reported), HasSubstr("refuses its properties"), Not(HasSubstr(bare))));
  EXPECT_EQ(quoin(run_with(), doing("escape in refusal")), 4);
  EXPECT_THAT(error_, AllOf(HasSubstr(reported), HasSubstr("refuses this host"), Not(HasSubstr(bare))));
  EXPECT_EQ(quoin({"models", QUOIN_HOSTILE_LAW}, doing("escape in name")), 4);
  EXPECT_THAT(error_ + out_, AllOf(HasSubstr("metadata is faulty"), Not(HasSubstr(bare))));
}

// Wrong energies and stiffness of a law are detected by the monitoring of a run, in more than one row.
TEST_F(Plugins, LiesAboutEnergyAndStiffnessAreSeen) {
  for (const auto& [deed, about, words] : {std::tuple{"energy 3", "energy_balance", "energies do not balance"},
                                           {"stiff 4", "time_step", "4 times as stiff as the bounds that it states"}}) {
    for (const char* const motion : {"never", "always"}) {
      EXPECT_EQ(
          quoin(run_with({"--set", "stage.2.displacement=1e-3", "--set", std::string("solver.large_motion=") + motion}),
                doing(deed)),
          0)
          << error_;
      EXPECT_THAT(error_, HasSubstr(words)) << deed << motion;
      bool reported = false;
      const nlohmann::json all = summary();
      for (const auto& warning : all["warnings"]) reported = reported || warning["about"] == about;
      EXPECT_TRUE(reported) << deed << motion << all["watch"];
    }
  }
}

// Errors just above and below the bounds: 5 % of the energy; a millionth of the stiffness.
TEST_F(Plugins, SmallLiesAboutEnergyAndStiffnessAreMeasured) {
  const auto reported = [&](const std::string& deed, const char* about) {
    EXPECT_EQ(quoin(run_with({"--set", "stage.2.displacement=1e-3", "--set", "output.energy=true"}), doing(deed)), 0)
        << error_;
    const nlohmann::json warnings = summary()["warnings"];
    return std::any_of(warnings.begin(), warnings.end(), [&](const auto& w) { return w["about"] == about; });
  };
  const auto missing = [&] { return std::abs(summary()["watch"]["energy_missing_over_moved"].get<double>()); };
  EXPECT_FALSE(reported("energy 1.03", "energy_balance"));
  EXPECT_LT(missing(), 0.05);
  EXPECT_TRUE(reported("energy 1.08", "energy_balance"));
  EXPECT_GT(missing(), 0.05);
  EXPECT_LT(missing(), 0.1);
  EXPECT_FALSE(reported("stiff 1.0000005", "time_step"));
  EXPECT_TRUE(reported("stiff 1.000004", "time_step"));
}

// A thread inside a law cannot be stopped: the run ends with the results so far.
TEST_F(Plugins, LawsThatNeverReturnAreNamedWithTheirBatch) {
  for (const char* deed : {"hang", "spin"}) {
    EXPECT_EQ(quoin(run_with({"--law-seconds", "1"}), doing(deed)), 5) << error_;
    EXPECT_THAT(error_, AllOf(HasSubstr("the law 'hostile_law' of " QUOIN_HOSTILE_LAW), HasSubstr("within 1 s"),
                              ContainsRegex("contact points [0-9]+ to [0-9]+ of joint family 'mortar'"),
                              HasSubstr("--law-seconds")));
    EXPECT_EQ(summary()["status"], "failed");
    EXPECT_TRUE(summary()["contact_points_by_state"]["open"].is_null());
    EXPECT_GT(rows(), 1);
  }
}

// Time steps follow from the stiffness that a law states. 0 is that of a joint without shear.
TEST_F(Plugins, StiffnessBoundsBelowZeroAreRefused) {
  for (const char* deed : {"normal bound -1", "shear bound -1", "shear bound nan"}) {
    EXPECT_EQ(quoin(run_with(), doing(deed)), 3) << deed;
    EXPECT_THAT(error_, AllOf(HasSubstr("law hostile_law is up to"), HasSubstr("allowed: 0 to 1e+20 Pa/m"),
                              HasSubstr("correct the law's stiffness_bounds")))
        << deed;
  }
  EXPECT_EQ(quoin({"check", small_, "--law", QUOIN_HOSTILE_LAW}, doing("shear bound 0")), 0) << error_;
}

// The set-up of a model evaluates laws too: it asks whether they carry tension.
TEST_F(Plugins, LawsThatHangBeforeTheFirstStepAreNamed) {
  const std::string library = QUOIN_HOSTILE_LAW, jumps = out() + ".csv";
  std::ofstream(jumps) << "dn,ds,dt\n-1e-6,0,0\n";
  for (const auto& words : {run_with({"--law-seconds", "1"}),
                            {"check", small_, "--law", library, "--law-seconds", "1"},
                            {"path", "--law", library, "--set", "normal_stiffness=1e9", "--jumps", jumps, "--out",
                             out() + "_path.csv", "--law-seconds", "1"}}) {
    EXPECT_EQ(quoin(words, doing("hang at once")), 5) << words[0] << out_;
    EXPECT_THAT(error_, AllOf(HasSubstr("the law 'hostile_law' of " + library + " has not returned from a batch"),
                              HasSubstr("within 1 s"), HasSubstr("--law-seconds")))
        << words[0];
  }
  EXPECT_FALSE(fs::exists(out() + "/history.csv"));
}

// A law in a separate process may end without ending the program; the results until then are kept.
TEST_F(Plugins, IsolatedLawsEndAlone) {
  for (const auto& [deed, words] : {std::pair{"crash", "crashed (SIGSEGV)"},
                                    {"abort", "aborted"},
                                    {"exit", "called exit(0)"},
                                    {"hang", "did not return from a batch within 1 s"}}) {
    EXPECT_EQ(quoin(run_with({"--isolate-law", "--law-seconds", "1"}), doing(deed)), 5) << deed << error_;
    EXPECT_THAT(error_, AllOf(HasSubstr(std::string("the law of ") + QUOIN_HOSTILE_LAW), HasSubstr(words),
                              HasSubstr("joint family 'mortar'")))
        << deed;
    EXPECT_EQ(summary()["status"], "failed");
    EXPECT_GT(rows(), 1) << "what was computed is kept";
  }
}

// Also with random properties, on the lattice and in large motion.
TEST_F(Plugins, IsolatedLawsGiveTheSameBits) {
  for (const char* const motion : {"never", "always"}) {
    std::map<bool, std::pair<std::string, std::string>> results;
    for (const bool isolated : {false, true}) {
      std::vector<std::string> words{
          "run",       small_,
          "--out",     out(),
          "--threads", "2",
          "--set",     "output.energy=true",
          "--set",     "output.plots=false",
          "--set",     "output.frames=1",
          "--set",     "stage.2.displacement=1e-4",
          "--set",     std::string("solver.large_motion=") + motion,
          "--set",     "joints.mortar.tensile_strength={distribution='lognormal', mean=0.2e6, cov=0.3}",
          "--set",     "joints.mortar.cohesion={distribution='lognormal', mean=0.3e6, cov=0.3, level='joint'}"};
      if (isolated) words.push_back("--isolate-law");
      ASSERT_EQ(quoin(words, [] { alarm(120); }), 0) << error_;
      results[isolated] = {read_all(out() + "/history.csv"), summary()["provenance"]["results"]["state"]};
      EXPECT_EQ(out_.find("in a process of its own") != std::string::npos, isolated) << out_;
    }
    EXPECT_TRUE(results[false] == results[true]) << motion;
  }
}

// Returns sigma of one contact point of the elastic law, closed by 1 um: -1 kPa.
double pressed(const quoin::Material& material) {
  const double jump = -1e-6, zero = 0.0;
  double traction[3] = {};
  quoin_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.normal_jump = {&jump, 1};
  for (auto& slip : batch.slip_increment) slip = {&zero, 1};
  for (int k = 0; k < 3; ++k) batch.traction_old[k] = {&traction[k], 1}, batch.traction_new[k] = {&traction[k], 1};
  return material.evaluate(&batch) == QUOIN_OK ? traction[0] : std::nan("");
}
quoin::Material isolated_elastic() {
  const quoin::LawIsolation before = quoin::isolate_laws({1, 10.0});
  quoin::PropertySetting stiffness;
  stiffness.id = "normal_stiffness", stiffness.numbers = {1e9};
  quoin::PropertySetting shear = stiffness;
  shear.id = "shear_stiffness";
  const fs::path law = fs::path(QUOIN_PROGRAM).parent_path() / "laws" / "elastic.so";
  quoin::Material material(quoin::Law::find(law.string()), {stiffness, shear});
  quoin::isolate_laws(before);
  return material;
}

// A program that forks, as with Python's multiprocessing. The child starts its own process of the law; when the child
// ends, that of the parent continues.
TEST_F(Plugins, IsolatedLawsOutliveAForkedChild) {
  auto material = std::make_unique<quoin::Material>(isolated_elastic());
  ASSERT_EQ(pressed(*material), -1e3);
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);
    const bool answered = pressed(*material) == -1e3 && material->fault().empty();
    material.reset();
    _exit(answered ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(pressed(*material), -1e3) << material->fault();
}

// A material may be created by a thread that ends before the material is evaluated.
TEST_F(Plugins, IsolatedLawsOutliveTheThreadThatMadeThem) {
  std::unique_ptr<quoin::Material> material;
  std::thread([&] { material = std::make_unique<quoin::Material>(isolated_elastic()); }).join();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(pressed(*material), -1e3) << material->fault();
}

// A law that ends the process or never returns when it is loaded: in `run`, `check` and `models LIBRARY`.
TEST_F(Plugins, LawsThatEndOrWaitWhenTheyAreLoadedAreNamed) {
  const std::string library = QUOIN_HOSTILE_LAW;
  for (const auto& words : {run_with(), {"check", small_, "--law", library}, {"models", library}}) {
    EXPECT_EQ(quoin(words, doing("_exit at load")), 4) << words[0] << out_;
    EXPECT_THAT(error_, AllOf(HasSubstr(library + " called exit(0) or _exit(0) while it was loaded"))) << words[0];
  }
  EXPECT_EQ(quoin(run_with({"--law-seconds", "1"}), doing("sleep at load")), 4) << out_;
  EXPECT_THAT(error_, HasSubstr(library + " did not come back within 1 s while it was loaded"));
}

}  // namespace
