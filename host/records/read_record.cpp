#include "records/read_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>

#include "base/error.h"
#include "base/input_file.h"
#include "base/number_text.h"
#include "base/text.h"

namespace quoin {
namespace {

constexpr std::size_t kEsmHeaderLines = 64;

struct Unit {
  const char* name;
  MotionKind kind;
  double factor;  // to SI
};
constexpr Unit kUnits[] = {
    {"m/s2", MotionKind::acceleration, 1.0},     {"m/s^2", MotionKind::acceleration, 1.0},
    {"m/s/s", MotionKind::acceleration, 1.0},    {"cm/s2", MotionKind::acceleration, 1e-2},
    {"cm/s^2", MotionKind::acceleration, 1e-2},  {"cm/s/s", MotionKind::acceleration, 1e-2},
    {"cm/sec2", MotionKind::acceleration, 1e-2}, {"cm/sec/sec", MotionKind::acceleration, 1e-2},
    {"mm/s2", MotionKind::acceleration, 1e-3},   {"mm/s^2", MotionKind::acceleration, 1e-3},
    {"gal", MotionKind::acceleration, 1e-2},     {"g", MotionKind::acceleration, kStandardGravity},
    {"m/s", MotionKind::velocity, 1.0},          {"cm/s", MotionKind::velocity, 1e-2},
    {"cm/sec", MotionKind::velocity, 1e-2},      {"mm/s", MotionKind::velocity, 1e-3},
    {"m", MotionKind::displacement, 1.0},        {"cm", MotionKind::displacement, 1e-2},
    {"mm", MotionKind::displacement, 1e-3}};

// Unit of a name, also as names of columns have it: "cm_s2", "m s^2", "cm_s_s".
const Unit* unit_named(const std::string& name) {
  const std::string given = lower(name);
  std::string fraction = given;
  for (char& c : fraction) c = c == '_' || c == ' ' ? '/' : c;
  for (const std::string& text : {given, fraction}) {
    const auto* found =
        std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& unit) { return text == unit.name; });
    if (found != std::end(kUnits)) return found;
  }
  return nullptr;
}

// Whether the end of a column's name is a unit that is not known, as "ft_s2", "km/s" and "in". Read as m/s2, such a
// column would be wrong by a factor.
bool is_foreign_unit(const std::string& tail) {
  const auto is_any_of = [](const std::string& text, std::initializer_list<const char*> names) {
    return std::ranges::any_of(names, [&](const char* name) { return text == name; });
  };
  const auto is_length = [&](const std::string& text) {
    return is_any_of(text, {"m", "cm", "mm", "dm", "km", "um", "nm", "in", "inch", "ft", "feet"});
  };
  const std::string text = lower(tail);
  const auto part = text.find_first_of("_/ ");
  if (part == std::string::npos) return is_length(text) || is_any_of(text, {"mg", "%g", "mgal"});
  const std::string per = text.substr(part + 1);
  return is_any_of(per, {"s2", "s^2", "s_2", "s-2", "s/s", "s_s", "sec2", "sec^2", "sec/sec", "sec_sec"}) ||
         (is_length(text.substr(0, part)) && is_any_of(per, {"s", "sec", "h", "min", "ms"}));
}

