#include "validate/wall_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <sstream>
#include <string_view>

#include "base/error.h"
#include "base/input_file.h"
#include "base/number_text.h"
#include "base/printable.h"
#include "base/text.h"
#include "law/csv_table.h"

namespace quoin::validate {

namespace {

namespace fs = std::filesystem;

// Cells of a line. Quoted cells may contain commas and doubled quotes.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

// Text of letters, digits and '-' alone, with '_' for other characters.
std::string plain(const std::string& text) {
  std::string name;
  for (const char c : text.substr(0, 40)) {
    const bool kept = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-';
    if (kept || name.empty() || name.back() != '_') name += kept ? c : '_';
  }
  return name;
}

std::vector<std::array<double, 2>> read_envelope(const fs::path& file) {
  const CsvTable table = read_csv(file.string());
  const int displacement = table.column("top_displacement_mm"), force = table.column("horizontal_force_kN");
  if (displacement < 0 || force < 0)
    throw Error(Exit::bad_input, file.string() + ": name the columns top_displacement_mm and horizontal_force_kN");
  std::vector<std::array<double, 2>> points;
  for (const std::vector<double>& row : table.rows)
    points.push_back({row[static_cast<std::size_t>(displacement)], row[static_cast<std::size_t>(force)]});
  return points;
}

struct Words {
  const char* column;
  std::string WallRow::*value;
  std::span<const std::string_view> codes{};  // allowed beginnings of units, whole words of joints; empty: any text
};
// Beginnings: calcium silicate, aerated concrete, stone, concrete, solid clay, hollow clay.
constexpr std::string_view kUnits[] = {"CS", "AAC", "ST", "C", "LAC", "LWC", "SB", "H", "V", "P"};
constexpr std::string_view kBeds[] = {"GP", "F", "TL", "TF", "DRY", "D"};
constexpr std::string_view kHeads[] = {"F", "GP", "TL", "TF", "U", "UNFILLED", "DRY", "D"};
constexpr Words kWords[] = {{"number", &WallRow::number},
                            {"campaign", &WallRow::campaign},
                            {"specimen", &WallRow::specimen},
                            {"unit_type", &WallRow::unit_type, kUnits},
                            {"bed_joints", &WallRow::bed_joints, kBeds},
                            {"head_joints", &WallRow::head_joints, kHeads},
                            {"failure_mode", &WallRow::failure_mode}};

struct Number {
  const char* column;
  Given WallRow::*value;
  double least, most;  // allowed
  bool positive;       // more than `least`
};
constexpr Number kNumbers[] = {{"courses", &WallRow::courses, 0, 1000, true},
                               {"unit_length_mm", &WallRow::unit_length, 0, 5000, true},
                               {"unit_width_mm", &WallRow::unit_width, 0, 5000, true},
                               {"unit_height_mm", &WallRow::unit_height, 0, 5000, true},
                               {"unit_strength_MPa", &WallRow::unit_strength, 0, 500, true},
                               {"unit_strength_normalised_MPa", &WallRow::unit_strength_normalised, 0, 500, true},
                               {"mortar_strength_MPa", &WallRow::mortar_strength, 0, 500, true},
                               {"masonry_compressive_strength_MPa", &WallRow::masonry_strength, 0, 500, true},
                               {"masonry_diagonal_tensile_strength_MPa", &WallRow::diagonal_strength, 0, 50, false},
                               {"mortar_modulus_MPa", &WallRow::mortar_modulus, 0, 1e6, true},
                               {"initial_shear_strength_MPa", &WallRow::cohesion, 0, 20, false},
                               {"friction_coefficient", &WallRow::friction, 0, 2, true},
                               {"shear_span_over_height", &WallRow::shear_span, 0.05, 10, false},
                               {"peak_positive_kN", &WallRow::peak_positive, -1e5, 1e5, false},
                               {"peak_negative_kN", &WallRow::peak_negative, -1e5, 1e5, false}};

struct Needed {
  const char* column;
  double WallRow::*value;
  double least, most;
  bool positive;
};
constexpr Needed kNeeded[] = {{"height_m", &WallRow::height, 0, 100, true},
                              {"length_m", &WallRow::length, 0, 100, true},
                              {"thickness_m", &WallRow::thickness, 0, 10, true},
                              {"axial_stress_MPa", &WallRow::axial_stress, 0, 100, false}};

constexpr const char* kDrifts[] = {"drift_at_peak_positive_percent", "drift_at_peak_negative_percent",
                                   "ultimate_drift_positive_percent", "ultimate_drift_negative_percent"};

class Reader {
 public:
  Reader(const std::string& file, const std::vector<std::string>& header) : file_(file), header_(header) {
    std::string missing;
    const auto need = [&](const char* column) {
      if (std::find(header.begin(), header.end(), column) == header.end())
        missing += (missing.empty() ? "" : ", ") + std::string(column);
    };
    for (const Words& w : kWords) need(w.column);
    for (const Number& n : kNumbers) need(n.column);
    for (const Needed& n : kNeeded) need(n.column);
    for (const char* d : kDrifts) need(d);
    if (!missing.empty())
      throw Error(Exit::bad_input,
                  fmt::format("{}:1: the header lacks the columns {}; name all columns of brick_walls.csv, and leave "
                              "cells blank where nothing is known",
                              file, missing));
    if (std::set<std::string>(header.begin(), header.end()).size() != header.size())
      throw Error(Exit::bad_input, file + ":1: a column stands there twice; give each one name");
  }

