// Data on which all ranks agree: whether they continue, and the results at the end of a run that no rank holds
// whole. They are written in each step and at the end.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "step/results.h"

namespace quoin {

struct RankAgreement {
  bool failed = false;       // whether a rank has failed in this step
  bool stop_wanted = false;  // whether this rank is to stop
  bool stop = false;         // whether any rank is to stop
  bool together = true;      // false: run() has failed on some ranks and not on others
  // Number of contact points in each condition at the end of a run in parts.
  std::optional<std::array<long, kConditionCount>> end_conditions;
  std::uint64_t end_hash = 0;               // hash of the state at the end of a run in parts
  std::optional<std::uint64_t> start_hash;  // hash of the state at the start, where it differs from rank to rank
};

}  // namespace quoin
