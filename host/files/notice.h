// Words to the person at the terminal, on standard error. A terminal that is gone, or a full disk behind it, costs the
// words and nothing else.
#pragma once

#include <cstdio>
#include <string>

namespace quoin {

// Off in processes that help another one, which speaks for all.
inline bool notices_wanted = true;

// One line.
inline void notice(const std::string& text) {
  if (!notices_wanted) return;
  std::fputs((text + "\n").c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace quoin
