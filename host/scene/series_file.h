// Time histories in files, as records of ground motion are passed around: a time and a value a line.
#pragma once

#include <string>

#include "scene/scene.h"

namespace quoin {

// Times in s, not negative and increasing, and finite values in any unit, parted by a comma, a semicolon or blanks.
// Blank lines and what follows '#' or '%' are skipped; a first line that begins with "t" (as in "time, acceleration")
// names the columns. Throws Error(bad_input): no such file, no row, or lines that break these rules; the first of them
// are listed, each with file, line, what stands there and what is allowed. No line is ever left out.
TimeSeries read_series_file(const std::string& file);

}  // namespace quoin
