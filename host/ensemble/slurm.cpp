#include "ensemble/slurm.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>

#include "base/error.h"
#include "files/file.h"

extern char** environ;

namespace quoin::ensemble {

namespace {

namespace fs = std::filesystem;

struct Answer {
  int code = 0;
  std::string text;  // standard output and error
};

Answer ask(const std::vector<std::string>& words) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    throw Error(Exit::bad_input, fmt::format("{}: cannot be asked: {}", words[0], std::strerror(errno)));
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  pid_t child = 0;
  const int fault = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  Answer answer;
  std::array<char, 4096> part{};
  for (ssize_t count = 1; fault == 0 && count > 0;) {
    count = read(ends[0], part.data(), part.size());
    if (count > 0) answer.text.append(part.data(), static_cast<std::size_t>(count));
    if (count < 0 && errno == EINTR) count = 1;
  }
  close(ends[0]);
  if (fault != 0)
    throw Error(Exit::bad_input, fmt::format("{}: {}; --slurm needs the programs of Slurm: install slurm-client, or "
                                             "compute here with --jobs",
                                             words[0], std::strerror(fault)));
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  answer.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  while (!answer.text.empty() && answer.text.back() == '\n') answer.text.pop_back();
  return answer;
}

}  // namespace

std::string submit(const fs::path& folder, const std::vector<std::string>& words, int tasks) {
  const fs::path place = fs::absolute(folder), script = place / "slurm.sh";
  write_file(script, "#!/bin/sh\nexec \"$@\"\n");
  std::vector<std::string> all{"sbatch",
                               "--parsable",
                               "--job-name=quoin-ensemble",
                               fmt::format("--array=1-{}", tasks),
                               "--ntasks=1",
                               "--cpus-per-task=1",
                               "--requeue",
                               "--open-mode=append",
                               "--output=" + (place / "slurm-%A_%a.log").string(),
                               script.string()};
  all.insert(all.end(), words.begin(), words.end());
  const Answer answer = ask(all);
  const std::string job = answer.text.substr(answer.text.rfind('\n') + 1);
  if (answer.code != 0 || job.empty() || std::isdigit(static_cast<unsigned char>(job[0])) == 0)
    throw Error(Exit::bad_input, fmt::format("sbatch refused the job: {}", answer.text));
  return job.substr(0, job.find(';'));  // the name of the cluster follows
}

bool is_queued(const std::string& job) {
  const Answer answer = ask({"squeue", "--noheader", "--jobs=" + job, "--format=%i"});
  // Slurm soon deletes jobs that have ended.
  if (answer.code != 0) return answer.text.find("Invalid job id") == std::string::npos;
  return !answer.text.empty();
}

}  // namespace quoin::ensemble
