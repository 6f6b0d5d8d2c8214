// Words to the person at the terminal, on standard error. A terminal that is gone, or a full disk behind it, costs the
// words and nothing else.
#pragma once

#include <cstdio>
#include <string>

#include "base/printable.h"

namespace quoin {

// Off in processes that help another one, which speaks for all.
inline bool notices_wanted = true;

// One line; names and texts in it may come from anywhere.
inline void notice(const std::string& text) {
  if (!notices_wanted) return;
  std::fputs((printable(text) + "\n").c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace quoin
