#include "model/model_part.h"

#include <cstddef>
#include <string>

namespace quoin::blocks {

double ModelPart::largest(double here) const {
  if (ranks) ranks->largest({&here, 1});
  return here;
}

// Throws the error of the first rank that has one.
void ModelPart::fail_together(const std::optional<Error>& here) const {
  if (!ranks) {
    if (here) throw *here;
    return;
  }
  const double first = -largest(here ? -double(ranks->rank()) : -double(ranks->count()));
  const int rank = int(first);
  if (rank == ranks->count()) return;
  const bool mine = rank == ranks->rank();
  const std::string text = mine ? here->what() : "";
  const auto length = size_t(largest(double(text.size())));
  const int code = int(largest(mine ? double(here->exit_code) : 0.0));
  std::vector<size_t> sizes(size_t(ranks->count()), 0);
  sizes[size_t(rank)] = length;
  std::string received(length, ' ');
  ranks->gather(std::as_bytes(std::span(text)), sizes, std::as_writable_bytes(std::span(received)));
  throw Error(Exit(code), received);
}

}  // namespace quoin::blocks
