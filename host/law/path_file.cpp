#include "law/path_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"
#include "base/toml_text.h"
#include "files/gnuplot.h"
#include "files/memory.h"
#include "law/csv_table.h"
#include "law/property_text.h"
#include "scene/toml.h"

namespace quoin {

namespace {

constexpr double kMostSteps = 1e8;  // of a point of a path
constexpr std::array<const char*, 4> kModes = {"dissipated_tension", "dissipated_cohesion", "dissipated_friction",
                                               "dissipated_crushing"};
constexpr std::array<std::pair<const char*, uint32_t>, 9> kFlags = {
    {{"open", QUOIN_FLAG_OPEN},
     {"slipping", QUOIN_FLAG_SLIPPING},
     {"tension_damaged", QUOIN_FLAG_TENSION_DAMAGED},
     {"tension_complete", QUOIN_FLAG_TENSION_COMPLETE},
     {"shear_damaged", QUOIN_FLAG_SHEAR_DAMAGED},
     {"shear_complete", QUOIN_FLAG_SHEAR_COMPLETE},
     {"crushed", QUOIN_FLAG_CRUSHED},
     {"crushing_complete", QUOIN_FLAG_CRUSHING_COMPLETE},
     {"yielding", QUOIN_FLAG_YIELDING}}};

// Reads one file; every error has file:line.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  PathFile read() {
    toml::table root;
    const std::string content = read_input_file(file_);
    refuse_unfit_toml(content, file_);
    try {
      root = toml::parse(content, file_);
    } catch (const toml::parse_error& error) {
      throw Error(Exit::bad_input, fmt::format("{}:{}: {}", file_, error.source().begin.line, error.description()));
    }
    only(root,
         {"title", "law", "initial", "about", "tags", "let", "tolerance", "reason", "plot", "properties", "point"});
    PathFile path;
    path.file = file_;
    path.title = text(root, "title", std::filesystem::path(file_).stem().string());
    path.law = text(root, "law", "");
    if (path.law.empty()) fail(root, "law is missing");
    path.initial = text(root, "initial", "");
    path.about = text(root, "about", "");
    tolerance_ = number(root, "tolerance", 1e-12);
    reason_ = text(root, "reason", "");
    for (const toml::node& node : list(root, "tags")) path.tags.push_back(string(node, "tags"));
    for (const toml::node& node : list(root, "let")) {
      const std::string definition = string(node, "let");
      const auto equals = definition.find('=');
      if (equals == std::string::npos) fail(node, fmt::format("let: '{}': write name = formula", definition));
      std::string name = definition.substr(0, equals);
      name.erase(name.find_last_not_of(' ') + 1);
      static const std::set<std::string> taken = {"part",  "dn",  "ds",  "dt",  "sigma",  "tau",  "tau_s",
                                                  "tau_t", "dn0", "ds0", "dt0", "sigma0", "work", "flags"};
      if (taken.count(name) != 0) fail(node, fmt::format("let: '{}' already has a meaning", name));
      path.definitions.emplace_back(name, formula(node, definition.substr(equals + 1)));
    }
    for (const toml::node& node : list(root, "plot")) {
      const std::string axes = string(node, "plot");
      const auto space = axes.find(' '), second = axes.find_first_not_of(' ', space);
      if (space == 0 || second == std::string::npos) fail(node, fmt::format("plot: '{}': write \"dn sigma\"", axes));
      path.plots.emplace_back(axes.substr(0, space), axes.substr(second));
    }
    if (const toml::node* node = root.get("properties")) {
      if (!node->is_table()) fail(*node, "properties is no table");
      for (const auto& [key, value] : *node->as_table())
        path.properties.push_back(property(std::string(key.str()), value));
    }
    for (const toml::node& node : list(root, "point")) path.points.push_back(point(node));
    if (path.points.empty()) fail(root, "no [[point]]: the path goes nowhere");
    return path;
  }

