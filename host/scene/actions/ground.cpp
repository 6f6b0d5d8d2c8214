// Ground motion.
#include <bit>

#include "base/fnv_hash.h"
#include "scene/actions/action.h"
#include "scene/read_ground.h"

namespace quoin {

namespace {

void read_ground_motion(reader::Table& t, Stage& stage, const std::string& folder, const std::vector<std::string>&) {
  if (const auto* table =
          t.table("ground_motion",
                  "a table { direction, time, acceleration } or { direction, file }, or of files along x, y, z"))
    stage.ground = read_ground({t.context(), *table, t.path("ground_motion")}, folder);
}

std::string text_of_motion(const GroundMotion& ground) {
  std::string text;
  for (const GroundMotion::Component& c : ground.components) {
    FnvHash record;
    for (const auto* column : {&c.acceleration.time, &c.acceleration.value}) {
      for (const double number : *column) record.add(std::bit_cast<std::uint64_t>(number)), record.fold();
    }
    text += fmt::format("{}ground motion {}along {}, record {:x}", text.empty() ? "" : ", ",
                        ground.blocks.empty() ? "" : fmt::format("of {} ", fmt::join(ground.blocks, " ")),
                        fmt::join(c.direction, " "), record.value());
  }
  for (const GroundMotion& support : ground.supports) text += ", " + text_of_motion(support);
  return text;
}

}  // namespace

extern const StageAction kGroundMotion{"ground_motion", "moves the ground", read_ground_motion,
                                       [](const Stage& s) { return s.ground.has_value(); },
                                       [](const Stage& s) { return text_of_motion(*s.ground); }};

}  // namespace quoin
