// Ground motion records of a study, and their levels of intensity.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin::reader {
class Table;
}

namespace quoin::ensemble {

// Measures of intensity of the largest component: m/s2, m/s, m/s2.
enum class IntensityMeasure { pga, pgv, sa };
inline constexpr std::size_t kMeasures = 3;
// Measures of a record; sa is NaN without a period.
using Intensities = std::array<double, kMeasures>;
struct MeasureNames {
  const char *key, *column, *label;
};
inline constexpr std::array<MeasureNames, kMeasures> kMeasureNames{
    {{"pga", "pga_m_s2", "PGA, m/s^2"}, {"pgv", "pgv_m_s", "PGV, m/s"}, {"sa", "sa_m_s2", "Sa, m/s^2"}}};
inline const MeasureNames& names_of(IntensityMeasure measure) {
  return kMeasureNames[static_cast<std::size_t>(measure)];
}

struct SuiteRecord {
  std::string name;
  std::string motion;    // ground_motion as TOML on one line, with absolute paths
  std::string as_given;  // ground_motion with paths as in the study
};

struct RecordSuite {
  enum class Method { none, incremental, stripes, cloud } method = Method::none;
  std::string stage;  // stage with ground motion
  IntensityMeasure measure = IntensityMeasure::pga;
  double period = 0.0;                                                  // period of sa, s; 0: no sa
  double first = 1.0, growth = 2.0, largest = 100.0, tolerance = 0.05;  // levels of incremental analysis
  std::vector<double> levels;                                           // levels of stripes
  double free_time = 2.0;                                               // s of simulation after the end of a record
  double displacement = 0.0;  // displacement of a block against the ground that counts as collapse, m
  std::vector<SuiteRecord> records;
  std::vector<std::string> files;  // files of the records

  bool any() const { return method != Method::none; }
};

// [shaking] and [[record]] of a study; folder: of its file, ending in '/'. Faults go to the context of the table.
RecordSuite read_record_suite(reader::Table& study, const std::string& folder);

// A record of the suite without scaling. Throws Error(bad_input).
struct SuiteMotion {
  double end = 0.0;  // s, end of the longest component
  Intensities intensity{};
};
SuiteMotion motion_of(const RecordSuite& suite, std::size_t record);

// Overrides of the scene, as for --set, for a record times a factor.
std::vector<std::string> overrides_for(const RecordSuite& suite, std::size_t record, const SuiteMotion& motion,
                                       double factor);

}  // namespace quoin::ensemble
