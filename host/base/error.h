// Exception of the host, with its exit code.
#pragma once

#include <stdexcept>
#include <string>

namespace quoin {

// Exit codes of every quoin command.
enum class Exit : int {
  done = 0,
  usage = 2,        // the command line itself is wrong
  bad_input = 3,    // a scene, path file or other input is wrong
  law_refused = 4,  // a law could not be loaded or refused its properties
  numerical = 5,    // the computation failed (not a number, no equilibrium)
  interrupted = 130
};

// The message has the error, its place (file:line, key), the value, the allowed range and a remedy.
class Error : public std::runtime_error {
 public:
  Error(Exit code, const std::string& message) : std::runtime_error(message), exit_code(code) {}
  Exit exit_code;
};

}  // namespace quoin