// Lines of a file, with the place of faults.
class Lines {
 public:
  explicit Lines(const std::string& file) : file_(file) {
    std::istringstream stream(read_text_file(file));
    for (std::string line; std::getline(stream, line);) {
      line_.push_back(std::move(line));
    }
  }
  std::size_t size() const { return line_.size(); }
  const std::string& operator[](std::size_t i) const { return line_[i]; }
  [[noreturn]] void refuse(const std::string& why) const { throw Error(Exit::bad_input, file_ + ": " + why); }
  [[noreturn]] void refuse(std::size_t i, const std::string& why) const {
    throw Error(Exit::bad_input, fmt::format("{}:{}: '{}': {}", file_, i + 1, line_[i].substr(0, 80), why));
  }
  double number(std::size_t i, const std::string& word, const char* what) const {
    double value = 0.0;
    if (!parse_number(word, value) || !std::isfinite(value))
      refuse(i, fmt::format("{} '{}'; allowed: a finite number", what, word.substr(0, 40)));
    return value;
  }
  double positive(std::size_t i, const std::string& word, const char* what) const {
    const double value = number(i, word, what);
    if (!(value > 0.0)) refuse(i, fmt::format("{} {}; allowed: more than 0", what, value));
    return value;
  }
  // All numbers from line `first` on, separated by blanks and commas, times `factor`.
  std::vector<double> numbers_from(std::size_t first, double factor) const {
    std::vector<double> values;
    for (std::size_t i = first; i < size(); ++i) {
      std::string line = line_[i];
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream words(line);
      for (std::string word; words >> word;) values.push_back(factor * number(i, word, "the value"));
    }
    return values;
  }
  const std::string& file() const { return file_; }

 private:
  std::string file_;
  std::vector<std::string> line_;
};

// A record of one component with equal steps from 0 s. stated: number of values by the header.
GroundRecord even_record(const Lines& lines, std::string name, const Unit& unit, double step, double stated,
                         std::vector<double> values) {
  if (stated != static_cast<double>(values.size()))
    lines.refuse(fmt::format("the header states {} values, the file has {}; is it complete?", stated, values.size()));
  if (values.size() < 2) lines.refuse(fmt::format("{} values; allowed: at least 2", values.size()));
  GroundRecord record;
  record.source = lines.file(), record.kind = unit.kind;
  for (std::size_t i = 0; i < values.size(); ++i) record.time.push_back(static_cast<double>(i) * step);
  record.components.push_back({std::move(name), std::move(values), unit.name});
  return record;
}

// Number of KEY in a line such as "NPTS=  5366, DT=   .0050 SEC" or, in the older form, " 5366  .0050 NPTS, DT".
std::optional<std::string> beside(const std::string& line, const std::string& key, std::size_t place_before) {
  const auto at = line.find(key + "=");
  std::string rest = at == std::string::npos ? line : line.substr(at + key.size() + 1);
  std::replace(rest.begin(), rest.end(), ',', ' ');
  std::istringstream words(rest);
  std::string word;
  for (std::size_t k = 0; k <= (at == std::string::npos ? place_before : 0); ++k) words >> word;
  return word.empty() ? std::nullopt : std::optional(word);
}

bool is_peer(const Lines& lines) {
  if (lines.size() < 5) return false;
  return lower(lines[2]).find("units of") != std::string::npos && lower(lines[3]).find("npts") != std::string::npos;
}

GroundRecord read_peer(const Lines& lines) {
  const std::string units = lower(lines[2]);
  const std::string name = unquoted(units.substr(units.find("units of") + 8));
  std::string word = name.substr(0, name.find_first_of(" \t,;"));
  if (word.ends_with('.')) word.pop_back();
  const Unit* const unit = unit_named(word);
  if (!unit) lines.refuse(2, "its unit is unknown; allowed: G, CM/SEC/SEC, CM/SEC, CM and the units of CSV records");
  for (const auto& [quantity, kind] : {std::pair("acceleration", MotionKind::acceleration),
                                       {"velocity", MotionKind::velocity},
                                       {"displacement", MotionKind::displacement}}) {
    if (unquoted(units).starts_with(quantity) && kind != unit->kind)
      lines.refuse(2, fmt::format("its unit, {}, is none of {}; correct the header", unit->name, quantity));
  }
  std::string sizes = upper(lines[3]);
  for (auto at = sizes.find(" ="); at != std::string::npos; at = sizes.find(" =")) sizes.erase(at, 1);
  const auto count = beside(sizes, "NPTS", 0), step = beside(sizes, "DT", 1);
  if (!count || !step) lines.refuse(3, "NPTS and DT are missing; allowed: NPTS= 5366, DT= .0050 SEC");
  const std::string station = unquoted(lines[1]);
  const auto comma = station.find_last_of(',');
  return even_record(lines, comma == std::string::npos ? "component" : unquoted(station.substr(comma + 1)), *unit,
                     lines.positive(3, *step, "DT"), lines.positive(3, *count, "NPTS"),
                     lines.numbers_from(4, unit->factor));
}

