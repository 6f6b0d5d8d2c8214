// A law in C++ with a fault: it throws a standard exception, or an object of another type.
#include <stdexcept>

extern "C" void throw_int() { throw 42; }
extern "C" void throw_words() { throw std::runtime_error("words of a law"); }
