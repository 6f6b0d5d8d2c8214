#include "ranks/join.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "base/error.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

// Number of processes started together, by the variables of mpirun and srun.
int started_together() {
  if (const char* count = std::getenv("OMPI_COMM_WORLD_SIZE")) return std::atoi(count);
  // With srun --mpi=pmix; otherwise each task is a separate process.
  if (std::getenv("PMIX_RANK") == nullptr) return 1;
  const char* tasks = std::getenv("SLURM_STEP_NUM_TASKS");
  return tasks ? std::atoi(tasks) : 1;
}

// Places of the MPI library: next to the program in a build, below lib in an installation.
std::vector<fs::path> places() {
  std::error_code fault;
  const fs::path program = fs::read_symlink("/proc/self/exe", fault).parent_path();
  return {program / QUOIN_MPI_LIBRARY, program.parent_path() / QUOIN_MPI_INSTALLED / QUOIN_MPI_LIBRARY};
}

}  // namespace

std::unique_ptr<Ranks> join_ranks() {
  const int count = started_together();
  if (count <= 1) return nullptr;
  std::string faults;
  for (const fs::path& place : places()) {
    if (std::error_code fault; !fs::exists(place, fault)) {
      faults += fmt::format("\n  {}: not there", place.string());
      continue;
    }
    // Global, as parts that Open MPI loads use its symbols.
    void* const library = dlopen(place.c_str(), RTLD_NOW | RTLD_GLOBAL);
    if (library == nullptr) {
      faults += fmt::format("\n  {}", dlerror());
      continue;
    }
    using Join = Ranks*();
    return std::unique_ptr<Ranks>(reinterpret_cast<Join*>(dlsym(library, "quoin_join_ranks"))());
  }
  throw Error(Exit::bad_input,
              fmt::format("started as one of {} ranks, but without MPI, so that each would run the whole model: build "
                          "with Open MPI (Debian: libopenmpi-dev openmpi-bin), or start quoin without mpirun{}",
                          count, faults));
}

}  // namespace quoin
