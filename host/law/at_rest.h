// What a law says of contact points as they stand: an evaluation that moves nothing.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "law/law_library.h"

namespace quoin {

// Some points of one material; borrowed.
struct RestingPoints {
  std::size_t count = 0;
  const double* normal_jump = nullptr;              // m
  std::array<const double*, 3> traction{};          // Pa
  std::vector<const double*> state;                 // in the order of the law
  std::vector<quoin_property_column> properties{};  // that scatter
};

// ask: gives the batch the columns that the law is to fill beside tractions and states, which are thrown away.
void evaluate_at_rest(const Material& material, const RestingPoints& points,
                      const std::function<void(quoin_batch&)>& ask);

// Whether a point in this initial state answers a little opening with tension: one that is bonded, or elastic. False of
// a state that the law does not know.
bool carries_tension(const Material& material, const std::string& initial_state);

}  // namespace quoin