bool is_esm(const Lines& lines) {
  for (std::size_t i = 0; i < std::min(lines.size(), kEsmHeaderLines); ++i)
    if (lines[i].starts_with("SAMPLING_INTERVAL_S:")) return true;
  return false;
}

GroundRecord read_esm(const Lines& lines) {
  if (lines.size() <= kEsmHeaderLines)
    lines.refuse(
        fmt::format("{} lines; an ESM file has {} lines of header and a value a line", lines.size(), kEsmHeaderLines));
  std::string stream = "component";
  const Unit* unit = nullptr;
  double step = 0.0, count = 0.0;
  for (std::size_t i = 0; i < kEsmHeaderLines; ++i) {
    const auto colon = lines[i].find(':');
    if (colon == std::string::npos) lines.refuse(i, "allowed in the header: KEY: value");
    const std::string key = lines[i].substr(0, colon), value = unquoted(lines[i].substr(colon + 1));
    if (key == "SAMPLING_INTERVAL_S") step = lines.positive(i, value, "SAMPLING_INTERVAL_S");
    if (key == "NDATA") count = lines.positive(i, value, "NDATA");
    if (key == "STREAM" && !value.empty()) stream = value;
    if (key == "UNITS") {
      unit = unit_named(value);
      if (!unit) lines.refuse(i, "its unit is unknown; allowed: cm/s^2, cm/s, cm and the units of CSV records");
    }
  }
  if (step == 0.0 || count == 0.0 || !unit)
    lines.refuse("the header lacks SAMPLING_INTERVAL_S, NDATA or UNITS; is it an ESM file of processed data?");
  return even_record(lines, stream, *unit, step, count, lines.numbers_from(kEsmHeaderLines, unit->factor));
}

// Where the comment of a line begins. "%g" is a unit.
std::size_t comment_of(const std::string& line) {
  auto at = line.find_first_of("#%");
  while (at != std::string::npos && lower(line.substr(at, 2)) == "%g") at = line.find_first_of("#%", at + 1);
  return std::min(line.size(), at);
}

std::vector<std::string> cells_of(std::string line, char separator) {
  line.erase(comment_of(line));
  std::vector<std::string> cells;
  std::istringstream stream(line);
  if (separator == ' ') {
    for (std::string cell; stream >> cell;) cells.push_back(cell);
    return cells;
  }
  if (unquoted(line).empty()) return cells;
  for (std::string cell; std::getline(stream, cell, separator);) cells.push_back(unquoted(cell));
  return cells;
}

char separator_of(const std::string& line) {
  for (const char c : {',', ';', '\t'})
    if (line.find(c) != std::string::npos) return c;
  return ' ';
}

// Name and unit in "x (g)", "x [g]", "x_g" and "x_m_s2". The longest tail that is a unit is it: that of "x_m_s2" is not
// "s2".
std::pair<std::string, std::string> name_and_unit(const std::string& cell) {
  const auto open = cell.find_last_of("([");
  if (open != std::string::npos && open > 0) {
    const auto close = cell.find_first_of(")]", open);
    if (close != std::string::npos)
      return {unquoted(cell.substr(0, open)), unquoted(cell.substr(open + 1, close - open - 1))};
  }
  for (auto at = cell.find('_'); at != std::string::npos; at = cell.find('_', at + 1)) {
    if (at > 0 && unit_named(cell.substr(at + 1))) return {cell.substr(0, at), cell.substr(at + 1)};
  }
  const auto underscore = cell.find_last_of('_');
  if (underscore == std::string::npos || underscore == 0) return {cell, ""};
  return {cell.substr(0, underscore), cell.substr(underscore + 1)};
}

