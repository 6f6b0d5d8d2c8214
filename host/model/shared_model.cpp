#include "model/shared_model.h"

#include <algorithm>

#include "base/rank_rows.h"

namespace quoin {

void GatheredSums::append(int rank, std::size_t numbers) {
  const std::size_t first = runs_.all.empty() ? 0 : runs_.all.back().row.end;
  runs_.append(rank, {first, first + numbers});
}

double GatheredSums::sum(const Add& add) {
  constexpr std::size_t kWindow = kGatherBuffer / sizeof(double);
  const std::size_t whole = runs_.all.empty() ? 0 : runs_.all.back().row.end;
  std::vector<std::size_t> sizes(static_cast<std::size_t>(ranks_.count())), next(sizes.size());
  std::vector<double> own, all;
  double so_far = 0.0;
  auto first_run = runs_.all.begin();
  for (std::size_t begin = 0; begin < whole; begin += kWindow) {
    const std::size_t end = std::min(begin + kWindow, whole);
    while (first_run->row.end <= begin) ++first_run;
    const auto each_run = [&](const auto& visit) {
      for (auto run = first_run; run != runs_.all.end() && run->row.first < end; ++run)
        visit(static_cast<std::size_t>(run->rank), std::max(run->row.first, begin), std::min(run->row.end, end));
    };
    std::fill(sizes.begin(), sizes.end(), 0);
    own.clear();
    each_run([&](std::size_t rank, std::size_t from, std::size_t to) {
      sizes[rank] += (to - from) * sizeof(double);
      if (static_cast<int>(rank) != ranks_.rank()) return;
      for (std::size_t i = from; i < to; ++i) own.push_back(add({i, i + 1}, 0.0));  // the term of one number
    });
    all.resize(end - begin);
    ranks_.gather(std::as_bytes(std::span(own)), sizes, std::as_writable_bytes(std::span(all)));
    next[0] = 0;
    for (std::size_t r = 1; r < sizes.size(); ++r) next[r] = next[r - 1] + sizes[r - 1] / sizeof(double);
    each_run([&](std::size_t rank, std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) so_far += all[next[rank]++];
    });
  }
  return so_far;
}

}  // namespace quoin
