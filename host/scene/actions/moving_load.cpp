// A force that moves along a line.
#include "scene/actions/action.h"
#include "scene/load_place.h"

namespace quoin {

using namespace reader;

namespace {

MovingLoad read_load(Table& m) {
  MovingLoad load;
  m.numbers("from", load.from, kPlace, "m, where it begins", true);
  m.numbers("to", load.to, kPlace, "m, where it ends", true);
  if (m.numbers("force", load.force, kAny, "N", true) && load.force == Vec3{})
    m.refuse("force", "a force that is not 0");
  if (m.integer("positions", load.positions, 1, 2000) && load.positions < 2 && load.from != load.to)
    m.refuse("positions", "2 or more along a line, to the end of which the load goes");
  if (load.from == load.to) load.positions = 1;
  return load;
}

void read_moving_load(Table& t, Stage& stage, const std::string&, const std::vector<std::string>&) {
  if (!t.within("moving_load", "a table { from, to, force, positions }",
                [&](Table& m) { stage.moving_load = read_load(m); }))
    return;
  if (!stage.duration && !t.has("duration"))
    t.refuse("moving_load", "with duration (s) of the stage, in which the load goes along its line after ramp_time");
  else if (stage.duration && *stage.duration <= stage.ramp_time)
    t.refuse("duration", fmt::format("more than ramp_time ({:g} s), after which moving_load moves", stage.ramp_time));
}

std::string text_of_moving_load(const Stage& stage) {
  const MovingLoad& load = *stage.moving_load;
  return fmt::format("{} N moving from {} to {} by {} positions", fmt::join(load.force, " "), fmt::join(load.from, " "),
                     fmt::join(load.to, " "), load.positions);
}

void check_moving_load(const Stage& stage, const blocks::Assembly& assembly) {
  if (stage.moving_load) blocks::places_of(*stage.moving_load, assembly, stage.source.text);
}

}  // namespace

extern const StageAction kMovingLoad{"moving_load",       "has a moving load",
                                     read_moving_load,    [](const Stage& s) { return s.moving_load.has_value(); },
                                     text_of_moving_load, check_moving_load};

}  // namespace quoin
