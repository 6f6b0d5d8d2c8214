#include "model/model_part.h"

#include <cstddef>
#include <string>

namespace quoin {

void throw_together(Ranks* ranks, const std::optional<Error>& fault) {
  if (!ranks) {
    if (fault) throw *fault;
    return;
  }
  const auto largest = [ranks](double here) {
    ranks->largest({&here, 1});
    return here;
  };
  const int count = ranks->count(), first = count - int(largest(fault ? count - ranks->rank() : 0));
  if (first == count) return;
  const bool mine = first == ranks->rank();
  const std::string text = mine ? fault->what() : "";
  const int code = int(largest(mine ? int(fault->exit_code) : 0));
  std::vector<size_t> sizes(size_t(count), 0);
  sizes[size_t(first)] = size_t(largest(double(text.size())));
  std::string received(sizes[size_t(first)], ' ');
  ranks->gather(std::as_bytes(std::span(text)), sizes, std::as_writable_bytes(std::span(received)));
  throw Error(Exit(code), received);
}

double blocks::ModelPart::largest(double here) const {
  if (ranks) ranks->largest({&here, 1});
  return here;
}

}  // namespace quoin
