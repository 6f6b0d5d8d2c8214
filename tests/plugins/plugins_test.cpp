// Plug-ins that misbehave. Whatever a law says of itself or answers, the program ends in time with a documented exit
// code and a message that names the law, and keeps what was computed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdint>

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

// What `quoin models`, `quoin check` and the first step do with a law: everything of its tables is read and used.
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

// Each word of each table, by numbers that no table holds: no pointer, a low one, one to nowhere, a count beyond all.
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
  // Sizes, ids, counts, functions, lists and signs: most words mean something that garbage cannot.
  EXPECT_GT(refused, harmless);
  EXPECT_EQ(use_law(""), 0);
}

TEST_F(Plugins, WrongAnswersAreNamed) {
  for (const auto& [deed, words] : {std::pair{"nan", "nan"},
                                    {"infinite", "hostile_law"},
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
}

// Laws that lie about energies and stiffness, of which the watch sees more than one row.
TEST_F(Plugins, LiesAboutEnergyAndStiffnessAreSeen) {
  for (const auto& [deed, about, words] : {std::tuple{"energy 3", "energy_balance", "energies do not balance"},
                                           {"stiff 4", "time_step", "4 times as stiff as the bounds that it states"}}) {
    EXPECT_EQ(quoin(run_with({"--set", "stage.2.displacement=1e-3"}), doing(deed)), 0) << error_;
    EXPECT_THAT(error_, HasSubstr(words)) << deed;
    bool told = false;
    const nlohmann::json all = summary();
    for (const auto& warning : all["warnings"]) told = told || warning["about"] == about;
    EXPECT_TRUE(told) << deed << all["watch"];
  }
}

// Just beyond what is allowed, and just below: 5 % of the energy that was moved; a millionth of the stiffness.
TEST_F(Plugins, SmallLiesAboutEnergyAndStiffnessAreMeasured) {
  const auto told = [&](const std::string& deed, const char* about) {
    EXPECT_EQ(quoin(run_with({"--set", "stage.2.displacement=1e-3", "--set", "output.energy=true"}), doing(deed)), 0)
        << error_;
    const nlohmann::json warnings = summary()["warnings"];
    return std::any_of(warnings.begin(), warnings.end(), [&](const auto& w) { return w["about"] == about; });
  };
  const auto missing = [&] { return std::abs(summary()["watch"]["energy_missing_over_moved"].get<double>()); };
  EXPECT_FALSE(told("energy 1.03", "energy_balance"));
  EXPECT_LT(missing(), 0.05);
  EXPECT_TRUE(told("energy 1.08", "energy_balance"));
  EXPECT_GT(missing(), 0.05);
  EXPECT_LT(missing(), 0.1);
  EXPECT_FALSE(told("stiff 1.0000005", "time_step"));
  EXPECT_TRUE(told("stiff 1.000004", "time_step"));
}

// A thread inside a law cannot be taken out of it: the run ends, with what it has.
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

// In a process of its own, the end of a law costs the law; the results until then are kept.
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

TEST_F(Plugins, IsolatedLawsGiveTheSameBits) {
  std::map<bool, std::pair<std::string, std::string>> results;
  for (const bool isolated : {false, true}) {
    std::vector<std::string> words{"run",       small_,
                                   "--out",     out(),
                                   "--threads", "2",
                                   "--set",     "output.energy=true",
                                   "--set",     "output.plots=false",
                                   "--set",     "output.frames=1",
                                   "--set",     "stage.2.displacement=1e-4"};
    if (isolated) words.push_back("--isolate-law");
    ASSERT_EQ(quoin(words, [] { alarm(120); }), 0) << error_;
    results[isolated] = {read_all(out() + "/history.csv"), summary()["provenance"]["results"]["state"]};
    EXPECT_EQ(out_.find("in a process of its own") != std::string::npos, isolated) << out_;
  }
  EXPECT_TRUE(results[false] == results[true]);
}

}  // namespace
