// How a reader ends: with an exit code of the command line and words, or the input is a fault.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <map>

#include "base/error.h"

// Inputs so far by the exit code that they end with.
inline std::map<quoin::Exit, long>& ends() {
  static std::map<quoin::Exit, long> counts;
  return counts;
}

// known: codes that such an input may end with beside 0. Every other exception is a fault, missing memory included.
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
