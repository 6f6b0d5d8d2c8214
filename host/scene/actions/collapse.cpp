// A body force that grows until blocks move away.
#include "base/error.h"
#include "scene/actions/action.h"
#include "scene/collapse_load.h"
#include "scene/read_ground.h"

namespace quoin {

using namespace reader;

namespace {

Collapse read_load_of_collapse(Table& c) {
  Collapse collapse;
  read_direction(c, "direction", collapse.direction, "of the body force", false);
  const auto is_word = [&](const char* key) {
    const toml::node* node = c.toml().get(key);
    return node && node->is_string();
  };
  std::string word;
  if (!is_word("start"))
    c.number("start", *collapse.start, kNotNegative, "times the weight, or \"limit\"");
  else if (c.choice("start", word, {"limit"}))
    collapse.start.reset();
  if (!is_word("rate"))
    c.number("rate", *collapse.rate, kPositive, "times the weight, 1/s, or \"auto\"");
  else if (c.choice("rate", word, {"auto"}))
    collapse.rate.reset();
  if (!collapse.start && !c.has("rate")) collapse.rate.reset();
  if (waits(collapse) && collapse.start == 0.0)
    c.refuse("rate",
             "\"auto\" with a start of more than 0 (times the weight), of which it is a share; give start, or "
             "start = \"limit\"");
  c.number("displacement", collapse.displacement, kPositive, "m");
  c.number("limit", *collapse.limit, kPositive, "times the weight");
  if (collapse.start && *collapse.limit <= *collapse.start) {
    c.refuse(c.has("limit") ? "limit" : "start",
             fmt::format("a limit ({}) of more than start ({})", *collapse.limit, *collapse.start));
  }
  if (!collapse.start && !c.has("limit")) collapse.limit.reset();
  return collapse;
}

void read_collapse(Table& t, Stage& stage, const std::string&, const std::vector<std::string>&) {
  t.within("collapse", "a table { direction, start, rate, displacement, limit }",
           [&](Table& c) { stage.collapse = read_load_of_collapse(c); });
}

std::string text_of_collapse(const Stage& stage) {
  const Collapse& c = *stage.collapse;
  const auto number_or = [](const std::optional<double>& number, const char* otherwise) {
    return number ? fmt::format("{}", *number) : otherwise;
  };
  return fmt::format("collapse along {}, {} to {} at {} 1/s, {} m", fmt::join(c.direction, " "),
                     number_or(c.start, "limit"), number_or(c.limit, "limit"), number_or(c.rate, "auto"),
                     c.displacement);
}

void check_collapse(const Stage& stage, const blocks::Assembly&) {
  if (!stage.collapse || stage.gravity != Vec3{}) return;
  throw Error(Exit::bad_input,
              fmt::format("{}: collapse without gravity: its force is a share of the weight; give stage.gravity",
                          stage.source.text));
}

}  // namespace

extern const StageAction kCollapseLoad{"collapse",       "pushes until collapse",
                                       read_collapse,    [](const Stage& s) { return s.collapse.has_value(); },
                                       text_of_collapse, check_collapse};

}  // namespace quoin
