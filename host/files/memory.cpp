#include "files/memory.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "base/error.h"

namespace quoin {

double memory_here() {
  double bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  for (const char* file : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    double limit = 0.0;
    if (std::ifstream(file) >> limit && limit > 0.0) bytes = std::min(bytes, limit);  // "max" is not a number
  }
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    bytes = std::min(bytes, static_cast<double>(limit.rlim_cur));
  return bytes;
}

void require_memory(double bytes, const std::string& what, const std::string& remedy) {
  constexpr double kShare = 0.8;  // the rest is for other processes, and for errors of the estimate
  const double here = memory_here();
  if (bytes <= kShare * here) return;
  throw Error(
      Exit::bad_input,
      fmt::format("{} need about {:.3g} GB of memory, more than {:.3g} GB, {:g} % of what this process may use; {}",
                  what, bytes / 1e9, kShare * here / 1e9, 100.0 * kShare, remedy));
}

}  // namespace quoin
