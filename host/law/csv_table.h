// Small tables of numbers in CSV; errors have the place in the file.
#pragma once

#include <string>
#include <vector>

namespace quoin {

struct CsvTable {
  std::string file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;  // rows[i][column]
  std::vector<int> lines;                 // line number in the file, by row

  int column(const std::string& name) const;                           // -1: none
  int column(const std::string& name, const std::string& unit) const;  // "dn", else "dn (m)"; -1: neither
};

// Reads a table. The first line has the names of columns; '#' begins a comment line; blank lines are skipped. Throws
// Error(bad_input) with file, line and value for a missing file, and for a number that is malformed or not finite. It
// also throws for a row of wrong length, a repeated column, or no row.
CsvTable read_csv(const std::string& file);

// 17 significant digits, which read back as the same double; shortest decimals would not align in columns.
std::string full_precision(double value);

}  // namespace quoin
