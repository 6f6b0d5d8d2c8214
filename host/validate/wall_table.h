// Tables of tested walls, one row per wall, as in brick_walls.csv. Cells may be blank.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace quoin::validate {

using Given = std::optional<double>;  // nothing: the cell is blank

// Data of one wall in a campaign, in the units of the columns.
struct WallRow {
  int line = 0;  // line of the table
  std::string number, campaign, specimen, unit_type, bed_joints, head_joints, failure_mode;
  double height = 0.0, length = 0.0, thickness = 0.0;                   // m
  double axial_stress = 0.0;                                            // MPa, at the top
  Given courses, unit_length, unit_width, unit_height;                  // -, mm, mm, mm
  Given unit_strength, unit_strength_normalised, mortar_strength;       // MPa
  Given masonry_strength, diagonal_strength, mortar_modulus, cohesion;  // MPa
  Given friction, shear_span;                                           // -, H0/H
  Given drift_at_peak, ultimate_drift;                                  // %, mean of the given sides
  Given peak_positive, peak_negative;                                   // kN

  // Measured envelope, mm and kN, in its order; empty: none. It is in FOLDER/envelopes/SPECIMEN.csv beside the table.
  std::vector<std::array<double, 2>> envelope;

  double peak() const;  // kN, mean of both sides, or the given one
  // NUMBER_CAMPAIGN_SPECIMEN with letters, digits, '-', '_' alone: a name for folders.
  std::string folder_name() const;
  std::string name() const { return campaign + " " + specimen; }
};

struct WallTable {
  std::vector<WallRow> rows;
  std::vector<std::string> faults;  // faults of rows that are left out: file, line, column, value, what is allowed
};

// Throws Error(bad_input) for a file that cannot be read or has a header without these columns.
WallTable read_wall_table(const std::string& file);

}  // namespace quoin::validate
