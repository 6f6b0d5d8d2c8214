// Records that a study shakes its walls with, and how strongly.
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

// Measures of intensity of the component that has most of it: m/s2, m/s, m/s2.
enum class IntensityMeasure { pga, pgv, sa };
inline constexpr std::size_t kMeasures = 3;
// Measures of a record; sa is not a number where no period was given.
using Intensities = std::array<double, kMeasures>;
const char* measure_key(IntensityMeasure measure);     // "pga"
const char* measure_column(IntensityMeasure measure);  // "pga_m_s2"

struct SuiteRecord {
  std::string name;
  std::string motion;    // ground_motion as TOML on one line, files with whole paths
  std::string as_given;  // the same with files as the study has them
};

struct RecordSuite {
  enum class Method { none, incremental, stripes, cloud } method = Method::none;
  std::string stage;  // that shakes
  IntensityMeasure measure = IntensityMeasure::pga;
  double period = 0.0;                                                  // period of sa, s; 0: no sa
  double first = 1.0, growth = 2.0, largest = 100.0, tolerance = 0.05;  // incremental: levels of the measure, ratios
  std::vector<double> levels;                                           // stripes
  double free_time = 2.0;                                               // s after the end of a record
  double displacement = 0.0;  // m against the ground: a block that has moved so far has collapsed
  std::vector<SuiteRecord> records;
  std::vector<std::string> files;  // that the records were read from

  bool any() const { return method != Method::none; }
};

// [shaking] and [[record]] of a study; folder: of its file, ending in '/'. Faults go to the context of the table.
RecordSuite read_record_suite(reader::Table& study, const std::string& folder);

// A record of the suite as it is, its length and intensities. Throws Error(bad_input).
struct SuiteMotion {
  double end = 0.0;  // s, of the longest component
  Intensities intensity{};
};
SuiteMotion motion_of(const RecordSuite& suite, std::size_t record);

// Lines to lay over the scene, as --set, for a record times a factor.
std::vector<std::string> overrides_for(const RecordSuite& suite, std::size_t record, const SuiteMotion& motion,
                                       double factor);

}  // namespace quoin::ensemble