  // A row; nothing if it has faults.
  std::optional<WallRow> row(int line, const std::vector<std::string>& cells, std::vector<std::string>* faults) {
    line_ = line, cells_ = &cells, faults_ = faults, sound_ = true;
    if (cells.size() != header_.size()) {
      fault("", fmt::format("{} cells, but the header has {}; allowed: as many", cells.size(), header_.size()));
      return {};
    }
    WallRow row;
    row.line = line;
    for (const Words& w : kWords) row.*w.value = word(w);
    if (row.number.empty()) fault("number", "is blank; allowed: a number or word that no other row has");
    for (const Number& n : kNumbers) row.*n.value = number(n.column, n.least, n.most, n.positive);
    for (const Needed& n : kNeeded) {
      const Given value = number(n.column, n.least, n.most, n.positive);
      if (!value && cell(n.column).empty()) fault(n.column, "is blank; it must be known for a prediction");
      row.*n.value = value.value_or(0.0);
    }
    row.drift_at_peak = mean_of(kDrifts[0], kDrifts[1]);
    row.ultimate_drift = mean_of(kDrifts[2], kDrifts[3]);
    if (cell("peak_positive_kN").empty() && cell("peak_negative_kN").empty())
      fault("peak_positive_kN", "is blank, and peak_negative_kN too; one of them must be known");
    else if (sound_ && row.peak() <= 0.0)
      fault("peak_positive_kN", "and peak_negative_kN have the mean 0; allowed: a force that was measured");
    if (!sound_) return {};
    return row;
  }

 private:
  const std::string& cell(const char* column) const {
    const auto at = std::find(header_.begin(), header_.end(), column) - header_.begin();
    return (*cells_)[static_cast<std::size_t>(at)];
  }
  const std::string& word(const Words& w) {
    const std::string &text = cell(w.column), code = upper(text);
    const bool begins = w.value == &WallRow::unit_type;
    const auto fits = [&](std::string_view known) { return begins ? code.starts_with(known) : code == known; };
    if (!w.codes.empty() && !text.empty() && std::ranges::none_of(w.codes, fits))
      fault(w.column, fmt::format("'{}' is not known; allowed: blank, or {} {}", printable(text),
                                  begins ? "a code that begins with" : "one of", fmt::join(w.codes, ", ")));
    return text;
  }
  void fault(const std::string& column, const std::string& what) {
    sound_ = false;
    faults_->push_back(fmt::format("{}:{}: {}{}{}", file_, line_, column, column.empty() ? "" : " ", what));
  }
  Given number(const char* column, double least, double most, bool positive) {
    const std::string& text = cell(column);
    if (text.empty()) return {};
    double value = 0.0;
    const std::string allowed =
        fmt::format("a number {} {:g} to {:g}, or blank", positive ? "above" : "from", least, most);
    if (!parse_number(text, value) || !std::isfinite(value)) {
      fault(column, fmt::format("'{}' is not a number; allowed: {}", printable(text), allowed));
      return {};
    }
    if (value > most || value < least || (positive && value == least)) {
      fault(column, fmt::format("{:g} is out of range; allowed: {}", value, allowed));
      return {};
    }
    return value;
  }
  Given mean_of(const char* first, const char* second) {
    const Given a = number(first, -100, 100, false), b = number(second, -100, 100, false);
    if (a && b) return (std::abs(*a) + std::abs(*b)) / 2;
    return a ? std::abs(*a) : b ? Given(std::abs(*b)) : Given();
  }

  const std::string& file_;
  const std::vector<std::string>& header_;
  int line_ = 0;
  const std::vector<std::string>* cells_ = nullptr;
  std::vector<std::string>* faults_ = nullptr;
  bool sound_ = true;
};

}  // namespace

double WallRow::peak() const {
  if (peak_positive && peak_negative) return (std::abs(*peak_positive) + std::abs(*peak_negative)) / 2;
  return std::abs(peak_positive ? *peak_positive : peak_negative.value_or(0.0));
}

std::string WallRow::folder_name() const { return plain(number) + "_" + plain(campaign) + "_" + plain(specimen); }

WallTable read_wall_table(const std::string& file) {
  std::istringstream stream(read_text_file(file));
  WallTable table;
  std::string line;
  int number = 0;
  std::vector<std::string> header;
  while (header.empty() && std::getline(stream, line)) {
    ++number;
    if (!trimmed(line).empty()) header = cells_of(line);
  }
  if (header.empty()) throw Error(Exit::bad_input, file + ": it is empty; give a table of walls, a row each");
  Reader reader(file, header);
  std::set<std::string> folders;
  const fs::path envelopes = fs::path(file).parent_path() / "envelopes";
  while (std::getline(stream, line)) {
    ++number;
    if (trimmed(line).empty()) continue;
    const std::vector<std::string> cells = cells_of(line);
    std::optional<WallRow> row = reader.row(number, cells, &table.faults);
    if (!row) continue;
    if (!folders.insert(row->folder_name()).second)
      table.faults.push_back(fmt::format(
          "{}:{}: number '{}' with campaign and specimen stands there twice; give rows numbers of their own", file,
          number, printable(row->number)));
    else
      table.rows.push_back(std::move(*row));
  }
  for (WallRow& row : table.rows) {
    const fs::path envelope = envelopes / (plain(row.specimen) + ".csv");
    if (fs::exists(envelope)) row.envelope = read_envelope(envelope);
  }
  return table;
}

}  // namespace quoin::validate
