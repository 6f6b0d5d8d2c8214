// Records of ground motion in the files in which they are passed around.
#pragma once

#include <string>

#include "records/record.h"

namespace quoin {

// By content, whatever the file is called:
// - PEER NGA .AT2, .VT2, .DT2: four lines of header with NPTS and DT, units G, CM/SEC and CM. One component.
// - ESM and ITACA ASCII (DYNA 1.x): 64 lines "KEY: value" with SAMPLING_INTERVAL_S, NDATA, UNITS. One component.
// - CSV: the first line names the columns, each with its unit: "time (s), x (g), y (g)" or "time_s, x_m/s2". Parted by
//   commas, semicolons, tabs or blanks; '#' and '%' begin a comment. Units: s, ms; m/s2, cm/s2, mm/s2, gal, g; m/s,
//   cm/s, mm/s; m, cm, mm. All columns but time have one kind. Without a header: time in s, accelerations in m/s2,
//   which is noted in `assumptions`.
// Throws Error(bad_input) with file, line, what stands there and what is allowed. Faults are an incomplete header,
// another number of values than it states, and values that are not finite. So are times that do not increase, and units
// that are unknown.
GroundRecord read_record(const std::string& file);

// The components of several files, resampled to nothing: their times must be equal. Throws Error(bad_input).
GroundRecord read_record(const std::vector<std::string>& files);

}  // namespace quoin
