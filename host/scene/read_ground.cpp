#include "scene/read_ground.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "records/baseline.h"
#include "records/pulses.h"
#include "records/read_record.h"
#include "records/scaling.h"
#include "records/synthetic.h"

namespace quoin {

using namespace reader;

namespace {

constexpr const char* kAxes[] = {"x", "y", "z"};

Vec3 along(std::size_t axis) {
  Vec3 direction{};
  direction[axis] = 1.0;
  return direction;
}

// Reads a record of a file, in m/s2. Nothing, with a fault, when the file has none.
std::optional<GroundRecord> record_of(Table& t, const std::string& key, const std::string& file,
                                      const std::string& folder, GroundMotion& ground) {
  t.context().inputs.push_back(file.starts_with('/') ? file : folder + file);
  try {
    GroundRecord record = read_record(t.context().inputs.back());
    for (const std::string& assumption : record.assumptions) ground.notes.push_back("assumed: " + assumption);
    return record;
  } catch (const Error& error) {
    t.context().fault(fmt::format("{} = '{}':\n{}", t.where(key), file, error.what()));
    return std::nullopt;
  }
}

TimeSeries read_pairs(Table& t) {
  TimeSeries s;
  const bool moved = t.has("displacement");
  const bool timed = t.numbers("time", s.time, kNotNegative, "s, increasing", true);
  if (timed && std::adjacent_find(s.time.begin(), s.time.end(), std::greater_equal<>()) != s.time.end())
    t.refuse("time", "times that increase, s");
  if (moved) t.refuse_if_given("acceleration", "only without displacement; remove one of the two");
  const bool given = moved ? t.numbers("displacement", s.value, kAny, "times scale: m", true)
                           : t.numbers("acceleration", s.value, kAny, "times scale: m/s2", true);
  if (moved && given && s.value.size() < 2) return t.refuse("displacement", "two displacements or more"), TimeSeries{};
  for (const char* key : {"baseline", "start", "until", "after"}) {
    if (moved && t.has(key)) t.refuse(key, "only without displacement, which begins and ends at rest; remove it");
  }
  if (timed && given && s.time.size() != s.value.size()) {
    t.context().fault(fmt::format("{}: {} times and {} {}s; give as many of both", t.where(), s.time.size(),
                                  s.value.size(), moved ? "displacement" : "acceleration"));
    s = {};
  }
  if (!timed || !given || s.time.empty()) return {};
  return moved ? accelerations_of_spline(s) : s;
}

// Adds the component of a record that a key names, or its only one.
void add_component(Table& t, const std::string& key, const GroundRecord& record, const std::string& name,
                   const Vec3& direction, GroundMotion& ground) {
  std::vector<std::string> names;
  for (const RecordComponent& c : record.components) names.push_back(c.name);
  std::size_t index = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  if (name.empty() && names.size() == 1) index = 0;
  if (index == names.size())
    return t.refuse(key, fmt::format("one component of {}: {}; name it by `column`, or along x, y and z", record.source,
                                     join(names)));
  ground.components.push_back({direction, acceleration_of(record, index), {}});
}

// Reads file = "...", with direction and perhaps column, or with columns along x, y, z.
void read_file(Table& t, const std::string& folder, bool directed, const Vec3& direction, GroundMotion& ground) {
  std::string file, column;
  t.text("file", file, "a record: PEER, ESM, or CSV of time and components");
  const std::optional<GroundRecord> record = record_of(t, "file", file, folder, ground);
  if (t.text("column", column, "the name of a component of the file") && !directed)
    t.refuse("column", "only with direction; without it name the columns along x, y and z");
  std::array<std::string, 3> columns;
  bool any = false;
  for (std::size_t c = 0; c < 3; ++c) {
    const bool given = t.text(kAxes[c], columns[c], "the name of a component of the file");
    if (given && directed) t.refuse(kAxes[c], "only without direction");
    any = any || given;
  }
  if (!record) return;
  if (directed) return add_component(t, "file", *record, column, direction, ground);
  // Columns of these names are along these axes.
  for (std::size_t c = 0; c < 3 && !any; ++c) {
    const auto named = [&](const RecordComponent& of_record) { return of_record.name == kAxes[c]; };
    if (std::any_of(record->components.begin(), record->components.end(), named)) columns[c] = kAxes[c];
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (!columns[c].empty()) add_component(t, any ? kAxes[c] : "file", *record, columns[c], along(c), ground);
  }
  if (ground.components.empty())
    t.refuse("file", "with `direction`, or with the names of its columns along `x`, `y`, `z`");
}

// Reads x = "...", y = "...", z = "...": a file each.
void read_files(Table& t, const std::string& folder, GroundMotion& ground) {
  for (std::size_t c = 0; c < 3; ++c) {
    std::string file;
    if (!t.text(kAxes[c], file, "a record of one component: PEER, ESM or CSV")) continue;
    if (const auto record = record_of(t, kAxes[c], file, folder, ground))
      add_component(t, kAxes[c], *record, "", along(c), ground);
  }
}

// Reads pulse = { shape, ... }: a pulse in closed form.
TimeSeries read_pulse(Table t) {
  constexpr double kSamples = 200;  // samples of a period
  std::string shape = "sine";
  double amplitude = 1.0, period = 1.0, gamma = 2.0, phase = 0.0;
  t.choice("shape", shape, {"rectangle", "sine", "cosine", "ricker", "mavroeidis"}, true);
  const bool of_velocity = shape == "mavroeidis";
  t.number("period", period, kPositive, "s", true);
  t.number("amplitude", amplitude, kAny, of_velocity ? "m/s" : "m/s2");
  const bool shaped = t.number("gamma", gamma, above_to(1.0, 100.0), "(zero crossings)");
  const bool shifted = t.number("phase", phase, between(-360.0, 360.0), "deg");
  if ((shaped || shifted) && !of_velocity)
    t.refuse(shaped ? "gamma" : "phase", "only with shape = \"mavroeidis\"; remove it");
  t.finish();
  const double step = period / kSamples;
  if (shape == "rectangle") return rectangular_pulse(amplitude, period);
  if (shape == "sine") return sine_pulse(amplitude, period, step);
  if (shape == "cosine") return cosine_pulse(amplitude, period, step);
  if (shape == "ricker") return ricker_pulse(amplitude, period, step);
  return mavroeidis_pulse(amplitude, 1.0 / period, gamma, phase * std::numbers::pi / 180.0, step);
}

// Reads synthetic = { seed, number, ... }: a record that matches a spectrum of EN 1998-1.
TimeSeries read_synthetic(Table t, GroundMotion& ground) {
  SyntheticSettings settings;
  DesignSpectrum target;
  std::string ground_type = "B";
  t.integer("seed", settings.seed, 0, 1L << 53);
  t.integer("number", settings.number, 0, 1000000);
  t.number("ground_acceleration", target.ground_acceleration, kPositive, "m/s2");
  t.choice("ground_type", ground_type, {"A", "B", "C", "D", "E"});
  t.integer("spectrum_type", target.type, 1, 2);
  t.number("duration", settings.duration, between(5.0, 200.0), "s");
  t.number("time_step", settings.time_step, between(1e-3, 0.02), "s");
  t.finish();
  target.ground_type = ground_type[0];
  const SyntheticRecord made = synthetic_record(target, settings);
  ground.notes.push_back(fmt::format("{}; spectrum over that of the code {:.3f} on average, {:.3f} at least",
                                     made.record.source, made.mean_ratio, made.worst_ratio));
  return acceleration_of(made.record, 0);
}

void cut(Table& t, GroundMotion& ground) {
  double start = 0.0, until = HUGE_VAL;
  const bool starts = t.number("start", start, kNotNegative, "s of the record, where the stage begins");
  const bool ends = t.number("until", until, kPositive, "s of the record, where it ends");
  if (!starts && !ends) return;
  for (GroundMotion::Component& c : ground.components) {
    const auto& time = c.acceleration.time;
    if (start >= std::min(until, time.back()) || until <= time.front())
      return t.refuse(ends ? "until" : "start",
                      fmt::format("start < until, and a part of the record, which goes from {:g} to {:g} s",
                                  time.front(), time.back()));
    c.acceleration = c.acceleration.part(start, until);
  }
}

void correct(Table& t, GroundMotion& ground) {
  std::string kind = "none";
  BaselineCorrection correction;
  t.choice("baseline", kind, {"none", "linear", "polynomial", "high-pass"});
  const bool ordered = kind == "polynomial" || kind == "high-pass";
  if (kind == "high-pass") correction.order = 4;
  if (t.integer("baseline_order", correction.order, 0, 10) && !ordered)
    t.refuse("baseline_order", "only with baseline = \"polynomial\" or \"high-pass\"");
  if (t.number("baseline_corner", correction.corner_Hz, kPositive, "Hz", kind == "high-pass") && kind != "high-pass")
    t.refuse("baseline_corner", "only with baseline = \"high-pass\"");
  if (kind == "none") return;
  correction.kind = kind == "high-pass" ? BaselineCorrection::Kind::high_pass : BaselineCorrection::Kind::polynomial;
  for (GroundMotion::Component& c : ground.components) c.acceleration = correct_baseline(c.acceleration, correction);
  ground.notes.push_back("baseline corrected: " + kind);
}

void multiply(double factor, GroundMotion& ground) {
  for (GroundMotion::Component& c : ground.components) {
    for (double& v : c.acceleration.value) v *= factor;
  }
}

// Refuses the first of these keys that is given, where accelerations or their integral are not finite.
void refuse_overflow(Table& t, std::initializer_list<const char*> keys, const GroundMotion& ground) {
  const auto overflows = [](const GroundMotion::Component& c) {
    const auto is_infinite = [](double a) { return !std::isfinite(a); };
    return std::ranges::any_of(c.acceleration.value, is_infinite) ||
           is_infinite(c.acceleration.integral(c.acceleration.time.back()));
  };
  if (std::ranges::none_of(ground.components, overflows)) return;
  const auto given = std::ranges::find_if(keys, [&](const char* key) { return t.has(key); });
  if (given != keys.end()) t.refuse(*given, "numbers that keep accelerations and velocities of the ground finite");
}

// Scales to the pga, pgv or sa of the largest component, then by `scale`. all: a factor that follows on this one.
void scale(Table& t, bool states_unit, double all, GroundMotion& ground) {
  double factor = 1.0;
  t.number("scale", factor, kAny, "(on the record)");
  // Files with a unit are converted by it: a factor of g on top of that gives ten times the earthquake.
  if (states_unit && converts_from_g(factor * all))
    t.context().fault(fmt::format(
        "{} = {:g}{}: allowed: another factor: the file states its unit and is read in m/s2, so that this would "
        "convert it twice; remove scale (for such a factor on purpose give pga)",
        t.where("scale"), factor, all == 1.0 ? "" : fmt::format(", times {:g} of the whole ground_motion", all)));
  IntensityTarget target;
  const bool pga = t.number("pga", target.value, kPositive, "m/s2");
  const bool pgv = t.number("pgv", target.value, kPositive, "m/s");
  const bool sa = t.number("sa", target.value, kPositive, "m/s2");
  t.number("sa_period", target.period, kPositive, "s", sa);
  t.number("sa_damping", target.damping, between(0, 0.99), "(of critical)");
  if (pga + pgv + sa > 1) t.refuse(sa ? "sa" : "pgv", "one of pga, pgv and sa; remove the others");
  for (const char* key : {"sa_period", "sa_damping"}) {
    if (t.has(key) && !sa) t.refuse(key, "only with sa");
  }
  using Measure = IntensityTarget::Measure;
  target.measure = pga ? Measure::pga : pgv ? Measure::pgv : Measure::spectral_acceleration;
  if ((pga || pgv || sa) && !(sa && target.period <= 0.0)) {
    double to_target = HUGE_VAL;
    for (const GroundMotion::Component& c : ground.components) {
      const auto& values = c.acceleration.value;
      if (std::any_of(values.begin(), values.end(), [](double v) { return v != 0.0; }))
        to_target = std::min(to_target, scale_to(c.acceleration, target));
    }
    if (!std::isfinite(to_target))
      return t.refuse(pga ? "pga" : pgv ? "pgv" : "sa", "a record that is not 0 throughout");
    factor *= to_target;
    ground.notes.push_back(fmt::format("scaled by {:.6g}", factor));
  }
  multiply(factor, ground);
}

// Appends a triangle of acceleration over rest_time that cancels the velocity at the end of the record.
void come_to_rest(Table& t, GroundMotion& ground) {
  bool rests = false;
  double duration = 0.5;
  t.choice("after", rests, {{"goes_on", false}, {"rest", true}});
  if (t.number("rest_time", duration, kPositive, "s") && !rests) t.refuse("rest_time", "only with after = \"rest\"");
  if (!rests) return;
  double latest = 1.0;
  for (const GroundMotion::Component& c : ground.components) latest = std::max(latest, c.acceleration.time.back());
  constexpr double kShortest =
      1e-6;  // s at least, and of the end of the record: a shorter triangle is lost in rounding
  if (t.has("rest_time") && duration > 0.0 && duration < kShortest * latest)
    return t.refuse("rest_time",
                    fmt::format("at least {:g} s, for a record that ends at {:g} s", kShortest * latest, latest));
  for (GroundMotion::Component& c : ground.components) {
    TimeSeries& s = c.acceleration;
    const double end = s.time.back(), last = s.value.back(), velocity = s.integral(end);
    // Areas of the halves: (last + top) and top, times duration/4 each.
    const double top = -0.5 * last - 2.0 * velocity / duration;
    s.time.insert(s.time.end(), {end + 0.5 * duration, end + duration});
    s.value.insert(s.value.end(), {top, 0.0});
  }
  ground.notes.push_back(fmt::format("brought to rest over {:g} s after the record", duration));
}

void read_made(Table& t, const Vec3& direction, GroundMotion& ground) {
  const toml::table* pulse = t.table("pulse", "a table { shape, amplitude, period }");
  const toml::table* synthetic = t.table("synthetic", "a table { seed, number, ground_acceleration, ground_type }");
  for (const char* key : {"time", "acceleration", "displacement"})
    t.refuse_if_given(key, "only without pulse and synthetic; remove one of the two");
  if (pulse && synthetic) return t.refuse("synthetic", "only without pulse; remove one of the two");
  try {
    if (pulse) ground.components.push_back({direction, read_pulse({t.context(), *pulse, t.path("pulse")}), {}});
    if (synthetic)
      ground.components.push_back(
          {direction, read_synthetic({t.context(), *synthetic, t.path("synthetic")}, ground), {}});
  } catch (const Error& error) {
    t.context().fault(fmt::format("{}: {}", t.where(), error.what()));
  }
}

}  // namespace

void read_direction(Table& t, const std::string& key, Vec3& direction, const char* what, bool required) {
  constexpr double least = 1e-6;
  const bool given = t.numbers(key, direction, kPlace, what, required);
  if (given && std::hypot(direction[0], direction[1], direction[2]) < least)
    t.refuse(key, fmt::format("a vector of length {} or more, as [1, 0, 0]", least));
}

namespace {

// Reads the motion of the ground or of one group of supports. all: a factor that follows on its scale.
void read_motion(Table& t, const std::string& folder, double all, GroundMotion& ground) {
  Vec3 direction{};
  const bool by_axes = !t.has("direction") && (t.has("x") || t.has("y") || t.has("z"));
  read_direction(t, "direction", direction, "of the motion", !by_axes && !t.has("file"));
  if (t.has("file")) {
    for (const char* key : {"time", "acceleration", "displacement"})
      t.refuse_if_given(key, "only without file; remove one of the two");
    read_file(t, folder, t.has("direction"), direction, ground);
  } else if (t.has("pulse") || t.has("synthetic")) {
    read_made(t, direction, ground);
  } else if (by_axes) {
    read_files(t, folder, ground);
  } else if (TimeSeries given = read_pairs(t); !given.time.empty()) {
    ground.components.push_back({direction, std::move(given), {}});
  }
  // So far notes are assumptions about the files alone.
  const bool of_file = t.has("file") || by_axes, states_unit = of_file && ground.notes.empty();
  try {
    correct(t, ground);
    cut(t, ground);
    scale(t, states_unit, all, ground);
    come_to_rest(t, ground);
    refuse_overflow(
        t, {"scale", "pga", "pgv", "sa", "pulse", "synthetic", "displacement", "acceleration", "file", "x", "y", "z"},
        ground);
  } catch (const Error& error) {
    t.context().fault(fmt::format("{}: {}", t.where(), error.what()));
  }
}

// Reads a group of blocks with a motion of its own. whole: table of the whole ground motion, with its scale.
GroundMotion read_support(Table& t, const std::string& folder, Table& whole, double factor) {
  GroundMotion support{};
  t.texts("blocks", support.blocks, "a list of names of fixed blocks", true);
  read_motion(t, folder, factor, support);
  multiply(factor, support);
  if (factor != 1.0) refuse_overflow(whole, {"scale"}, support);
  return support;
}

}  // namespace

bool converts_from_g(double scale) {
  constexpr double kSame = 0.003;
  return std::abs(scale / kStandardGravity - 1.0) < kSame;
}

GroundMotion read_ground(Table t, const std::string& folder) {
  GroundMotion ground{};
  const toml::array* groups = t.toml()["support"].as_array();
  const bool moves = std::any_of(t.toml().begin(), t.toml().end(), [](const auto& entry) {
    return entry.first.str() != "support" && entry.first.str() != "scale";
  });
  double factor = 1.0;
  if (moves || !groups || groups->empty()) read_motion(t, folder, 1.0, ground);
  t.number("scale", factor, kAny, "(on the record)");
  t.each("support", [&](Table& group) { ground.supports.push_back(read_support(group, folder, t, factor)); });
  for (GroundMotion::Component& c : ground.components) c.velocity = RunningIntegral(c.acceleration);
  for (GroundMotion& support : ground.supports) {
    for (GroundMotion::Component& c : support.components) c.velocity = RunningIntegral(c.acceleration);
  }
  t.finish();
  return ground;
}

}  // namespace quoin
