// A law may crash, end the program past every handler, or never return when it is loaded. So a process of its own loads
// it first.
#pragma once

#include <functional>
#include <string>

namespace quoin {

// What a law may take to be loaded, s, before it is refused; 0: any time.
inline double law_loading_seconds = 10.0;

// How `load` ended there: "crashed (SIGSEGV)", or empty where it came back. An Error there is empty, too: our own
// process then meets it itself. seconds: that it may take (0: any time). Empty as well where the system starts no
// process.
std::string fault_of_loading(const std::function<void()>& load, double seconds);

}  // namespace quoin
