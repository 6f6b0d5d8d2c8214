#include "cli/process_seconds.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <string>

namespace quoin {

double process_seconds() {
  static const auto at_main = std::chrono::steady_clock::now();
  static const double before = [] {
    // Field 22 of /proc/self/stat: start time in clock ticks since boot.
    std::ifstream stat("/proc/self/stat"), uptime("/proc/uptime");
    std::string text;
    std::getline(stat, text);
    const size_t bracket = text.rfind(')');
    double up = 0.0, start = 0.0;
    if (bracket == std::string::npos || !(uptime >> up)) return 0.0;
    std::istringstream fields(text.substr(bracket + 2));
    std::string skipped;
    for (int field = 3; field < 22; ++field) fields >> skipped;
    if (!(fields >> start)) return 0.0;
    return std::max(0.0, up - start / static_cast<double>(sysconf(_SC_CLK_TCK)));
  }();
  return before + std::chrono::duration<double>(std::chrono::steady_clock::now() - at_main).count();
}

}  // namespace quoin