// The longest tail of a column's name that looks like a unit; empty: none.
std::string unknown_unit(const std::string& cell) {
  for (auto at = cell.find('_'); at != std::string::npos; at = cell.find('_', at + 1)) {
    if (is_foreign_unit(cell.substr(at + 1))) return cell.substr(at + 1);
  }
  return "";
}

class CsvRecord {
 public:
  explicit CsvRecord(const Lines& lines) : lines_(lines) { record_.source = lines.file(); }

  GroundRecord read() {
    bool first = true;
    char separator = ' ';
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (first) separator = separator_of(lines_[i].substr(0, comment_of(lines_[i])));
      const std::vector<std::string> cells = cells_of(lines_[i], separator);
      if (cells.empty()) continue;
      double number = 0.0;
      const bool header = first && !parse_number(cells[0], number);
      if (header)
        take_header(i, cells);
      else if (first)
        assume_columns(i, cells);
      if (!header) take_row(i, cells);
      first = false;
    }
    if (record_.time.size() < 2)
      lines_.refuse(fmt::format("{} rows of numbers; allowed: at least 2", record_.time.size()));
    return std::move(record_);
  }

 private:
  void take_header(std::size_t line, const std::vector<std::string>& cells) {
    if (cells.size() < 2)
      lines_.refuse(line, "one column; allowed: time and at least one component, each with its unit");
    find_time(line, cells);
    std::optional<MotionKind> kind;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (c == time_column_) continue;
      const auto [name, unit_name] = name_and_unit(cells[c]);
      const Unit* unit = unit_named(unit_name);
      if (is_table_of_run() && (!unit || unit->kind != MotionKind::acceleration)) continue;
      if (!unit) refuse_foreign_unit(line, c, cells[c]);
      const bool assumed = !unit;
      if (assumed) {
        record_.assumptions.push_back(
            fmt::format("{}: column '{}' is an acceleration in m/s2", lines_.file(), cells[c]));
        unit = &kUnits[0];
      }
      if (kind && *kind != unit->kind)
        lines_.refuse(line, fmt::format("column {} is in {}, column 2 in {}; allowed: accelerations, velocities or "
                                        "displacements, not a mixture",
                                        c + 1, unit->name, record_.components.front().unit));
      kind = unit->kind;
      const std::string& component = assumed ? cells[c] : name;
      if (std::ranges::any_of(record_.components, [&](const auto& other) { return other.name == component; }))
        lines_.refuse(line, fmt::format("two columns '{}'; allowed: a name of its own for each", component));
      columns_.push_back({c, unit->factor});
      record_.components.push_back({component, {}, unit->name});
    }
    width_ = cells.size();
    if (!kind)
      lines_.refuse(line,
                    "no column states a unit of acceleration; allowed in a table whose first column is not the "
                    "time: accelerations, as 'ax_m_s2'; they alone are read");
    if (is_table_of_run() && columns_.size() + 2 < width_)
      record_.assumptions.push_back(
          fmt::format("{}: of its {} columns the {} that state a unit of acceleration are read", lines_.file(), width_,
                      columns_.size()));
    record_.kind = *kind;
  }

  // Tables of runs count steps in the first column and have motions of all kinds.
  bool is_table_of_run() const { return time_column_ > 0; }

  static bool is_time(const std::string& name) { return lower(name) == "time" || lower(name) == "t"; }

  // The column of times is named time or t; else it is the first one.
  void find_time(std::size_t line, const std::vector<std::string>& cells) {
    const auto found =
        std::ranges::find_if(cells, [](const std::string& cell) { return is_time(name_and_unit(cell).first); });
    if (found == cells.end() && lower(cells[0]) == "step")
      lines_.refuse(line, "the first column is 'step', and none is named time or t; allowed: a column 'time_s'");
    time_column_ = found == cells.end() ? 0 : static_cast<std::size_t>(found - cells.begin());
    const auto [time, time_unit] = name_and_unit(cells[time_column_]);
    if (time_unit == "ms")
      time_factor_ = 1e-3;
    else if (time_unit.empty())
      record_.assumptions.push_back(fmt::format("{}: times are in s", lines_.file()));
    else if (time_unit != "s")
      lines_.refuse(line, fmt::format("the unit '{}' of the time; allowed: s, ms", time_unit));
  }

  // Such a column may also be a second one of times.
  void refuse_foreign_unit(std::size_t line, std::size_t column, const std::string& cell) const {
    const auto [name, given] = name_and_unit(cell);
    const bool whole = (!given.empty() && cell.find_first_of("([") != std::string::npos) || is_time(name);
    const std::string foreign = whole ? given : lower(cell).ends_with("%g") ? "%g" : unknown_unit(cell);
    if (whole || !foreign.empty())
      lines_.refuse(line, fmt::format("the unit '{}' of column {} is unknown; allowed: m/s2, cm/s2, mm/s2, gal, g, "
                                      "m/s, cm/s, mm/s, m, cm, mm",
                                      foreign, column + 1));
  }

  void assume_columns(std::size_t line, const std::vector<std::string>& cells) {
    if (cells.size() < 2) lines_.refuse(line, "one number; allowed: a time and at least one value");
    record_.assumptions.push_back(fmt::format("{}: times are in s, values are accelerations in m/s2", lines_.file()));
    for (std::size_t c = 1; c < cells.size(); ++c) {
      record_.components.push_back(
          {cells.size() == 2 ? "acceleration" : fmt::format("column {}", c + 1), {}, kUnits[0].name});
      columns_.push_back({c, 1.0});
    }
    width_ = cells.size();
  }

  void take_row(std::size_t line, const std::vector<std::string>& cells) {
    // Empty cells at the end of a line are none of `cells`.
    const auto cell = [&](std::size_t c) { return c < cells.size() ? cells[c] : std::string(); };
    const bool cut = is_table_of_run() && cells.size() < width_ && cells.size() > time_column_;
    if (cells.size() != width_ && !cut)
      lines_.refuse(line, fmt::format("{} values; allowed: {}, as in the first line", cells.size(), width_));
    // A run has no acceleration before its second row.
    if (is_table_of_run() && record_.time.empty() &&
        std::ranges::all_of(columns_, [&](const Column& column) { return cell(column.place).empty(); }))
      return;
    const double time = time_factor_ * lines_.number(line, cells[time_column_], "the time");
    if (time < 0.0) lines_.refuse(line, "the time is negative; allowed: 0 s or later");
    if (!record_.time.empty() && time <= record_.time.back())
      lines_.refuse(line, fmt::format("the time {} s does not lie after {} s before it; allowed: times that increase",
                                      time, record_.time.back()));
    record_.time.push_back(time);
    for (std::size_t c = 0; c < columns_.size(); ++c)
      record_.components[c].value.push_back(columns_[c].factor *
                                            lines_.number(line, cell(columns_[c].place), "the value"));
  }

  struct Column {
    std::size_t place = 0;  // in a row, from 0
    double factor = 1.0;    // to SI
  };
  const Lines& lines_;
  GroundRecord record_;
  std::size_t width_ = 0, time_column_ = 0;
  double time_factor_ = 1.0;
  std::vector<Column> columns_;  // of the components
};

