// toml++ as a header, so that a scene reader depends on no shared library of it.
#pragma once

#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>
