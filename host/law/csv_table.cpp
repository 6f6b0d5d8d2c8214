#include "law/csv_table.h"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "base/error.h"
#include "base/input_file.h"
#include "base/number_text.h"
#include "base/text.h"

namespace quoin {

namespace {

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> result;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    result.push_back(unquoted(std::string_view(line).substr(begin, end - begin)));
    begin = end + 1;
  }
  return result;
}

}  // namespace

int CsvTable::column(const std::string& name) const {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] == name) return static_cast<int>(i);
  }
  return -1;
}

int CsvTable::column(const std::string& name, const std::string& unit) const {
  const int bare = column(name);
  return bare >= 0 ? bare : column(fmt::format("{} ({})", name, unit));
}

CsvTable read_csv(const std::string& file) {
  const auto fail = [&](int line, const std::string& message) {
    throw Error(Exit::bad_input,
                line > 0 ? fmt::format("{}:{}: {}", file, line, message) : fmt::format("{}: {}", file, message));
  };
  std::istringstream stream(read_text_file(file));

  CsvTable table;
  table.file = file;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const std::vector<std::string> fields = cells(line);
    if (table.columns.empty()) {
      for (std::size_t i = 0; i < fields.size(); ++i) {
        if (fields[i].empty()) fail(number, fmt::format("column {} has no name", i + 1));
        if (table.column(fields[i]) >= 0) fail(number, fmt::format("column '{}' twice", fields[i]));
        table.columns.push_back(fields[i]);
      }
      continue;
    }
    if (fields.size() != table.columns.size()) {
      fail(number,
           fmt::format("{} values, but the header names {} columns: '{}'", fields.size(), table.columns.size(), line));
    }
    std::vector<double> row(fields.size());
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (!parse_number(fields[i], row[i])) {
        fail(number, fmt::format("{} = '{}' is no number", table.columns[i], fields[i]));
      }
      if (!std::isfinite(row[i])) fail(number, fmt::format("{} = '{}' is not finite", table.columns[i], fields[i]));
    }
    table.rows.push_back(std::move(row));
    table.lines.push_back(number);
  }
  if (table.columns.empty()) fail(0, "is empty; the first line must name the columns");
  if (table.rows.empty()) fail(0, "has no row below its header");
  return table;
}

std::string full_precision(double value) { return fmt::format("{:.17g}", value); }

}  // namespace quoin
