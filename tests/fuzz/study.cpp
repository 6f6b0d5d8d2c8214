// Studies: their random quantities, and the changes of a scene for a sample.
#include "ensemble/study.h"

#include "input.h"
#include "judge.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  judge({Exit::bad_input}, [&] {
    const ensemble::Study study = ensemble::read_study(file_of(data, size, ".toml"));
    for (const std::uint64_t sample : {0u, 1u, 2u}) study.overrides_of(sample);
  });
  return 0;
}
