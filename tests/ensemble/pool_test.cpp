// Work of the pool by sample.
#include "ensemble/pool.h"

#include <gmock/gmock.h>

#include "ensemble/kept_study.h"
#include "ensemble/run_sample.h"
#include "files/file.h"
#include "program.h"

namespace quoin::ensemble {
namespace {

class PoolOfStudy : public Cli {};

// The pool looked at the folders of all samples after each of them: 200,000 samples took 27 times as long each as
// 1,000.
TEST_F(PoolOfStudy, LooksAtASampleAFewTimesHoweverManyThereAre) {
  for (const std::uint64_t samples : {20u, 200u}) {
    Study study = read_study(QUOIN_ENSEMBLE_TESTS "/small_study.toml");
    study.samples = samples;
    const StudyFolder folder(folder_ / std::to_string(samples), study, Scene{}, {study.file, {}});
    std::uint64_t looks = 0;  // of this process; those of samples count in copies
    const SampleActions actions{[](std::uint64_t, const fs::path& place) { write_file(place / "sample.json", "{}"); },
                                [](std::uint64_t, const fs::path&, const std::string& reason) { FAIL() << reason; },
                                [&](const fs::path& place) { return ++looks, is_finished(place); }};
    compute_samples(folder, {1, samples, 2, true}, actions);
    for (std::uint64_t i = 1; i <= samples; ++i) EXPECT_TRUE(is_finished(folder.sample(i)));
    EXPECT_LE(looks, 3 * samples);
  }
}

}  // namespace
}  // namespace quoin::ensemble
