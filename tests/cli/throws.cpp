// What a law in C++ may do by mistake: let something out, of a kind that a host can catch by name, or of another.
#include <stdexcept>

extern "C" void throw_int() { throw 42; }
extern "C" void throw_words() { throw std::runtime_error("words of a law"); }
