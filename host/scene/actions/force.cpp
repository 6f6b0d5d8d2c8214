// Forces at points of blocks.
#include "scene/actions/action.h"

namespace quoin {

using namespace reader;

namespace {

PointForce read_point_force(Table f, const std::vector<std::string>& names) {
  PointForce c{};
  read_block_name(f, c.block, names);
  f.numbers("point", c.point, kPlace, "m, where it acts at the start; it moves with the block", true);
  f.numbers("force", c.force, kAny, "N", true);
  f.finish();
  return c;
}

void read_force(Table& t, Stage& stage, const std::string&, const std::vector<std::string>& names) {
  int index = 0;
  for (const toml::table* table : t.tables("force", "tables [[stage.force]]"))
    stage.forces.push_back(
        read_point_force({t.context(), *table, fmt::format("{}.{}", t.path("force"), ++index)}, names));
}

std::string text_of_force(const Stage& stage) {
  std::string text;
  for (const PointForce& f : stage.forces)
    text += fmt::format("{}{} N at {} of {}", text.empty() ? "" : ", ", fmt::join(f.force, " "),
                        fmt::join(f.point, " "), f.block);
  return text;
}

}  // namespace

extern const StageAction kPointForces{"force", "has forces at points", read_force,
                                      [](const Stage& s) { return !s.forces.empty(); }, text_of_force};

}  // namespace quoin
