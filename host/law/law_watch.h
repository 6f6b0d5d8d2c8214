// Watch over laws, which are external code in this process. A law that crashes or calls exit() ends the program. The
// watch prints the name of the law first, and makes the exit code one of failure.
#pragma once

#include <string>

namespace quoin {

// Watches signals of crashes, exit() and std::terminate. main calls it before any law is loaded. Signals that already
// have a handler (of a sanitizer) keep it.
void watch_laws();
// Ends the watch, so that the program can exit. main calls it at the end.
void end_of_watch() noexcept;

// Marks the load of a library for the lifetime of the object: it is then to blame for an end of the program. Not
// nested.
class WatchedLoading {
 public:
  explicit WatchedLoading(const std::string& path);
  ~WatchedLoading();
  WatchedLoading(const WatchedLoading&) = delete;
  WatchedLoading& operator=(const WatchedLoading&) = delete;
};

// Registers the code of a loaded library by any address in it, until unregister_law. Messages name only the first 64
// libraries.
void note_law(const void* inside, const std::string& path);
void unregister_law(const void* inside);

}  // namespace quoin