 private:
  [[noreturn]] void fail(const toml::node& node, const std::string& message) const {
    throw Error(Exit::bad_input, fmt::format("{}:{}: {}", file_, node.source().begin.line, message));
  }
  void only(const toml::table& table, const std::set<std::string>& known) const {
    for (const auto& [key, value] : table) {
      if (known.count(std::string(key.str())) == 0) fail(value, fmt::format("unknown key '{}'", key.str()));
    }
  }
  std::string string(const toml::node& node, const std::string& key) const {
    const auto value = node.value<std::string>();
    if (!node.is_string() || !value) fail(node, key + " must be a string");
    return *value;
  }
  std::string text(const toml::table& table, const char* key, const std::string& otherwise) const {
    const toml::node* node = table.get(key);
    return node == nullptr ? otherwise : string(*node, key);
  }
  double number(const toml::table& table, const char* key, double otherwise) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return otherwise;
    const std::optional<double> value = number_of(*node);
    if (!value || !std::isfinite(*value)) fail(*node, fmt::format("{} must be a finite number", key));
    return *value;
  }
  const toml::array& list(const toml::table& table, const char* key) const {
    static const toml::array nothing;
    const toml::node* node = table.get(key);
    if (node == nullptr) return nothing;
    if (!node->is_array()) fail(*node, fmt::format("{} must be a list", key));
    return *node->as_array();
  }
  Formula formula(const toml::node& node, const std::string& words) const {
    try {
      return Formula(words);
    } catch (const std::invalid_argument& error) {
      fail(node, error.what());
    }
  }
  Formula number_or_formula(const toml::node& node, const std::string& key) const {
    if (const std::optional<double> value = number_of(node)) {
      if (!std::isfinite(*value)) fail(node, fmt::format("{} = {}: a finite number or a formula", key, *value));
      return Formula(signed_text(*value));
    }
    return formula(node, string(node, key));
  }
  static std::string signed_text(double value) {
    return value < 0.0 ? fmt::format("-{:.17g}", -value) : fmt::format("{:.17g}", value);
  }
  PropertySetting property(const std::string& id, const toml::node& node) const {
    PropertySetting setting;
    setting.id = id;
    setting.source.text = fmt::format("{}:{}: properties.{}", file_, node.source().begin.line, id);
    if (const std::optional<double> number = number_of(node)) {
      setting.numbers = {*number};
    } else if (node.is_string()) {
      setting.text = *node.value<std::string>();
    } else if (node.is_array()) {
      for (const toml::node& pair : *node.as_array()) {
        const toml::array* xy = pair.as_array();
        if (xy == nullptr || xy->size() != 2 || !(*xy)[0].is_number() || !(*xy)[1].is_number()) {
          fail(pair, fmt::format("properties.{}: write a table as [[0, 1], [0.3, 0.5], [1, 0]]", id));
        }
        for (const toml::node& value : *xy) setting.numbers.push_back(*number_of(value));
      }
    } else {
      fail(node, fmt::format("properties.{} must be a number, a word or a list of pairs", id));
    }
    return setting;
  }
  PathCheck check(const toml::node& node) const {
    PathCheck result;
    result.line = static_cast<int>(node.source().begin.line);
    result.tolerance = tolerance_;
    result.reason = reason_;
    if (const toml::table* table = node.as_table()) {
      only(*table, {"check", "value", "tolerance", "scale", "reason", "source"});
      result.text = text(*table, "check", "");
      if (const toml::node* value = table->get("value")) {
        result.value = number_of(*value);
        if (!result.value || std::isnan(*result.value)) fail(*value, "value must be a number");
      }
      result.tolerance = number(*table, "tolerance", tolerance_);
      if (const toml::node* scale = table->get("scale")) result.scale = number_or_formula(*scale, "scale");
      result.reason = text(*table, "reason", reason_);
      result.source = text(*table, "source", "");
    } else {
      result.text = string(node, "check");
    }
    const auto sign = result.text.find_first_of("<>=");
    if (sign == std::string::npos || sign == 0) fail(node, fmt::format("'{}': write quantity = formula", result.text));
    result.relation = result.text.substr(sign, result.text[sign] == '=' ? 1 : 2);
    if (result.relation != "=" && result.relation != "<=" && result.relation != ">=") {
      fail(node, fmt::format("'{}': relations are =, <=, >=", result.text));
    }
    result.quantity = result.text.substr(0, sign);
    result.quantity.erase(result.quantity.find_last_not_of(' ') + 1);
    result.formula = formula(node, result.text.substr(sign + result.relation.size()));
    return result;
  }
  PathPoint point(const toml::node& node) const {
    const toml::table* table = node.as_table();
    if (table == nullptr) fail(node, "point must be a table: [[point]]");
    only(*table, {"dn", "sigma", "ds", "dt", "steps", "plot", "along", "expect"});
    PathPoint result;
    result.line = static_cast<int>(node.source().begin.line);
    for (const char* key : {"dn", "sigma", "ds", "dt"}) {
      if (const toml::node* value = table->get(key)) result.targets.emplace(key, number_or_formula(*value, key));
    }
    if (result.targets.count("dn") != 0 && result.targets.count("sigma") != 0) {
      fail(node, "a point prescribes dn or sigma, not both");
    }
    const double steps = number(*table, "steps", 1.0);
    if (!(steps >= 1.0 && steps <= kMostSteps) || steps != std::floor(steps)) {
      fail(*table->get("steps"),
           fmt::format("steps = {:.15g}: allowed: whole numbers from 1 to {:g}", steps, kMostSteps));
    }
    result.steps = static_cast<int>(steps);
    if (const toml::node* plot = table->get("plot")) {
      if (!plot->is_boolean()) fail(*plot, "plot must be true or false");
      result.plotted = *plot->value<bool>();
    }
    for (const toml::node& item : list(*table, "along")) result.along.push_back(check(item));
    for (const toml::node& item : list(*table, "expect")) result.expect.push_back(check(item));
    return result;
  }

  std::string file_;
  double tolerance_ = 1e-12;
  std::string reason_;
};

