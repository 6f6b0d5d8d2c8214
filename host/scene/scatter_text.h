// Random distributions in words, for messages and pages.
#pragma once

#include <string>

#include "scene/scene.h"

namespace quoin {

const char* level_name(ScatterLevel level);
std::string text_of(const random::Distribution& distribution);  // "lognormal, mean 200000, cov 0.3"
std::string text_of(const Scatter& scatter);                    // "..., by joint, correlated over 0.5 m"

}  // namespace quoin
