#include "records/scaling.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "records/record.h"
#include "records/response_spectrum.h"

namespace quoin {
namespace {

double intensity_of(const TimeSeries& acceleration, const IntensityTarget& target) {
  switch (target.measure) {
    case IntensityTarget::Measure::pga:
      return measure_record(acceleration).pga;
    case IntensityTarget::Measure::pgv:
      return measure_record(acceleration).pgv;
    case IntensityTarget::Measure::spectral_acceleration:
      return response_spectrum(acceleration, target.damping, std::span(&target.period, 1))[0].pseudo_acceleration;
  }
  return 0.0;
}

}  // namespace

double scale_to(const TimeSeries& acceleration, const IntensityTarget& target) {
  if (!(target.value > 0.0) || !std::isfinite(target.value))
    throw Error(Exit::bad_input, fmt::format("target intensity {}; allowed: more than 0, finite", target.value));
  const double now = intensity_of(acceleration, target);
  if (!(now > 0.0)) throw Error(Exit::bad_input, "a record that is 0 throughout cannot be scaled to an intensity");
  return target.value / now;
}

}  // namespace quoin
