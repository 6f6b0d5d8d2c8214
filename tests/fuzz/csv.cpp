// Tables of `quoin path` and `quoin fit`, and records of ground motions.
#include <cmath>
#include <cstdlib>

#include "input.h"
#include "judge.h"
#include "law/csv_table.h"
#include "records/read_record.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  const std::string file = file_of(data, size, ".csv");
  judge({Exit::bad_input}, [&] {
    for (const auto& row : read_csv(file).rows) {
      for (const double value : row) {
        if (!std::isfinite(value)) std::abort();
      }
    }
  });
  judge({Exit::bad_input}, [&] {
    const GroundRecord series = read_record(file);
    for (std::size_t i = 1; i < series.time.size(); ++i) {
      if (!(series.time[i] > series.time[i - 1])) std::abort();
    }
  });
  return 0;
}
