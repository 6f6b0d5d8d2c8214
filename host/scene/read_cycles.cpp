#include "scene/read_tables.h"

namespace quoin {

using namespace reader;

namespace {

constexpr int kMostCycles = 10000;  // most cycles of one amplitude

void read_counts(Table& t, Cycles& cycles) {
  const std::size_t amplitudes = cycles.amplitudes.size();
  int each = 1;
  std::vector<int> counts;
  if (t.toml()["cycles"].is_array())
    t.numbers("cycles", counts, between(1, kMostCycles), "one for each amplitude");
  else
    t.integer("cycles", each, 1, kMostCycles);
  cycles.counts = counts.size() == amplitudes ? counts : std::vector(amplitudes, each);
  // Faults of the amplitudes are reported already.
  if (!counts.empty() && amplitudes > 0 && counts.size() != amplitudes)
    t.refuse("cycles", fmt::format("an integer for all amplitudes, or one for each of the {}; the list has {}",
                                   amplitudes, counts.size()));
}

}  // namespace

void read_cycles(Table& t, Stage& stage, const char* velocity) {
  Cycles cycles;
  const bool reached = t.numbers("amplitudes", cycles.amplitudes, kPositive, "m", true);
  read_counts(t, cycles);
  bool moves = t.number(velocity, cycles.velocity, kAny, "m/s", true);
  if (moves && cycles.velocity == 0.0) {
    t.refuse(velocity, "not 0: the first amplitude would never be reached; < 0 begins towards the negative side");
    moves = false;
  }
  if (!t.has("ramp_time")) stage.ramp_time = 0.05;
  if (t.has("ramp_time") && stage.ramp_time == 0.0) {
    t.refuse("ramp_time", "more than 0 s, as half cycles start and end at rest");
    moves = false;
  }
  t.number("stop_at_force_loss", cycles.stop_at_force_loss, above_to(0, 1),
           "of the largest force of a half cycle before, towards the same side");
  for (const char* key : {"displacement", "duration", "equilibrium_ratio"})
    t.refuse_if_given(key,
                      "not with kind = \"cycles\", which end when the last one is done; remove it, or give "
                      "stop_at_force_loss");
  cycles.ramp_time = stage.ramp_time;
  stage.duration = 1.0;  // a placeholder: faulty cycles are never run
  if (reached && moves) {
    stage.duration = CyclicMotion(cycles).duration();
    if (!std::isfinite(*stage.duration)) t.refuse(velocity, "one that reaches the amplitudes in finite time");
  }
  stage.cycles = std::move(cycles);
}

void read_cycled_body(Table& t, const char* key, const std::vector<std::string>* bodies, Stage& stage) {
  std::string body;
  const bool known =
      bodies ? t.choice(key, body, *bodies, true) : t.text(key, body, "the name of the block that moves", true);
  t.choice("direction", stage.direction, {{"x", 0}, {"y", 1}, {"z", 2}});
  if (!known) return;
  auto control =
      std::find_if(stage.controls.begin(), stage.controls.end(), [&](const BodyControl& c) { return c.body == body; });
  if (control == stage.controls.end()) {
    control = stage.controls.emplace(control);
    control->body = body;
  }
  const auto c = static_cast<size_t>(stage.direction);
  if (control->kind[c] != DofKind::velocity || control->velocity[c] != 0.0)
    t.refuse(key, fmt::format("a body whose velocity along {} is 0 in its own table: the cycles give it", "xyz"[c]));
  control->velocity[c] = stage.cycles->velocity;
  control->in_cycles = stage.direction;
  stage.monitor = body;
}

}  // namespace quoin