// States of fracture_energy have fixed columns in OUT.csv; states of other laws follow in their own order.
std::vector<int> state_order(const quoin_law& law) {
  std::vector<int> order;
  for (const char* id : {"xi_t", "xi_s", "w", "v", "slip"}) {
    for (uint64_t i = 0; i < law.state_count; ++i) {
      if (std::string(law.states[i]->id) == id) order.push_back(static_cast<int>(i));
    }
  }
  if (order.size() != 5) order.clear();
  for (uint64_t i = 0; i < law.state_count; ++i) {
    if (std::find(order.begin(), order.end(), static_cast<int>(i)) == order.end()) order.push_back(static_cast<int>(i));
  }
  return order;
}

}  // namespace

PathFile read_path_file(const std::string& file) { return Reader(file).read(); }

Variables quantities(const quoin_law& law, const PointResult& point) {
  Variables result{{"dn", point.jump[0]},
                   {"ds", point.jump[1]},
                   {"dt", point.jump[2]},
                   {"sigma", point.traction[0]},
                   {"tau_s", point.traction[1]},
                   {"tau_t", point.traction[2]},
                   {"tau", std::hypot(point.traction[1], point.traction[2])},
                   {"energy_stored", point.energy_stored},
                   {"work", point.work},
                   {"flags", point.flags}};
  for (uint64_t i = 0; i < law.state_count; ++i) result[law.states[i]->id] = point.state[i];
  double sum = 0.0;
  for (std::size_t i = 0; i < kModes.size(); ++i) {
    result[kModes[i]] = point.dissipated[i];
    sum += point.dissipated[i];
  }
  result["dissipated"] = sum;
  for (const auto& [name, bit] : kFlags) result[name] = (point.flags & bit) != 0 ? 1.0 : 0.0;
  return result;
}

std::string path_header(const quoin_law& law) {
  std::string header = "dn,ds,dt,sigma,tau_s,tau_t";
  for (const int i : state_order(law)) header += fmt::format(",{}", law.states[i]->id);
  header += ",flags,energy_stored";
  for (const char* mode : kModes) header += fmt::format(",{}", mode);
  return header + ",work\n";
}

std::string path_row(const quoin_law& law, const PointResult& point) {
  std::string row = full_precision(point.jump[0]);
  for (const double value : {point.jump[1], point.jump[2], point.traction[0], point.traction[1], point.traction[2]}) {
    row += fmt::format(",{}", full_precision(value));
  }
  for (const int i : state_order(law)) row += fmt::format(",{}", full_precision(point.state[i]));
  row += fmt::format(",{},{}", point.flags, full_precision(point.energy_stored));
  for (const double value : point.dissipated) row += fmt::format(",{}", full_precision(value));
  return row + fmt::format(",{}\n", full_precision(point.work));
}

