// Every path test of tests/law/paths, through the loaded shared library, as `quoin path FILE.toml` runs them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "law/path_file.h"

namespace quoin {
namespace {

std::vector<std::string> path_files() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(QUOIN_PATHS_FOLDER)) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

class LawPath : public ::testing::TestWithParam<std::string> {};

TEST_P(LawPath, HoldsItsClosedForms) {
  const PathFile path = read_path_file(GetParam());
  const PathOutcome outcome = run_path(path);
  EXPECT_GT(outcome.checks, 0) << "a path test without checks shows nothing";
  for (std::size_t i = 0; i < outcome.failures.size() && i < 5; ++i) ADD_FAILURE() << outcome.failures[i];
  if (outcome.failures.size() > 5) ADD_FAILURE() << "and " << outcome.failures.size() - 5 << " more";
}

std::string name_of(const ::testing::TestParamInfo<std::string>& info) {
  std::string name = std::filesystem::path(info.param).stem().string();
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Files, LawPath, ::testing::ValuesIn(path_files()), name_of);

TEST(LawPaths, LibraryIsLargeAndMostlyCyclic) {
  std::size_t cyclic = 0, all = 0;
  for (const std::string& file : path_files()) {
    const PathFile path = read_path_file(file);
    ++all;
    cyclic += std::count(path.tags.begin(), path.tags.end(), "cyclic") > 0 ? 1 : 0;
    EXPECT_FALSE(path.tags.empty()) << file;
  }
  EXPECT_GE(all, 60u);
  EXPECT_GT(2 * cyclic, all);
}

}  // namespace
}  // namespace quoin
