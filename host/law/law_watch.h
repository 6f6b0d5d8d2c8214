// Laws are code from outside, in this process. One that crashes, calls exit() or throws ends the program. This names
// the law before, and gives such an end an exit code of failure.
#pragma once

#include <string>

namespace quoin {

// From main, before any law is loaded: signals of crashes, exit() and std::terminate are watched from now on. What
// already has a handler (a sanitizer's) keeps it.
void watch_laws();
// From main, at the end: the program may exit now.
void end_of_watch() noexcept;

// A library is being loaded while this lives: what ends the program then is its fault. Not nested.
class WatchedLoading {
 public:
  explicit WatchedLoading(const std::string& path);
  ~WatchedLoading();
  WatchedLoading(const WatchedLoading&) = delete;
  WatchedLoading& operator=(const WatchedLoading&) = delete;
};

// Where the code of a loaded library is, by any address within it; until forget_law. Cheap; any number of libraries, of
// which the first 64 are named.
void note_law(const void* inside, const std::string& path);
void forget_law(const void* inside);

}  // namespace quoin
