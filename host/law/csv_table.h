// Small tables of numbers in CSV: read with the place of every fault.
#pragma once

#include <string>
#include <vector>

namespace quoin {

struct CsvTable {
  std::string file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;  // rows[i][column]
  std::vector<int> lines;                 // line of the file of each row

  int column(const std::string& name) const;  // -1: none
};

// The first line names the columns; '#' begins a comment line; blank lines are skipped. Throws Error(bad_input) with
// file, line and value for a missing file, or a number that is none or not finite. So it does for a row of another
// length, a column twice, or no row.
CsvTable read_csv(const std::string& file);

// Shortest decimal that reads back as the same double would be unreadable in columns: 17 significant digits.
std::string full_precision(double value);

}  // namespace quoin
