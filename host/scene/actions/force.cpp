// Forces at points of blocks.
#include "scene/actions/action.h"

namespace quoin {

using namespace reader;

namespace {

void read_forces(Table& t, Stage& stage, const std::string&, const std::vector<std::string>& names) {
  t.each("force", [&](Table& f) {
    PointForce& added = stage.forces.emplace_back();
    read_block_name(f, added.block, names);
    f.numbers("point", added.point, kPlace, "m, where it acts at the start; it moves with the block", true);
    f.numbers("force", added.force, kAny, "N", true);
  });
}

std::string text_of_force(const Stage& stage) {
  std::string text;
  for (const PointForce& f : stage.forces)
    text += fmt::format("{}{} N at {} of {}", text.empty() ? "" : ", ", fmt::join(f.force, " "),
                        fmt::join(f.point, " "), f.block);
  return text;
}

}  // namespace

extern const StageAction kPointForces{"force", "has forces at points", read_forces,
                                      [](const Stage& s) { return !s.forces.empty(); }, text_of_force};

}  // namespace quoin
