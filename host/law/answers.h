// Check of the output of laws against their metadata.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "quoin.hpp"

namespace quoin {

// Columns of contact points of one law, stride 1, owned by the caller. A state that is not kept is null.
struct Answers {
  std::size_t count = 0;
  const double* traction[3] = {};
  std::vector<const double*> state;  // in the order of the law's metadata
};

struct WrongAnswer {
  std::string text;  // "law 'x' gave the state 'damage' = 7, outside of [0, 1]"
  std::size_t point = 0;
  bool finite = true;  // whether the value is finite
};

// The first value that is not finite or, for states, outside of the bounds of the metadata; nullopt: none.
std::optional<WrongAnswer> wrong_answer(const quoin_law& law, const Answers& answers);

}  // namespace quoin