namespace {

// A contact point that follows a path.
class PathRun {
 public:
  PathRun(const PathFile& path, const std::string& law_name)
      : path_(path),
        law_(Law::find(law_name.empty() ? path.law : law_name)),
        contact_(std::make_shared<const Material>(law_, path.properties), path.initial) {
    // Formulas have only the properties that the file sets: so they reveal a wrong default in the law.
    for (const PropertySetting& setting : path.properties) {
      if (setting.numbers.size() != 1) continue;
      constants_[setting.id] = setting.numbers[0];
      const quoin_property_info* info = find_property(*law_.law, setting.id);
      if (info != nullptr && info->symbol != nullptr) constants_[info->symbol] = setting.numbers[0];
    }
    for (const auto& [name, formula] : path.definitions) constants_[name] = value_of(formula, constants_, 1);
  }

  PathOutcome run() {
    record(true);
    for (std::size_t number = 0; number < path_.points.size(); ++number) follow(path_.points[number], number + 1);
    return std::move(outcome_);
  }

 private:
  double value_of(const Formula& formula, const Variables& variables, int line) const {
    try {
      return formula(variables);
    } catch (const std::invalid_argument& error) {
      throw Error(Exit::bad_input, fmt::format("{}:{}: '{}': {}", path_.file, line, formula.text(), error.what()));
    }
  }

  void record(bool plotted) {
    outcome_.plotted.push_back(plotted);
    outcome_.rows.push_back(contact_.now());
    outcome_.values.push_back(quantities(*law_.law, contact_.now()));
    outcome_.closed_form.emplace_back();
  }

  // number: that of the point, from 1.
  void follow(const PathPoint& point, std::size_t number) {
    const PointResult start = contact_.now();
    Variables segment = constants_;
    segment["dn0"] = start.jump[0];
    segment["ds0"] = start.jump[1];
    segment["dt0"] = start.jump[2];
    segment["sigma0"] = start.traction[0];
    for (int step = 1; step <= point.steps; ++step) {
      segment["part"] = step == point.steps ? 1.0 : static_cast<double>(step) / point.steps;
      move(point, start, step, segment);
      record(point.plotted);
      Variables here = segment;
      for (const auto& [name, value] : outcome_.values.back()) here[name] = value;
      const std::string where = fmt::format("point {}, step {} of {}", number, step, point.steps);
      for (const PathCheck& check : point.along) verify(check, here, where);
      if (step < point.steps) continue;
      for (const PathCheck& check : point.expect) verify(check, here, where);
    }
  }

  // Moves towards the targets of a point: linearly in the part of the way, or as their formulas describe.
  void move(const PathPoint& point, const PointResult& start, int step, const Variables& segment) {
    const double part = segment.at("part");
    const auto target = [&](const char* key, double from) {
      const auto found = point.targets.find(key);
      if (found == point.targets.end()) return from;
      const double to = value_of(found->second, segment, point.line);
      return found->second.uses("part") || part == 1.0 ? to : from + (to - from) * part;
    };
    const double ds = target("ds", start.jump[1]), dt = target("dt", start.jump[2]);
    try {
      if (point.targets.count("sigma") != 0)
        contact_.press_to(target("sigma", start.traction[0]), ds, dt);
      else
        contact_.move_to(target("dn", start.jump[0]), ds, dt);
    } catch (const Error& error) {
      throw Error(error.exit_code,
                  fmt::format("{}:{}: step {} of {}: {}", path_.file, point.line, step, point.steps, error.what()));
    }
  }

  void verify(const PathCheck& check, const Variables& here, const std::string& where) {
    const auto found = outcome_.values.back().find(check.quantity);
    if (found == outcome_.values.back().end())
      throw Error(Exit::bad_input, fmt::format("{}:{}: '{}': law '{}' has no quantity '{}'", path_.file, check.line,
                                               check.text, law_.law->id, check.quantity));
    const double got = found->second, want = value_of(check.formula, here, check.line);
    const double scale = check.scale.empty() ? 0.0 : std::abs(value_of(check.scale, here, check.line));
    const double allowed = check.tolerance * std::max(std::abs(want), scale);
    double error = got - want;
    if (check.relation == "=") error = std::abs(error);
    if (check.relation == ">=") error = -error;
    ++outcome_.checks;
    if (check.relation == "=") outcome_.closed_form.back()[check.quantity] = want;
    if (allowed > 0.0 && error > 0.0) outcome_.worst = std::max(outcome_.worst, error / allowed);
    if (!(error <= allowed))
      outcome_.failures.push_back(
          fmt::format("{}:{}: {}: {}: got {:.17g}, expected {} {:.17g}, error {:.3g}, allowed {:.3g}{}", path_.file,
                      check.line, where, check.text, got, check.relation, want, error, allowed,
                      check.reason.empty() ? "" : fmt::format(" ({})", check.reason)));
    if (check.value && !(std::abs(want - *check.value) <= 1e-6 * std::abs(*check.value)))
      outcome_.failures.push_back(
          fmt::format("{}:{}: the formula of '{}' gives {:.9g}, but value = {:.9g}: the file is wrong", path_.file,
                      check.line, check.text, want, *check.value));
  }

