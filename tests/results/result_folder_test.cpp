// Ownership of a result folder, and the files that may be removed.
#include "files/result_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "base/error.h"
#include "files/file.h"
#include "folder.h"

namespace quoin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Folder : public InFolder {
 protected:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  // Returns the message of the refusal, or an empty text.
  std::string refusal() const {
    try {
      const ResultFolder results(folder_);
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      return error.what();
    }
    return {};
  }
};

TEST_F(Folder, HasOneHolder) {
  {
    const FolderLock first(folder_);
    EXPECT_THAT(refusal(),
                AllOf(HasSubstr(folder_.string()), HasSubstr("in use by another run"),
                      HasSubstr("process " + std::to_string(getpid())), HasSubstr("since"), HasSubstr("--out")));
  }
  EXPECT_EQ(refusal(), "");
}

TEST_F(Folder, LockDiesWithItsProcessThoughItsChildrenLive) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t holder = fork();
  if (holder == 0) {
    const FolderLock lock(folder_);
    const pid_t child = fork();
    if (child == 0) {
      usleep(300000);  // as on a slow machine: the child has the lock until its exec
      execlp("sleep", "sleep", "1000", nullptr);
      _exit(127);
    }
    if (::write(ready[1], &child, sizeof child) < 0) _exit(1);
    for (;;) pause();
  }
  pid_t child = 0;
  ASSERT_EQ(read(ready[0], &child, sizeof child), ssize_t{sizeof child});
  EXPECT_THAT(refusal(), HasSubstr("process " + std::to_string(holder)));
  kill(holder, SIGKILL);
  waitpid(holder, nullptr, 0);
  EXPECT_EQ(refusal(), "") << "who goes on at once waits for the child's exec";
  EXPECT_EQ(kill(child, SIGKILL), 0) << "the child was to outlive the holder";
  close(ready[0]);
  close(ready[1]);
}

TEST_F(Folder, LosesWhatTheLastRunWroteAndNothingElse) {
  const std::vector<std::string> ours{"summary.json", "blocks_0000.vtu", "members_0000.vtu", "plots/curve.gp",
                                      "plots/bricks.dat"};
  const std::vector<std::string> theirs{"notes.txt", "blocks.txt", "my_blocks_1.vtu", "plots/mine.gp",
                                        "more/curve.png"};
  fs::path part;
  {
    const ResultFolder results(folder_);
    fs::create_directories(folder_ / "plots");
    for (const std::string& name : ours) write_file(folder_ / name, "ours");
    part = begin_file(folder_ / "history.csv");  // as after a run that was killed
    std::ofstream(part) << "half a row";
  }
  for (const std::string& name : theirs) write(name, "theirs");
  EXPECT_TRUE(fs::exists(part));
  EXPECT_EQ(refusal(), "");
  for (const std::string& name : ours) EXPECT_FALSE(fs::exists(folder_ / name)) << name;
  EXPECT_FALSE(fs::exists(part));
  for (const std::string& name : theirs) EXPECT_EQ(read_all(folder_ / name), "theirs") << name;
  // The run that cleared the folder wrote nothing, so a file with such a name is not of a run and must be kept.
  write("summary.json", "theirs");
  EXPECT_THAT(refusal(), HasSubstr("summary.json"));
  EXPECT_EQ(read_all(folder_ / "summary.json"), "theirs");
}

TEST_F(Folder, LosesWhatAKilledRankOfTheLastRunWrote) {
  const auto write_as_rank_1 = [&](const std::string& name) {
    const ResultFolder results(folder_);
    const pid_t rank = fork();
    if (rank == 0) {
      note_results_of_rank(folder_, 1);
      write_file(folder_ / name, "ours");
      kill(getpid(), SIGKILL);
    }
    waitpid(rank, nullptr, 0);
  };
  write_as_rank_1("blocks_0000_r1.vtu");
  EXPECT_TRUE(fs::exists(folder_ / "blocks_0000_r1.vtu"));
  write_as_rank_1("blocks_0001_r1.vtu");
  EXPECT_FALSE(fs::exists(folder_ / "blocks_0000_r1.vtu"));
  // The list of a rank counts with the manifest of its own run alone, and goes with the next run.
  write("blocks_0000_r1.vtu", "theirs");
  EXPECT_THAT(refusal(), HasSubstr("has blocks_0000_r1.vtu,"));
  EXPECT_EQ(read_all(folder_ / "blocks_0001_r1.vtu"), "ours");
  fs::remove(folder_ / "blocks_0000_r1.vtu");
  EXPECT_EQ(refusal(), "");
  EXPECT_FALSE(fs::exists(folder_ / "blocks_0001_r1.vtu"));
  EXPECT_FALSE(fs::exists(folder_ / ".quoin-manifest_r1"));
  write(".quoin-manifest_r1", "results of quoin, partial files .0123abcd\nblocks_0000_r1.vtu\n");
  write("blocks_0000_r1.vtu", "theirs");
  EXPECT_THAT(refusal(), HasSubstr("has blocks_0000_r1.vtu,"));
}

