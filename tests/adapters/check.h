// Checks for host programs that run without GoogleTest (under Wine): failures are counted and printed.
#pragma once

#include <cstdio>

namespace quoin::tests {

inline int failures = 0;

inline void check(bool ok, const char* what, int line) {
  if (ok) return;
  ++failures;
  std::printf("line %d: failed: %s\n", line, what);
}

}  // namespace quoin::tests

#define CHECK(...) quoin::tests::check((__VA_ARGS__), #__VA_ARGS__, __LINE__)
