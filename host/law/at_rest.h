// Evaluation of a law for contact points at rest, with jumps unchanged.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "law/law_library.h"

namespace quoin {

// Contact points of one material; columns are owned by the caller.
struct RestingPoints {
  std::size_t count = 0;
  const double* normal_jump = nullptr;              // m
  std::array<const double*, 3> traction{};          // Pa
  std::vector<const double*> state;                 // in the order of the law; null: not kept
  std::vector<quoin_property_column> properties{};  // properties that scatter
};

struct AnswerAtRest {
  quoin_status status = QUOIN_OK;
  std::uint64_t failed_count = 0;
  bool failed() const { return status != QUOIN_OK || failed_count > 0; }
};

// add_outputs: adds output columns to the batch; tractions and states of the evaluation are discarded.
AnswerAtRest evaluate_at_rest(const Material& material, const RestingPoints& points,
                              const std::function<void(quoin_batch&)>& add_outputs);

// Whether a small opening gives tension in this initial state, as for a bonded or elastic point. False for a state that
// the law does not have.
bool carries_tension(const Material& material, const std::string& initial_state);

}  // namespace quoin
