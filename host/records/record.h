// Ground motion over time: what instruments record and what scenes prescribe at supports.
#pragma once

#include <string>
#include <vector>

#include "base/time_series.h"

namespace quoin {

inline constexpr double kStandardGravity = 9.80665;  // m/s2: "g" as a unit of records

// What the values of a record are.
enum class MotionKind { acceleration, velocity, displacement };  // m/s2, m/s, m
const char* motion_unit(MotionKind kind);                        // "m/s2", "m/s", "m"

// One direction of a record.
struct RecordComponent {
  std::string name;           // as the file has it: "HNE", "x", "acceleration"
  std::vector<double> value;  // SI, one a time
};

// Components over common times. Values are linear in time between samples and 0 before the first one.
struct GroundRecord {
  std::string source;  // file or generator
  MotionKind kind = MotionKind::acceleration;
  std::vector<double> time;                 // s, increasing, at least two
  std::vector<RecordComponent> components;  // at least one
  std::vector<std::string> assumptions;     // each a sentence: units or times that the source does not state
};

// Velocity (m/s) and displacement (m) at the samples, from rest at the first one. They are the exact integrals of an
// acceleration that is linear between samples.
struct MotionHistory {
  std::vector<double> velocity, displacement;
};
MotionHistory integrate_acceleration(const TimeSeries& acceleration);

// Acceleration (m/s2) of one component, linear between samples. Of velocities and displacements by differences of
// second order, one-sided at the ends: error h^2/6 and h^2/12 of the next two derivatives inside.
TimeSeries acceleration_of(const GroundRecord& record, std::size_t component);

// Measures of one component.
struct RecordMeasures {
  double pga = 0.0, pgv = 0.0, pgd = 0.0;             // largest |a|, |v|, |u|: m/s2, m/s, m
  double end_velocity = 0.0, end_displacement = 0.0;  // m/s, m
  double arias = 0.0;                                 // pi/(2 g) integral of a^2, m/s
  double significant_duration = 0.0;                  // from 5 to 95 % of the Arias intensity, s
};
// Extremes of the velocity are those of the integral, between samples too; of the displacement those at samples.
RecordMeasures measure_record(const TimeSeries& acceleration);

}  // namespace quoin
