// Tables: those of `quoin path` and `quoin fit`, and series of ground motions.
#include <cmath>
#include <cstdlib>

#include "base/error.h"
#include "input.h"
#include "law/csv_table.h"
#include "scene/series_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  const std::string file = file_of(data, size, ".csv");
  const auto expect_words = [](const Error& error) {
    if (error.exit_code != Exit::bad_input || *error.what() == '\0') std::abort();
  };
  try {
    for (const auto& row : read_csv(file).rows) {
      for (const double value : row) {
        if (!std::isfinite(value)) std::abort();
      }
    }
  } catch (const Error& error) {
    expect_words(error);
  }
  try {
    const TimeSeries series = read_series_file(file);
    for (std::size_t i = 1; i < series.time.size(); ++i) {
      if (!(series.time[i] > series.time[i - 1])) std::abort();
    }
  } catch (const Error& error) {
    expect_words(error);
  }
  return 0;
}
