// The program as a process, in a separate folder for each test.
#pragma once

#include <fcntl.h>
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "../dry_stone.h"

namespace fs = std::filesystem;

inline std::string read_all(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class Cli : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              (std::string("quoin_cli_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
               std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Starts a process. standard_error: its descriptor; -1: a file, which finish reads. before: called in the child
  // before the program.
  pid_t start(const std::vector<std::string>& words, int standard_error = -1,
              const std::function<void()>& before = {}) {
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    for (const char* words_of_the_last : {"stdout", "stderr"}) fs::remove(folder_ / words_of_the_last);
    const pid_t child = fork();
    if (child == 0) {
      const int out = open((folder_ / "stdout").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      const int error =
          standard_error >= 0 ? standard_error : open((folder_ / "stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      dup2(out, STDOUT_FILENO);
      dup2(error, STDERR_FILENO);
      if (before) before();
      execv(arguments[0], arguments.data());
      _exit(126);
    }
    return child;
  }
  int finish(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    out_ = read_all(folder_ / "stdout");
    error_ = read_all(folder_ / "stderr");
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  int quoin(std::vector<std::string> words, const std::function<void()>& before = {}) {
    words.insert(words.begin(), QUOIN_PROGRAM);
    return finish(start(words, -1, before));
  }
  int run_small(std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", small_, "--out", out(), "--threads", "1"});
    return quoin(more);
  }
  std::string out() const { return (folder_ / "out").string(); }
  nlohmann::json summary() const { return nlohmann::json::parse(read_all(folder_ / "out" / "summary.json")); }

  fs::path folder_;
  const std::string small_ = QUOIN_CLI_TESTS "/small_wall.toml";
  std::string out_, error_;
};
