#include "model/halo.h"

#include <algorithm>

namespace quoin {

void Halo::add(Border border) {
  border.outgoing.resize(border.send.size());
  border.incoming.resize(border.receive.size());
  borders_.push_back(std::move(border));
}

void Halo::send(Ranks& ranks) {
  send_.clear(), receive_.clear();
  for (Border& b : borders_) {
    std::transform(b.send.begin(), b.send.end(), b.outgoing.begin(), [](const double* value) { return *value; });
    if (!b.outgoing.empty()) send_.push_back({b.rank, b.outgoing});
    if (!b.incoming.empty()) receive_.push_back({b.rank, b.incoming});
  }
  ranks.start(send_, receive_);
}

void Halo::receive(Ranks& ranks) {
  ranks.finish();
  for (Border& b : borders_) {
    for (std::size_t i = 0; i < b.receive.size(); ++i) *b.receive[i] = b.incoming[i];
  }
}

std::size_t Halo::bytes() const {
  std::size_t numbers = 0;
  for (const Border& b : borders_) numbers += b.outgoing.size();
  return numbers * sizeof(double);
}

}  // namespace quoin
