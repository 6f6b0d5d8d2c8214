#include "scene/read_monitors.h"

#include <algorithm>
#include <cctype>

namespace quoin {

using namespace reader;

std::vector<Monitor> read_monitors(Table& scene) {
  std::vector<Monitor> monitors;
  scene.each("monitor", [&](Table& t) {
    Monitor m;
    t.text("name", m.name, "letters, digits, _ and -", true);
    t.text("block", m.block, "a block, body or floor", true);
    Vec3 point{};
    if (t.numbers("point", point, kPlace, "m")) m.point = point;
    t.text("below", m.below, "the name of another monitor, from which drifts count");
    m.source = {t.where("block")};
    const auto called = [&](const std::string& name) {
      return std::any_of(monitors.begin(), monitors.end(), [&](const Monitor& other) { return other.name == name; });
    };
    if (t.has("name") && !is_plain_name(m.name)) t.refuse("name", "letters, digits, _ and -, for columns");
    if (called(m.name) || m.name == "ground") t.refuse("name", "a name that no other monitor has, and not \"ground\"");
    if (std::ranges::any_of(monitors, [&](const Monitor& other) { return differ_by("_relative", m.name, other.name); }))
      t.refuse("name", "not NAME_relative beside NAME: columns of both would have the same names");
    if (!m.below.empty() && !called(m.below)) t.refuse("below", "the name of a monitor that is given before this one");
    monitors.push_back(m);
  });
  return monitors;
}

}  // namespace quoin
