// Lists of objects that each have a file of their own: a new object is a new file and its name in the list.
#pragma once

#include <functional>

// Use at namespace scope. Type: a struct with constant initialisation, so that the order of files does not matter.
#define QUOIN_REGISTRY(Type, list, ...) \
  extern const Type __VA_ARGS__;        \
  constexpr std::reference_wrapper<const Type> list[] = {__VA_ARGS__}
