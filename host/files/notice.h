// Messages to the user on standard error. If the terminal is gone or the disk behind it is full, they are lost without
// an error.
#pragma once

#include <cstdio>
#include <string>

#include "base/printable.h"

namespace quoin {

// false in helper processes, whose parent prints the messages
inline bool notices_wanted = true;

// Prints one line; names and texts in it may come from outside.
inline void notice(const std::string& text) {
  if (!notices_wanted) return;
  std::fputs((printable(text) + "\n").c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace quoin
