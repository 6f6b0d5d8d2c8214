// Objects that have a file each, as one list: a new one is a file, and its name in the list.
#pragma once

#include <functional>

// At namespace scope. Type: a struct that is constant from the start, so that lists need no order of files.
#define QUOIN_REGISTRY(Type, list, ...) \
  extern const Type __VA_ARGS__;        \
  constexpr std::reference_wrapper<const Type> list[] = {__VA_ARGS__}
