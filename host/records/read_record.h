// Reads records of ground motion in common file formats.
#pragma once

#include <string>

#include "records/record.h"

namespace quoin {

// The format follows from the contents, not from the name of the file:
// - PEER NGA .AT2, .VT2, .DT2: four lines of header with NPTS and DT, units G, CM/SEC and CM. One component.
// - ESM and ITACA ASCII (DYNA 1.x): 64 lines "KEY: value" with SAMPLING_INTERVAL_S, NDATA, UNITS. One component.
// - CSV: the first line names the columns, each with its unit: "time (s), x (g), y (g)", "time_s, x_m/s2" or
//   "time_s, x_m_s2". Parted by commas, semicolons, tabs or blanks; '#' and '%' begin a comment. Units: s, ms; m/s2,
//   cm/s2, mm/s2, gal, g; m/s, cm/s, mm/s; m, cm, mm, with '_' for '/' too. All columns but time have one kind. Where
//   the time, named so, is not the first column, as in tables of runs, accelerations alone are read. Without a
//   header: time in s, accelerations in m/s2, which is noted in `assumptions`.
// Throws Error(bad_input) with file, line, the text there and what is allowed. Faults are an incomplete header, another
// number of values than it states, and values that are not finite. Also times that do not increase, and unknown units.
GroundRecord read_record(const std::string& file);

// Components of several files. Their times must be equal, as records are not resampled. Throws Error(bad_input).
GroundRecord read_record(const std::vector<std::string>& files);

}  // namespace quoin