GroundRecord read_any(const std::string& file) {
  const Lines lines(file);
  if (is_peer(lines)) return read_peer(lines);
  if (is_esm(lines)) return read_esm(lines);
  const std::string extension = lower(std::filesystem::path(file).extension().string());
  if (extension == ".at2" || extension == ".vt2" || extension == ".dt2")
    lines.refuse(
        "its four lines of header do not state units and NPTS as PEER files do; allowed: line 3 '... IN UNITS OF "
        "G', line 4 'NPTS= 5366, DT= .0050 SEC'");
  return CsvRecord(lines).read();
}

// A displacement that does not begin or end at rest. Its spline stops within the last step, so that one acceleration
// exceeds all others.
void refuse_sudden_ends(const GroundRecord& record) {
  constexpr double kSudden = 3.0;      // times the largest acceleration elsewhere
  constexpr std::size_t kFewest = 10;  // samples; fewer are a motion drawn by hand
  constexpr std::size_t kEnd = 4;      // samples in which the spline still swings
  if (record.kind != MotionKind::displacement || record.time.size() < kFewest) return;
  for (std::size_t c = 0; c < record.components.size(); ++c) {
    const std::vector<double> a = acceleration_of(record, c).value;
    double elsewhere = 0.0;
    for (std::size_t i = kEnd; i + kEnd < a.size(); ++i) elsewhere = std::max(elsewhere, std::abs(a[i]));
    for (const auto& [where, sudden] : {std::pair("begin", a.front()), {"end", a.back()}}) {
      if (!(std::abs(sudden) > kSudden * elsewhere)) continue;
      throw Error(Exit::bad_input,
                  fmt::format("{}: the displacement '{}' does not {} at rest: to stop within a step takes {:.3g} m/s2, "
                              "where the rest has {:.3g}; taper it, add samples at rest, or take the acceleration",
                              record.source, record.components[c].name, where, std::abs(sudden), elsewhere));
    }
  }
}

}  // namespace

