// TOML tables with the line of each fault: shared by all scene readers.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "scene/inline_toml.h"
#include "scene/quality.h"
#include "scene/read_scene.h"
#include "scene/scene.h"
#include "scene/toml.h"

namespace quoin::reader {

inline std::string join(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

// Keys of a map.
template <class Listed>
std::vector<std::string> names_of(const Listed& listed) {
  std::vector<std::string> names;
  for (const auto& [name, value] : listed) names.push_back(name);
  return names;
}

// Values by their names in scenes.
template <class Value>
using Named = std::vector<std::pair<std::string, Value>>;

// Allowed values of a number, with their text in messages.
struct Range {
  double lower = -HUGE_VAL, upper = HUGE_VAL;
  bool lower_open = false;
  bool holds(double v) const { return std::isfinite(v) && (lower_open ? v > lower : v >= lower) && v <= upper; }
  std::string text() const {
    if (std::isfinite(lower) && std::isfinite(upper))
      return lower_open ? fmt::format("more than {} and at most {}", lower, upper)
                        : fmt::format("{} to {}", lower, upper);
    if (std::isfinite(lower)) return lower_open ? fmt::format("more than {}", lower) : fmt::format("{} or more", lower);
    if (std::isfinite(upper)) return fmt::format("at most {}", upper);
    return "any finite number";
  }
};
inline constexpr Range kAny{}, kPositive{0.0, HUGE_VAL, true}, kNotNegative{0.0, HUGE_VAL};
inline Range between(double lower, double upper) { return {lower, upper, false}; }
inline Range above_to(double lower, double upper) { return {lower, upper, true}; }
// Of a coordinate, m. Beyond it, positions in double precision are coarser than the opening of a joint.
inline constexpr Range kPlace{-1e6, 1e6};
// Of an extent of units and walls, m: larger ones are taken for another unit of length.
inline constexpr Range kExtent{0.0, 100.0, true};
inline constexpr Range kDensity{0.0, 1e9, true};  // kg/m3; masses stay finite

inline std::string text_of(const toml::node& node) { return node.is_table() ? "a table" : inline_toml(node); }

inline const char* type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true/false";
    default:
      return "a date or time";
  }
}

// Shared by all tables of a scene: sources of values, and the faults so far.
class Context {
 public:
  std::string file;
  std::set<std::string> overridden;     // dotted paths given by --set
  std::vector<std::string> inputs;      // other files that the scene reads
  const toml::table* solver = nullptr;  // table [solver]; null: there is none
  bool damping_is_chosen = false;       // damping of the user's in the solver table of a stage so far

  std::string where(const toml::node* node, const std::string& path) const {
    for (const std::string& set : overridden) {
      if (path == set || path.starts_with(set + ".") || path.starts_with(set + "["))
        return fmt::format("--set: {}", path);
    }
    if (!node || node->source().begin.line == 0) return fmt::format("{}: {}", file, path);
    return fmt::format("{}:{}: {}", file, node->source().begin.line, path);
  }
  void fault(std::string message) { faults_.push_back(std::move(message)); }
  bool has_faults() const { return !faults_.empty(); }
  void throw_faults() const {
    if (has_faults()) throw Error(Exit::bad_input, faults());
  }
  // Faults in the order of the file's lines. Those without a line, as of --set, come first.
  std::string faults() const {
    std::vector<std::string> sorted = faults_;
    std::ranges::stable_sort(sorted, {}, [this](const std::string& fault) { return line_of(fault); });
    return fmt::format("{}", fmt::join(sorted, "\n"));
  }

 private:
  long line_of(const std::string& fault) const {
    return fault.starts_with(file + ":") ? std::strtol(fault.c_str() + file.size() + 1, nullptr, 10) : 0;
  }

  std::vector<std::string> faults_;
};

// A table with a method for each type of key. finish() reports keys that were not read.
class Table {
 public:
  Table(Context& context, const toml::table& table, std::string path)
      : context_(context), table_(table), path_(std::move(path)) {}

