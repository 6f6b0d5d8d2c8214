// A scene of which only the state under constant loads is requested.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace quoin {

// One stage of kind rest, with the weight, forces, pressures and supports of the stage of that name. Empty: the first
// that has a weight or a load. What moves there, shakes or grows is left out, and the end is kept for scenes that begin
// from it. Throws Error(bad_input): there is no such stage.
Scene at_rest(Scene scene, const std::string& stage);

// How `quoin rest` requests it. It is kept beside the keys of the scene that a command sets. So a run that goes on or
// is repeated has it, too. The name of the stage; none: it is not requested.
inline constexpr std::string_view kRestAsked = "rest=";
inline std::optional<std::string> rest_asked(const std::vector<std::string>& overrides) {
  for (const std::string& set : overrides)
    if (set.starts_with(kRestAsked)) return set.substr(kRestAsked.size());
  return std::nullopt;
}

}  // namespace quoin
