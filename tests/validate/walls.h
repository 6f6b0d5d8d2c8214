// Tables of walls for tests: the header of brick_walls.csv and rows with a few cells set.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

inline std::vector<std::string> wall_columns() {
  std::ifstream stream(QUOIN_WALLS "/brick_walls.csv");
  std::string line, cell;
  std::getline(stream, line);
  std::vector<std::string> columns;
  for (std::stringstream cells(line); std::getline(cells, cell, ',');) columns.push_back(cell);
  return columns;
}

// Writes one line for each row; cells without a value are blank.
inline void write_walls(const std::filesystem::path& file,
                        const std::vector<std::map<std::string, std::string>>& rows) {
  const std::vector<std::string> columns = wall_columns();
  std::ofstream out(file);
  for (std::size_t i = 0; i < columns.size(); ++i) out << (i ? "," : "") << columns[i];
  out << "\n";
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < columns.size(); ++i)
      out << (i ? "," : "") << (row.contains(columns[i]) ? row.at(columns[i]) : "");
    out << "\n";
  }
}

// Returns a wall of dry stone blocks, 0.8 m long, 0.8 m high, 0.2 m thick, under 0.2 MPa.
inline std::map<std::string, std::string> dry_wall() {
  return {{"number", "1"},
          {"campaign", "test"},
          {"specimen", "dry"},
          {"unit_type", "ST"},
          {"courses", "4"},
          {"height_m", "0.8"},
          {"length_m", "0.8"},
          {"thickness_m", "0.2"},
          {"bed_joints", "DRY"},
          {"head_joints", "DRY"},
          {"unit_length_mm", "400"},
          {"unit_height_mm", "200"},
          {"friction_coefficient", "1.5"},
          {"axial_stress_MPa", "0.2"},
          {"shear_span_over_height", "1"},
          {"peak_positive_kN", "16"},
          {"failure_mode", "F"}};
}