  std::string path(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  std::string where(const std::string& key) const { return context_.where(table_.get(key), path(key)); }
  std::string where() const { return context_.where(&table_, path_); }
  bool has(const std::string& key) const { return table_.contains(key); }

  // Adds a fault of a value: its place, its value, what is allowed and what to do.
  void refuse(const std::string& key, const std::string& allowed) {
    const toml::node* node = table_.get(key);
    context_.fault(fmt::format("{} = {}: allowed: {}", where(key), node ? text_of(*node) : "?", allowed));
  }

  const toml::node* find(const std::string& key, const std::string& allowed, bool required) {
    accept(key);
    const toml::node* node = table_.get(key);
    if (!node && required) {
      context_.fault(
          fmt::format("{}: missing; add `{} = ...`, allowed: {}", context_.where(&table_, path(key)), key, allowed));
    }
    return node;
  }

  void wrong_type(const std::string& key, const std::string& allowed) {
    const toml::node& node = *table_.get(key);
    context_.fault(
        fmt::format("{} = {}: wrong type, {}; allowed: {}", where(key), text_of(node), type_name(node), allowed));
  }

  bool number(const std::string& key, double& value, const Range& range, const char* unit, bool required = false) {
    const std::string allowed = fmt::format("a number, {}{}{}", range.text(), *unit ? ", " : "", unit);
    const toml::node* node = find(key, allowed, required);
    return node && element(key, *node, value, range, allowed);
  }
  bool number(const std::string& key, std::optional<double>& value, const Range& range, const char* unit) {
    double v = 0.0;
    if (!number(key, v, range, unit)) return false;
    value = v;
    return true;
  }

  template <typename Integer>
  bool integer(const std::string& key, Integer& value, long lower, long upper, bool required = false) {
    const std::string allowed = fmt::format("an integer, {} to {}", lower, upper);
    const toml::node* node = find(key, allowed, required);
    if (!node) return false;
    // 1e6 is a floating point number in TOML; whole ones are accepted as integers.
    const std::optional<double> number = number_of(*node);
    if (!number || *number != std::floor(*number)) return wrong_type(key, allowed), false;
    if (*number < static_cast<double>(lower) || *number > static_cast<double>(upper))
      return refuse(key, allowed), false;
    value = static_cast<Integer>(*number);
    return true;
  }

  bool boolean(const std::string& key, bool& value) {
    const toml::node* node = find(key, "true or false", false);
    if (!node) return false;
    if (!node->is_boolean()) return wrong_type(key, "true or false"), false;
    value = *node->value<bool>();
    return true;
  }

  bool text(const std::string& key, std::string& value, const std::string& allowed, bool required = false) {
    const toml::node* node = find(key, allowed, required);
    if (!node) return false;
    if (!node->is_string()) return wrong_type(key, allowed), false;
    value = *node->value<std::string>();
    return true;
  }

  bool choice(const std::string& key, std::string& value, const std::vector<std::string>& choices,
              bool required = false) {
    std::string word;
    if (!text(key, word, "one of " + join(choices), required)) return false;
    if (std::find(choices.begin(), choices.end(), word) == choices.end())
      return refuse(key, "one of " + join(choices) + did_you_mean(word, choices)), false;
    value = word;
    return true;
  }

  // Reads one of the names, and gives its value.
  template <class Value>
  bool choice(const std::string& key, Value& value, const Named<std::type_identity_t<Value>>& named,
              bool required = false) {
    std::string word;
    if (!choice(key, word, names_of(named), required)) return false;
    for (const auto& [name, of_name] : named) {
      if (name == word) value = of_name;
    }
    return true;
  }

  // Reads the name of a table [kind.NAME].
  template <class Listed>
  void name_of(const std::string& key, std::string& value, const Listed& listed, const char* kind, bool required) {
    const std::vector<std::string> names = names_of(listed);
    const std::string allowed = fmt::format("a name among [{}.*]: {}", kind, names.empty() ? "none yet" : join(names));
    if (text(key, value, allowed, required) && !listed.contains(value))
      refuse(key, allowed + did_you_mean(value, names));
  }

  template <typename Element, size_t N>
  bool numbers(const std::string& key, std::array<Element, N>& value, const Range& range, const char* unit,
               bool required = false) {
    const std::string allowed = fmt::format("a list of {} {}, each {}, {}", N,
                                            std::is_integral_v<Element> ? "integers" : "numbers", range.text(), unit);
    const toml::node* node = find(key, allowed, required);
    return node && elements(key, *node, value, range, allowed);
  }

  // Reads a list of any length.
  template <typename Element>
  bool numbers(const std::string& key, std::vector<Element>& value, const Range& range, const char* unit,
               bool required = false) {
    constexpr bool whole = std::is_integral_v<Element>;
    const std::string allowed =
        fmt::format("a list of {}, each {}, {}", whole ? "integers" : "numbers", range.text(), unit);
    const toml::array* given = list(key, allowed, required);
    if (!given) return false;
    if (given->empty()) return wrong_type(key, allowed), false;
    std::vector<Element> read;
    for (const toml::node& node : *given) {
      double number = 0.0;
      if (!element(key, node, number, range, allowed, whole)) return false;
      read.push_back(static_cast<Element>(number));
    }
    value = std::move(read);
    return true;
  }

  // Reads a list of points, [[x, y, z], ...].
  template <size_t N>
  bool points(const std::string& key, std::vector<std::array<double, N>>& value, const Range& range,
              const std::string& allowed, bool required = false) {
    const toml::array* given = list(key, allowed, required);
    if (!given) return false;
    std::vector<std::array<double, N>> read(given->size());
    for (size_t i = 0; i < read.size(); ++i) {
      if (!elements(key, *given->get(i), read[i], range, allowed)) return false;
    }
    value = std::move(read);
    return true;
  }
  // Reads the corners of a line: at least two, each different from the one before.
  template <size_t N>
  bool line(const std::string& key, std::vector<std::array<double, N>>& value, const Range& range,
            const std::string& allowed, bool required = false) {
    if (!points(key, value, range, allowed, required)) return false;
    const bool is_line = value.size() > 1 && std::adjacent_find(value.begin(), value.end()) == value.end();
    if (!is_line) refuse(key, allowed);
    return is_line;
  }

  // Reads a list of at least one text.
  bool texts(const std::string& key, std::vector<std::string>& value, const std::string& allowed,
             bool required = false) {
    const toml::array* given = list(key, allowed, required);
    if (!given) return false;
    if (given->empty()) return wrong_type(key, allowed), false;
    std::vector<std::string> read;
    for (const toml::node& text : *given) {
      if (!text.is_string()) return wrong_type(key, allowed), false;
      read.push_back(*text.value<std::string>());
    }
    value = std::move(read);
    return true;
  }

  // Refuses a second control of a body, of which the first alone would act.
  void refuse_second(const std::string& key, const BodyControl& control, const std::vector<BodyControl>& before) {
    const auto same = [&](const BodyControl& other) { return other.body == control.body; };
    if (std::any_of(before.begin(), before.end(), same))
      refuse(key, "each body once in a stage; join its tables into one");
  }

  // Reads the velocity of a control: three components, each a number in m/s or "free".
  bool velocity(BodyControl& control, bool required) {
    const std::string key = "velocity", allowed = "a list of 3: a finite number in m/s, or \"free\", for x, y, z";
    const toml::array* given = list(key, allowed, required);
    if (!given) return false;
    if (given->size() != 3) return wrong_type(key, allowed), false;
    for (size_t i = 0; i < 3; ++i) {
      const toml::node& component = *given->get(i);
      const std::optional<double> v = number_of(component);
      if (!v && component.value<std::string>() != "free") return wrong_type(key, allowed), false;
      if (v && !std::isfinite(*v)) return refuse(key, allowed), false;
      control.kind[i] = v ? DofKind::velocity : DofKind::free;
      control.velocity[i] = v.value_or(0.0);
    }
    return true;
  }

  // The list of a key, or null.
  const toml::array* list(const std::string& key, const std::string& allowed, bool required = false) {
    const toml::node* node = find(key, allowed, required);
    if (node && !node->is_array()) wrong_type(key, allowed);
    return node ? node->as_array() : nullptr;
  }

  // The sub-table of a key, or null. If it is required, its absence is a fault.
  const toml::table* table(const std::string& key, const std::string& what, bool required = false) {
    const toml::node* node = find(key, what, required);
    if (!node) return nullptr;
    if (!node->is_table()) return wrong_type(key, what), nullptr;
    return node->as_table();
  }

  std::vector<const toml::table*> tables(const std::string& key, const std::string& what, bool required = false) {
    const toml::node* node = find(key, what, required);
    if (!node) return {};
    std::vector<const toml::table*> result;
    const toml::array* given = node->as_array();
    for (size_t i = 0; given && i < given->size(); ++i) {
      if (const toml::table* t = given->get(i)->as_table()) result.push_back(t);
    }
    if (!given || result.size() != given->size())
      wrong_type(key, what);
    else if (required && given->empty())
      refuse(key, what + ", at least one");
    return result;
  }

  // Reads a sub-table, or each table of a list [[key]], by visit(table).
  template <class Visit>
  bool within(const std::string& key, const std::string& what, const Visit& visit, bool required = false) {
    const toml::table* given = table(key, what, required);
    if (!given) return false;
    Table inner(context_, *given, path(key));
    visit(inner);
    inner.finish();
    return true;
  }
  template <class Visit>
  void each(const std::string& key, const Visit& visit, bool required = false, std::string what = "") {
    if (what.empty()) what = fmt::format("tables [[{}]]", header(key));
    int index = 0;
    for (const toml::table* given : tables(key, what, required)) {
      Table inner(context_, *given, fmt::format("{}.{}", path(key), ++index));
      visit(inner);
      inner.finish();
    }
  }

  const toml::table& toml() const { return table_; }
  Context& context() { return context_; }
  void accept(const std::string& key) {
    if (std::ranges::count(known_, key) == 0) known_.push_back(key);
  }
  // Refuses a key that does not go with the others. It is not among the allowed ones that messages list.
  void refuse_if_given(const std::string& key, const std::string& allowed) {
    refused_.push_back(key);
    if (has(key)) refuse(key, allowed);
  }

  void finish() {
    for (auto&& [key, node] : table_) {
      const std::string name(key.str());
      if (std::ranges::count(known_, name) + std::ranges::count(refused_, name) > 0) continue;
      context_.fault(fmt::format("{} = {}: unknown key{}; allowed here: {}", where(name), text_of(node),
                                 did_you_mean(name, known_), join(known_)));
    }
  }

 private:
  // The path as in the file: without the numbers of tables in lists.
  std::string header(const std::string& key) const {
    std::string text;
    std::istringstream words(path(key));
    for (std::string word; std::getline(words, word, '.');) {
      if (!std::isdigit(static_cast<unsigned char>(word[0]))) text += (text.empty() ? "" : ".") + word;
    }
    return text;
  }
  bool element(const std::string& key, const toml::node& node, double& value, const Range& range,
               const std::string& allowed, bool whole = false) {
    const std::optional<double> number = number_of(node);
    if (!number || (whole && *number != std::floor(*number))) return wrong_type(key, allowed), false;
    if (!range.holds(*number)) return refuse(key, allowed), false;
    value = *number;
    return true;
  }
  // Reads the first N elements.
  template <typename Element, size_t N>
  bool elements(const std::string& key, const toml::node& node, std::array<Element, N>& value, const Range& range,
                const std::string& allowed) {
    const toml::array* given = node.as_array();
    if (!given || given->size() != N) return wrong_type(key, allowed), false;
    std::array<Element, N> read{};
    for (size_t i = 0; i < N; ++i) {
      double number = 0.0;
      if (!element(key, *given->get(i), number, range, allowed, std::is_integral_v<Element>)) return false;
      read[i] = static_cast<Element>(number);
    }
    value = read;
    return true;
  }

  Context& context_;
  const toml::table& table_;
  std::string path_;
  std::vector<std::string> known_, refused_;
};

// Tables of every kind of scene. quality: its settings are the defaults; null: blocks of any shape without a quality.
void read_damping_kind(Table& t, DampingSettings& s);
void read_damping(Table& t, DampingSettings& s);  // keys of the scene's kind; those of other kinds are faults
SolverSettings read_solver(Table t, const Quality* quality);
// before: settings of the stage before, which are the defaults.
SolverSettings read_solver_of_stage(Table t, const SolverSettings& before, bool moves_ground);
// Reads the solver table of a stage, after its actions. Without one, a stage with ground motion has other defaults.
void read_stage_solver(Table& t, Stage& stage, const Scene& scene);
// Whether one name is the other with a suffix that columns add, so that both would have a column of one name.
inline bool differ_by(const std::string& suffix, const std::string& a, const std::string& b) {
  return a == b + suffix || b == a + suffix;
}

// Whether a name can be part of names of columns and files: letters, digits, '_' and '-'.
inline bool is_plain_name(const std::string& name) {
  return !name.empty() &&
         std::ranges::all_of(name, [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
}

BlockMaterial read_material(const std::string& name, Table& t, bool rigid = false);  // rigid: density is enough
JointFamily read_joint(const std::string& name, Table& t);

// Reads keys of stages of every kind of scene: name, gravity, ramp, ends, rows.
void read_stage_basics(Table& t, Stage& stage, const Stage* previous);
void read_rest(Table& t, Stage& stage);          // keys of kind rest, after read_stage_basics
void require_end(Table& t, const Stage& stage);  // after the keys of all ends
// Reads the end of a stage by displacement (m), and the monitor and direction of that displacement.
void read_monitor(Table& t, Stage& stage, const std::vector<std::string>* bodies = nullptr);
void read_law_swaps(Table& t, const Scene& scene, Stage& stage);

// path: name of the text in messages. Throws Error(bad_input) for a text that is not TOML.
toml::table parse(const std::string& text, const std::string& path);
// Scene of these tables. path: their name in messages, whose folder is searched for other files. The caller sets
// scene.text.
Scene read_scene(toml::table root, const std::string& path, const std::vector<std::string>& overrides = {});
// Applies one --set to the table. The path consists of keys, numbers of list elements from 1, or their names.
void apply_override(toml::table& root, const std::string& setting, Context& context);

}  // namespace quoin::reader