  const PathFile& path_;
  Law law_;
  MaterialPoint contact_;
  Variables constants_;
  PathOutcome outcome_;
};

}  // namespace

PathOutcome run_path(const PathFile& path, const std::string& law_name, bool force) {
  double steps = 0.0;
  for (const PathPoint& point : path.points) steps += point.steps;
  constexpr double kOfStep = 2300.0;  // bytes per step: all quantities with their names
  if (!force)
    require_memory(kOfStep * steps, fmt::format("{}: {:g} steps", path.file, steps),
                   "give fewer steps, or try all the same with --force");
  return PathRun(path, law_name).run();
}

std::string plot_path(const PathFile& path, const PathOutcome& outcome, const std::string& folder) {
  std::vector<std::pair<std::string, std::string>> plots = path.plots;
  if (plots.empty()) {
    bool normal = false, sliding = false;
    for (const PointResult& row : outcome.rows) {
      normal = normal || row.jump[0] != outcome.rows[0].jump[0];
      sliding = sliding || row.jump[1] != 0.0 || row.jump[2] != 0.0;
    }
    if (normal || !sliding) plots.emplace_back("dn", "sigma");
    if (sliding) plots.emplace_back("ds", "tau_s");
  }
  const std::string stem = std::filesystem::path(path.file).stem().string();
  const std::filesystem::path picture = std::filesystem::path(folder) / (stem + ".png");

  const auto axis = [](const std::string& name) -> std::pair<double, std::string> {
    if (name == "dn" || name == "ds" || name == "dt" || name == "w" || name == "v" || name == "slip")
      return {1e3, name + " [mm]"};
    if (name == "sigma" || name.starts_with("tau")) return {1e-6, name + " [MPa]"};
    if (name.starts_with("energy") || name.starts_with("dissipated") || name == "work") return {1.0, name + " [J/m2]"};
    return {1.0, name};
  };
  std::string script =
      fmt::format("set terminal pngcairo size {},600 font 'sans,11' noenhanced\nset grid\n", 800 * plots.size());
  script += fmt::format("set multiplot layout 1,{} title {}\n", plots.size(), gnuplot_text(path.title));
  int block = 0;
  for (const auto& [x, y] : plots) {
    const auto [x_factor, x_label] = axis(x);
    const auto [y_factor, y_label] = axis(y);
    std::string law_rows, form_rows;
    bool any = false;
    for (std::size_t i = 0; i < outcome.rows.size(); ++i) {
      if (!outcome.plotted[i]) continue;
      const Variables& values = outcome.values[i];
      if (values.count(x) == 0 || values.count(y) == 0) {
        throw Error(Exit::bad_input, fmt::format("{}: plot '{} {}': no such quantity", path.file, x, y));
      }
      law_rows += fmt::format("{:.9g} {:.9g}\n", values.at(x) * x_factor, values.at(y) * y_factor);
      const auto form = outcome.closed_form[i].find(y);
      if (form == outcome.closed_form[i].end()) {
        form_rows += "\n";  // gap: no formula in this row
      } else {
        form_rows += fmt::format("{:.9g} {:.9g}\n", values.at(x) * x_factor, form->second * y_factor);
        any = true;
      }
    }
    script += fmt::format("set xlabel {}\nset ylabel {}\n$law{} << EOD\n{}EOD\n", gnuplot_text(x_label),
                          gnuplot_text(y_label), block, law_rows);
    if (any) script += fmt::format("$form{} << EOD\n{}EOD\n", block, form_rows);
    script += fmt::format("plot $law{} with linespoints lw 1 pt 7 ps 0.5 lc rgb '#1f77b4' title 'law'", block);
    if (any) script += fmt::format(", $form{} with points pt 6 ps 1.2 lc rgb '#d62728' title 'closed form'", block);
    script += "\n";
    ++block;
  }
  script += "unset multiplot\n";
  draw_picture_alone(picture, script);
  return picture.string();
}

}  // namespace quoin
