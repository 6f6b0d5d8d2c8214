// Ground motion over time: records of instruments, and motion of supports in scenes.
#pragma once

#include <string>
#include <vector>

#include "base/time_series.h"

namespace quoin {

inline constexpr double kStandardGravity = 9.80665;  // m/s2: the unit "g" of records

// Quantity of the values of a record.
enum class MotionKind { acceleration, velocity, displacement };  // m/s2, m/s, m

// One component of a record.
struct RecordComponent {
  std::string name;           // name in the file: "HNE", "x", "acceleration"
  std::vector<double> value;  // SI, one per time
  std::string unit{};         // unit in the file: "g"; empty: of no file
};

// Components with common times. Values are linear in time between samples and 0 before the first one.
struct GroundRecord {
  std::string source;  // file or generator
  MotionKind kind = MotionKind::acceleration;
  std::vector<double> time;                 // s, increasing, at least two
  std::vector<RecordComponent> components;  // at least one
  std::vector<std::string> assumptions;     // sentences: units or times that the source does not state
};

// Units in the files of a record, each once: "g", or "g, cm/s2".
std::string recorded_units(const GroundRecord& record);

// Velocity (m/s) and displacement (m) at the samples, from rest at the first one. They are the exact integrals of an
// acceleration that is linear between samples.
struct MotionHistory {
  std::vector<double> velocity, displacement;
};
MotionHistory integrate_acceleration(const TimeSeries& acceleration);

// Accelerations of the spline through displacements that begins and ends at rest. They are linear between samples, so
// that the displacement is exact at each sample.
TimeSeries accelerations_of_spline(const TimeSeries& displacement);

// Acceleration (m/s2) of one component, linear between samples: of displacements that of their spline. From velocities
// it follows by differences of second order, one-sided at the ends, with errors of h^2/6 times the third derivative.
TimeSeries acceleration_of(const GroundRecord& record, std::size_t component);

// Intensity measures of one component.
struct RecordMeasures {
  double pga = 0.0, pgv = 0.0, pgd = 0.0;             // largest |a|, |v|, |u|: m/s2, m/s, m
  double end_velocity = 0.0, end_displacement = 0.0;  // m/s, m
  double arias = 0.0;                                 // pi/(2 g) integral of a^2, m/s
  double significant_duration = 0.0;                  // from 5 to 95 % of the Arias intensity, s
};
// Extremes of velocity are exact between samples too; those of displacement are at samples.
RecordMeasures measure_record(const TimeSeries& acceleration);

}  // namespace quoin
