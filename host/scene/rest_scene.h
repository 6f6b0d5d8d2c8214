// The scene of `quoin rest`: the state under constant loads alone.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace quoin {

// One stage of kind rest, with the weight, forces, pressures and supports of the stage of that name. Empty name: the
// first stage with a weight or a load. Velocities, ground motion and growing loads are left out. The end state is
// written, for scenes that begin from it. Throws Error(bad_input) for a name without a stage.
Scene at_rest(Scene scene, const std::string& stage);

// Prefix of the override by which `quoin rest` requests it. It is stored with the overrides of --set, so that a
// continued or repeated run has it too. rest_asked(): name of the stage; none: it is not requested.
inline constexpr std::string_view kRestAsked = "rest=";
inline std::optional<std::string> rest_asked(const std::vector<std::string>& overrides) {
  for (const std::string& set : overrides)
    if (set.starts_with(kRestAsked)) return set.substr(kRestAsked.size());
  return std::nullopt;
}

}  // namespace quoin