TEST_F(Folder, RefusesWhatOthersWroteAndRemovesNothingThen) {
  {
    const ResultFolder results(folder_);
    write_file(folder_ / "curve.png", "ours");
  }
  write("plots/thesis.tex", "theirs");
  write("joints_final.vtu", "theirs");
  EXPECT_THAT(refusal(), AllOf(HasSubstr("has joints_final.vtu and 1 more"), HasSubstr("move it away"),
                               HasSubstr("choose another folder with --out")));
  fs::remove(folder_ / "joints_final.vtu");
  EXPECT_THAT(refusal(), HasSubstr("has plots,"));
  EXPECT_EQ(read_all(folder_ / "plots/thesis.tex"), "theirs");
  EXPECT_EQ(read_all(folder_ / "curve.png"), "ours");
  fs::remove_all(folder_ / "plots");
  EXPECT_EQ(refusal(), "");
}

TEST_F(Folder, BelievesNoManifestBeyondTheNamesOfResults) {
  const fs::path outside = folder_ / "outside";
  write("outside/curve.png", "theirs");
  write("outside/plots/curve.gp", "theirs");
  fs::create_directories(folder_ / "run");
  fs::create_directory_symlink(outside / "plots", folder_ / "run/plots");
  write("run/thesis.tex", "theirs");
  write("run/.quoin-manifest", "results of quoin, partial files .0123abcd\n../outside/curve.png\n" +
                                   (outside / "curve.png").string() +
                                   "\nthesis.tex\nplots/../../outside/curve.png\nplots/curve.gp\n");
  folder_ /= "run";
  EXPECT_THAT(refusal(), HasSubstr("has plots,")) << "a link leads elsewhere";
  fs::remove(folder_ / "plots");
  EXPECT_EQ(refusal(), "");
  EXPECT_EQ(read_all(folder_ / "thesis.tex"), "theirs");
  folder_ = folder_.parent_path();
  EXPECT_EQ(read_all(outside / "curve.png"), "theirs");
  EXPECT_EQ(read_all(outside / "plots/curve.gp"), "theirs");
}

// Files of fixed names in a folder that is none of a run: those of a user are kept, own ones are replaced. A name that
// was listed is the user's again when the file has been removed meanwhile.
TEST_F(Folder, FilesOfOthersWithTheNameOfAResultAreRefused) {
  const std::vector<std::string> names{"modes.json", "modes.vtu"};
  const auto fault = [&] {
    try {
      refuse_files_of_others(folder_, names);
      list_own_files(folder_, names);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  write("modes.vtu", "theirs");
  EXPECT_THAT(fault(), AllOf(HasSubstr("has modes.vtu, which would be replaced"), HasSubstr("move modes.vtu away"),
                             HasSubstr("--out")));
  fs::remove(folder_ / "modes.vtu");
  EXPECT_EQ(fault(), "");
  for (const std::string& name : names) write_file(folder_ / name, "ours");
  EXPECT_EQ(fault(), "");
  fs::remove(folder_ / "modes.json");
  list_own_files(folder_, {"spectrum.csv"});
  write("modes.json", "theirs");
  EXPECT_THAT(fault(), HasSubstr("has modes.json, which would be replaced"));
  fs::remove_all(folder_);
  EXPECT_EQ(fault(), "") << "of a folder that is not there yet";
}

// In a program without standard input the first open file has its descriptor, 0.
TEST_F(Folder, DurableFilesNeedNoStandardInput) {
  const int input = dup(STDIN_FILENO);
  close(STDIN_FILENO);
  const auto write = [&] {
    DurableFile file(folder_ / "checkpoint");
    file.append(std::vector<std::uint8_t>{'a', 'b', 'c'});
    file.finish();
  };
  EXPECT_NO_THROW(write());
  if (input >= 0) dup2(input, STDIN_FILENO), close(input);
  EXPECT_EQ(read_all(folder_ / "checkpoint"), "abc");
}

}  // namespace
}  // namespace quoin
