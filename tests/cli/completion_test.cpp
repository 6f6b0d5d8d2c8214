// `quoin completion`: a shell offers the words that --help lists, and the manual page and shells read it without
// warnings.
#include <gmock/gmock.h>

#include <regex>
#include <set>
#include <sstream>

#include "program.h"

namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;

class Completion : public Cli {
 protected:
  std::string written(const std::string& of) {
    EXPECT_EQ(quoin({"completion", of}), 0) << error_;
    const std::string file = (folder_ / of).string();
    std::ofstream(file) << out_;
    return file;
  }
  // Returns the completions of bash after these words, of which the last may be incomplete.
  std::set<std::string> offered(const std::vector<std::string>& words) {
    const std::string list = written("bash"), script = (folder_ / "ask").string();
    std::ofstream ask(script);
    ask << "source '" << list << "'\ncd '" << folder_.string() << "'\nPATH=" << fs::path(QUOIN_PROGRAM).parent_path()
        << ":$PATH\nCOMP_WORDS=(quoin";
    for (const std::string& word : words) ask << " '" << word << "'";
    ask << ")\nCOMP_CWORD=" << words.size() << "\n_quoin\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
    ask.close();
    EXPECT_EQ(finish(start({"/bin/bash", script})), 0) << error_;
    EXPECT_THAT(error_, IsEmpty());
    std::istringstream lines(out_);
    std::set<std::string> result;
    for (std::string line; std::getline(lines, line);) result.insert(line);
    result.erase("");
    return result;
  }
  // Returns the matches of pattern in a help text: long options at the beginnings of lines, or commands.
  std::set<std::string> in_help(const std::vector<std::string>& words, const std::string& pattern) {
    EXPECT_EQ(quoin(words), 0);
    std::set<std::string> result;
    const std::regex expression(pattern);
    for (std::sregex_iterator it(out_.begin(), out_.end(), expression), end; it != end; ++it) result.insert((*it)[1]);
    return result;
  }
  bool is_installed(const std::string& program) {
    return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
  }
};

TEST_F(Completion, OffersEveryCommandAndOptionOfTheHelp) {
  EXPECT_EQ(quoin({"--help"}), 0);
  const std::string commands_and_end = out_.substr(out_.find("Subcommands:"));
  std::set<std::string> commands;
  const std::regex of_line("\n  ([a-z]+) ");
  for (std::sregex_iterator it(commands_and_end.begin(), commands_and_end.end(), of_line), end; it != end; ++it)
    commands.insert((*it)[1]);
  ASSERT_GE(commands.size(), 14u);
  EXPECT_THAT(offered({""}), IsSupersetOf(commands));
  for (const std::string& command : commands) {
    const auto options = in_help({command, "--help"}, "\n  (?:-h,)?(--[a-z-]+)");
    ASSERT_THAT(options, Contains("--help"));
    std::set<std::string> here;
    for (const std::string& word : offered({command, "--"})) here.insert(word);
    EXPECT_EQ(here, options) << command;
  }
}

TEST_F(Completion, OffersValues) {
  EXPECT_EQ(offered({"reproduce", "--quality", "f"}), std::set<std::string>{"fast"});
  EXPECT_EQ(offered({"reproduce", "--quality", "=", "r"}), std::set<std::string>{"reference"});
  EXPECT_EQ(offered({"new", "f"}), std::set<std::string>{"facade"});
  EXPECT_THAT(offered({"run", "--law", "fract"}), Contains("fracture_energy"));
  std::ofstream(folder_ / "my wall.toml") << "";
  EXPECT_EQ(offered({"run", "my"}), std::set<std::string>{"my wall.toml"});
  EXPECT_THAT(offered({"run", "--out", "my"}), IsEmpty());  // a folder
}

TEST_F(Completion, OtherShellsReadTheirs) {
  for (const char* shell : {"zsh", "fish"}) {
    const std::string file = written(shell);
    EXPECT_THAT(read_all(file), HasSubstr("law-seconds"));
    if (!is_installed(shell)) continue;
    EXPECT_EQ(finish(start({"/usr/bin/env", shell, "-n", file})), 0) << error_;
    EXPECT_THAT(error_, IsEmpty());
  }
}

TEST_F(Completion, TheManualPageHasEveryCommandAndNoWarning) {
  const std::string page = written("man");
  const auto commands = in_help({"--help"}, "\n  ([a-z]+)  ");
  for (const std::string& command : commands) EXPECT_THAT(read_all(page), HasSubstr(".SS quoin " + command));
  if (!is_installed("man")) GTEST_SKIP() << "man is not here";
  EXPECT_EQ(finish(start({"/usr/bin/env", "man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", page})), 0) << error_;
  EXPECT_THAT(error_, IsEmpty());
  EXPECT_THAT(out_, HasSubstr("5 numerical failure"));
  EXPECT_EQ(quoin({"completion", "man", "--share", "/opt/quoin"}), 0);
  EXPECT_THAT(out_, ::testing::AllOf(HasSubstr("/opt/quoin/scenes/arch.toml"), Not(HasSubstr(" host/scenes"))));
}

}  // namespace
