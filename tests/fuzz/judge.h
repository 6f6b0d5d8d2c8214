// Judges the end of a reader: an exit code of the command line with a message, or the input has found a fault.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <map>

#include "base/error.h"

// Returns the number of inputs so far by their exit codes.
inline std::map<quoin::Exit, long>& ends() {
  static std::map<quoin::Exit, long> counts;
  return counts;
}

// known: exit codes that are allowed besides 0. Every other exception is a fault, also lack of memory.
template <class Work>
void judge(std::initializer_list<quoin::Exit> known, const Work& work) {
  quoin::Exit end = quoin::Exit::done;
  try {
    work();
  } catch (const quoin::Error& error) {
    end = error.exit_code;
    if (std::find(known.begin(), known.end(), end) == known.end() || *error.what() == '\0') {
      std::fprintf(stderr, "exit code %d, '%s'\n", static_cast<int>(end), error.what());
      std::abort();
    }
  }
  ++ends()[end];
}
