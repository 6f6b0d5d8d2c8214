// Trial load of a law in a separate process. A law may crash, exit or never return while it is loaded.
#pragma once

#include <functional>
#include <string>

namespace quoin {

// Time limit for loading a law, s; 0: none.
inline double law_loading_seconds = 10.0;

// Error of `load` in the separate process: "crashed (SIGSEGV)", or empty where it returned. An Error thrown there gives
// an empty text, as our own process then throws it too. seconds: time limit (0: none). Empty where the system cannot
// start a process.
std::string fault_of_loading(const std::function<void()>& load, double seconds);

}  // namespace quoin
