// Workers as a job array of Slurm. No text of a user reaches the shell: the script of the job is the same for all, and
// what it starts are its arguments.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace quoin::ensemble {

// Submits `tasks` workers, each of which runs `words` (program and arguments) on one core; requeued when a node fails.
// Their words go to FOLDER/slurm-JOB_TASK.log. Returns the number of the job. Throws Error(bad_input) with the words of
// sbatch.
std::string submit(const std::filesystem::path& folder, const std::vector<std::string>& words, int tasks);

// Whether tasks of the job are waiting or running. Throws Error(bad_input) where squeue is missing; true where it gives
// no answer, as while slurmctld is down.
bool is_queued(const std::string& job);

}  // namespace quoin::ensemble
