// What is the same on all ranks: whether they go on, and the end of a run of which no rank has all. Written where ranks
// agree, in each step and at the end.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "step/results.h"

namespace quoin {

struct RankAgreement {
  bool failed = false;       // one of them in this step
  bool stop_wanted = false;  // here
  bool stop = false;         // whether any rank is to stop
  bool together = true;      // all ranks end in the same way
  // End conditions of a run in parts, for rank 0.
  std::optional<std::array<long, kConditionCount>> end_conditions;
  std::uint64_t end_hash = 0;
  std::optional<std::uint64_t> start_hash;  // hash where states differ from rank to rank at the start
};

}  // namespace quoin
