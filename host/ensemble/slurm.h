// Workers as a job array of Slurm. No text of a user is interpreted by the shell: the job's script is always the same,
// and the command is in its arguments.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace quoin::ensemble {

// Submits `tasks` workers, each of which runs `words` (program and arguments) on one core. A worker is requeued when
// its node fails. Output goes to FOLDER/slurm-JOB_TASK.log. Returns the number of the job. Throws Error(bad_input) with
// the message of sbatch.
std::string submit(const std::filesystem::path& folder, const std::vector<std::string>& words, int tasks);

// Whether tasks of the job are waiting or running. Throws Error(bad_input) when squeue is missing. True when squeue
// fails, as while slurmctld is down.
bool is_queued(const std::string& job);

}  // namespace quoin::ensemble
