// What a law in C++ may do by mistake: let something out that no host can catch by name.
extern "C" void throw_int() { throw 42; }
