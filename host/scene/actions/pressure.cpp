// Pressures on faces of blocks.
#include "scene/actions/action.h"
#include "scene/read_ground.h"

namespace quoin {

using namespace reader;

namespace {

FacePressure read_face_pressure(Table p, const std::vector<std::string>& names) {
  FacePressure c{};
  read_block_name(p, c.block, names);
  read_direction(p, "normal", c.normal, "outward, of the face that is meant", true);
  p.number("pressure", c.pressure, kAny, "Pa, > 0 pushes on the block", true);
  p.finish();
  return c;
}

void read_pressure(Table& t, Stage& stage, const std::string&, const std::vector<std::string>& names) {
  int index = 0;
  for (const toml::table* table : t.tables("pressure", "tables [[stage.pressure]]"))
    stage.pressures.push_back(
        read_face_pressure({t.context(), *table, fmt::format("{}.{}", t.path("pressure"), ++index)}, names));
}

std::string text_of_pressure(const Stage& stage) {
  std::string text;
  for (const FacePressure& p : stage.pressures)
    text += fmt::format("{}{} Pa on {} of {}", text.empty() ? "" : ", ", p.pressure, fmt::join(p.normal, " "), p.block);
  return text;
}

}  // namespace

extern const StageAction kFacePressures{"pressure", "has pressures on faces", read_pressure,
                                        [](const Stage& s) { return !s.pressures.empty(); }, text_of_pressure};

}  // namespace quoin
