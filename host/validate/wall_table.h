// Tables of walls that were tested: one row a wall, as brick_walls.csv has them. Cells may be blank.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace quoin::validate {

using Given = std::optional<double>;  // nothing where the cell is blank

// What a campaign reports of one wall. Units are those of the columns.
struct WallRow {
  int line = 0;  // line of the table
  std::string number, campaign, specimen, unit_type, bed_joints, head_joints, failure_mode;
  double height = 0.0, length = 0.0, thickness = 0.0;                   // m
  double axial_stress = 0.0;                                            // MPa, at the top
  Given courses, unit_length, unit_width, unit_height;                  // -, mm, mm, mm
  Given unit_strength, unit_strength_normalised, mortar_strength;       // MPa
  Given masonry_strength, diagonal_strength, mortar_modulus, cohesion;  // MPa
  Given friction, shear_span;                                           // -, H0/H
  Given drift_at_peak, ultimate_drift;                                  // %, mean of the sides that are given
  Given peak_positive, peak_negative;                                   // kN

  // Measured envelope, mm and kN, in its order; empty: none. In FOLDER/envelopes/SPECIMEN.csv beside the table.
  std::vector<std::array<double, 2>> envelope;

  double peak() const;  // kN, mean of the two sides, or the one that is given
  // NUMBER_CAMPAIGN_SPECIMEN of letters, digits, '-', '_' alone: a name for folders.
  std::string folder_name() const;
  std::string name() const { return campaign + " " + specimen; }
};

struct WallTable {
  std::vector<WallRow> rows;
  std::vector<std::string> faults;  // rows that were left out: file, line, column, value, what is allowed
};

// Throws Error(bad_input) where the file cannot be read or its header has not the columns.
WallTable read_wall_table(const std::string& file);

}  // namespace quoin::validate