GroundRecord read_record(const std::string& file) {
  GroundRecord record = read_any(file);
  refuse_sudden_ends(record);
  return record;
}

namespace {

// Components of different files with one name get the name of their file in front, or its path where names of files are
// equal, too. of: the file of each.
void part_equal_names(std::vector<RecordComponent>& components, const std::vector<std::filesystem::path>& of) {
  const std::vector<RecordComponent> given = components;
  for (const bool whole : {false, true}) {
    const std::vector<RecordComponent> now = components;
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (std::ranges::count(now, now[i].name, &RecordComponent::name) > 1)
        components[i].name = fmt::format("{} {}", (whole ? of[i] : of[i].stem()).string(), given[i].name);
    }
  }
}

}  // namespace

GroundRecord read_record(const std::vector<std::string>& files) {
  if (files.empty()) throw Error(Exit::bad_input, "no file of a record is given");
  GroundRecord record = read_record(files[0]);
  std::vector<std::filesystem::path> of(record.components.size(), files[0]);
  for (std::size_t i = 1; i < files.size(); ++i) {
    GroundRecord next = read_record(files[i]);
    if (next.kind != record.kind)
      throw Error(Exit::bad_input, fmt::format("{} is in {}, {} in {}; allowed: one kind", files[i],
                                               recorded_units(next), files[0], recorded_units(record)));
    // One file has decimals, another multiples of a time step.
    constexpr double kRounding = 1e-9;  // s
    const auto is_same = [](double a, double b) { return std::abs(a - b) <= kRounding; };
    if (!std::ranges::equal(next.time, record.time, is_same))
      throw Error(Exit::bad_input,
                  fmt::format("{} has {} times up to {} s, {} has {} up to {} s; allowed: the same times", files[i],
                              next.time.size(), next.time.back(), files[0], record.time.size(), record.time.back()));
    of.resize(of.size() + next.components.size(), files[i]);
    std::move(next.components.begin(), next.components.end(), std::back_inserter(record.components));
    std::move(next.assumptions.begin(), next.assumptions.end(), std::back_inserter(record.assumptions));
    record.source += ", " + files[i];
  }
  part_equal_names(record.components, of);
  return record;
}

}  // namespace quoin
