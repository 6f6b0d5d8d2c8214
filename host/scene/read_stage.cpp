// Keys that stages of every kind of scene have.
#include "scene/reader.h"

namespace quoin::reader {

void read_stage_basics(Table& t, Stage& stage, const Stage* previous) {
  t.text("name", stage.name, "text, as \"precompression\"");
  if (previous) stage.gravity = previous->gravity;
  t.numbers("gravity", stage.gravity, kAny, "m/s2");
  t.number("ramp_time", stage.ramp_time, kNotNegative, "s");
  t.number("duration", stage.duration, kPositive, "s");
  t.integer("max_steps", stage.max_steps, 1, 1000000000000L);
  t.integer("record_interval", stage.record_interval, 0, 1000000000L);
  if (int frames = 0; t.integer("frames", frames, 0, 100000)) stage.frames = frames;
  t.number("equilibrium_ratio", stage.equilibrium_ratio, above_to(0, 1), "(unbalanced/mean contact force)");
}

void read_rest(Table& t, Stage& stage) {
  if (t.has("ramp_time")) t.refuse("ramp_time", "none with kind = \"rest\": its loads act at once, and nothing swings");
  if (t.has("duration"))
    t.refuse("duration", "none with kind = \"rest\": it ends in equilibrium, by equilibrium_ratio");
  stage.ramp_time = 0.0;
  if (!t.has("equilibrium_ratio")) stage.equilibrium_ratio = 1e-4;
  if (!t.has("max_steps")) stage.max_steps = 1000000;
}

// Ends that are given with a fault have a message of their own.
void require_end(Table& t, const Stage& stage) {
  if (stage.equilibrium_ratio || stage.displacement || stage.duration || stage.collapse) return;
  for (const char* key : {"equilibrium_ratio", "displacement", "duration", "collapse"})
    if (t.has(key)) return;
  t.context().fault(t.where() +
                    ": the stage never ends; give duration (s), equilibrium_ratio, displacement (m) or collapse");
}

void read_monitor(Table& t, Stage& stage, const std::vector<std::string>* bodies) {
  t.number("displacement", stage.displacement, kPositive, "m");
  if (bodies)
    t.choice("monitor", stage.monitor, *bodies);
  else
    t.text("monitor", stage.monitor, "the name of a block");
  t.choice("direction", stage.direction, {{"x", 0}, {"y", 1}, {"z", 2}});
}

void read_law_swaps(Table& t, const Scene& scene, Stage& stage) {
  const std::string allowed = "a law for all joint families, or a table { family = \"law\" }";
  const toml::node* law = t.find("law", allowed, false);
  if (!law) return;
  if (law->is_table()) {
    t.within("law", allowed, [&](Table& swaps) {
      for (const std::string& family : names_of(scene.joints)) {
        if (std::string name; swaps.text(family, name, "the name or path of a law")) stage.law_swaps[family] = name;
      }
    });
  } else if (const auto name = law->value<std::string>()) {
    for (const auto& [family, settings] : scene.joints) stage.law_swaps[family] = *name;
  } else {
    t.wrong_type("law", allowed);
  }
}

}  // namespace quoin::reader
