// Every kind of damping and every key in the table of scene/damping.cpp: names, readers, texts, coefficients, pages.
#include "scene/damping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "base/error.h"
#include "one_block.h"
#include "scene/read_scene.h"

namespace quoin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

SolverSettings read(std::vector<std::string> settings) {
  for (std::string& setting : settings) setting = "solver." + setting;
  return read_scene_text(kOneBlock, "scene.toml", settings).solver;
}

std::string fault_of(const std::vector<std::string>& settings) {
  try {
    read(settings);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Returns a value other than the default, as text of a scene.
std::string other_value(const DampingNumber& number) {
  if (std::holds_alternative<bool>(number.value)) return "true";
  if (std::holds_alternative<double>(number.value)) return std::to_string(0.5 * std::get<double>(number.value) + 0.01);
  return "[1, 50]";
}

// Returns the settings of a kind of damping, with other keys that this key requires.
std::vector<std::string> base_of(const std::string& kind, const std::string& key) {
  std::vector<std::string> settings{"damping=" + kind};
  if (key == "maxwell_band") settings.push_back("maxwell_damping=0.01");
  return settings;
}

TEST(Damping, EveryKindHasItsNameTextAndTerms) {
  for (const std::string& name : damping_names()) {
    const SolverSettings settings = read({"damping=" + name});
    EXPECT_EQ(name_of(settings.damping), name);
    EXPECT_THAT(damping_text(settings, false), testing::StartsWith(name));
    const Damping damping = damping_of(settings);
    EXPECT_TRUE(damping.gamma == 0.0 || damping.alpha == 0.0) << name << ": kernels take one of them";
    EXPECT_TRUE((damping.gamma > 0.0) == (damping.eq1 != Eq1::nothing)) << name;
  }
}

// Every key changes the text or the coefficients of its kinds of damping, and is refused with other kinds.
TEST(Damping, EveryKeyActsWithItsKindsAndIsRefusedWithOthers) {
  for (const DampingNumber& number : damping_numbers({})) {
    int kinds = 0;
    for (const std::string& name : damping_names()) {
      const std::vector<std::string> base = base_of(name, number.key);
      std::vector<std::string> changed = base;
      changed.push_back(number.key + "=" + other_value(number));
      bool reads = false;
      for (const DampingNumber& of_kind : damping_numbers(read({"damping=" + name})))
        reads = reads || (of_kind.key == number.key && of_kind.of_kind);
      if (!reads) {
        EXPECT_THAT(fault_of(changed), AllOf(HasSubstr("solver." + number.key), HasSubstr("only with damping = \"")))
            << name;
        continue;
      }
      ++kinds;
      const SolverSettings before = read(base), after = read(changed);
      EXPECT_TRUE(damping_of(before) != damping_of(after) || damping_of(before, true) != damping_of(after, true))
          << name << ": " << number.key;
      EXPECT_NE(damping_text(before, false) + damping_text(before, true),
                damping_text(after, false) + damping_text(after, true))
          << name << ": " << number.key;
    }
    EXPECT_GE(kinds, 1) << number.key;
  }
}

TEST(Damping, ThePageHasEveryKindAndKey) {
  std::ifstream file(QUOIN_SCENES "/README.md");
  std::stringstream page;
  page << file.rdbuf();
  std::string names;
  for (const std::string& name : damping_names()) names += (names.empty() ? "" : ", ") + name;
  EXPECT_THAT(page.str(), HasSubstr("| " + names + " |"));
  for (const DampingNumber& number : damping_numbers({})) EXPECT_THAT(page.str(), HasSubstr(number.key));
}

// The limit dt omega_max/2 with damping ratio z is the root of x^2 + 2 z x = 1 (Belytschko).
TEST(Damping, ShortensTheStepOfCentralDifferences) {
  for (const double z : {0.0, 0.2, 1.0}) {
    const double x = step_left(z);
    EXPECT_NEAR(x * x + 2.0 * z * x, 1.0, 1e-15) << z;
  }
}

}  // namespace
}  // namespace quoin
