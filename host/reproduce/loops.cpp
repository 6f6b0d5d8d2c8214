#include "reproduce/loops.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace quoin::reproduce {

namespace {

struct Rows {
  std::size_t first = 0, end = 0;  // one past the last
};

std::vector<Rows> half_cycles(const Curve& c) {
  std::vector<Rows> rows;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const int half_cycle = c.half_cycle[i];
    if (half_cycle < 0) continue;
    rows.resize(std::max(rows.size(), static_cast<std::size_t>(half_cycle) + 1));
    Rows& half = rows[static_cast<std::size_t>(half_cycle)];
    if (half.end == 0) half.first = i;
    half.end = i + 1;
  }
  return rows;
}

// Row of the farthest displacement on a side.
std::size_t farthest(const Curve& c, Rows rows, double side) {
  std::size_t best = rows.first;
  for (std::size_t i = rows.first; i < rows.end; ++i)
    if (side * c.displacement[i] > side * c.displacement[best]) best = i;
  return best;
}

// Displacement at which the force passes 0 after row `from`; that of the last row if it does not.
double where_force_ends(const Curve& c, std::size_t from, std::size_t end) {
  for (std::size_t i = from + 1; i < end; ++i) {
    if (c.force[i - 1] == 0.0 || (c.force[i] > 0.0) == (c.force[i - 1] > 0.0)) continue;
    const double t = c.force[i - 1] / (c.force[i - 1] - c.force[i]);
    return c.displacement[i - 1] + t * (c.displacement[i] - c.displacement[i - 1]);
  }
  return c.displacement[end - 1];
}

double side_of(const Cycles& cycles) { return cycles.velocity < 0.0 ? -1.0 : 1.0; }

}  // namespace

double Loop::damping() const {
  const double force = (largest - lowest) / 2, displacement = std::abs(farthest - back) / 2;
  return force * displacement > 0.0 ? dissipated / (2 * std::numbers::pi * force * displacement) : 0.0;
}

std::vector<Loop> loops_of(const Curve& c, const Cycles& cycles) {
  const std::vector<Rows> half = half_cycles(c);
  const double side = side_of(cycles);
  std::vector<Loop> loops;
  std::size_t h = 0;
  for (std::size_t a = 0; a < cycles.amplitudes.size(); ++a) {
    for (int k = 0; k < cycles.counts[a]; ++k, h += 2) {
      if (h + 2 >= half.size()) return loops;
      const std::size_t out = farthest(c, half[h], side), back = farthest(c, half[h + 1], -side);
      // From the zero crossing of the first half cycle to that of the next one.
      const auto passes = [&](Rows rows) {
        std::size_t i = rows.first;
        while (i + 1 < rows.end && side * c.displacement[i] < 0.0) ++i;
        return i;
      };
      const std::size_t begin = h == 0 ? half[0].first : passes(half[h]), end = passes(half[h + 2]) + 1;
      Loop loop;
      loop.amplitude = 1e3 * cycles.amplitudes[a];
      loop.repetition = k;
      for (std::size_t i = begin; i < end; ++i) {
        loop.largest = std::max(loop.largest, c.force[i]);
        loop.lowest = std::min(loop.lowest, c.force[i]);
        if (i > begin)
          loop.dissipated += 0.5 * (c.force[i] + c.force[i - 1]) * (c.displacement[i] - c.displacement[i - 1]);
      }
      loop.farthest = c.displacement[out], loop.back = c.displacement[back];
      loop.stiffness = (c.force[out] - c.force[back]) / (loop.farthest - loop.back);
      loop.residual_out = where_force_ends(c, out, half[h + 1].end);
      loop.residual_back = where_force_ends(c, back, half[h + 2].end);
      loops.push_back(loop);
    }
  }
  return loops;
}

Curve envelope_of(const Curve& c, const Cycles& cycles) {
  const std::vector<Rows> half = half_cycles(c);
  Curve envelope;
  const auto add = [&](std::size_t which, double side) {
    if (which >= half.size()) return;
    const Rows rows = half[which];
    std::size_t best = rows.first;
    for (std::size_t i = rows.first; i < rows.end; ++i)
      if (side * c.force[i] >= side * c.force[best]) best = i;
    envelope.displacement.push_back(c.displacement[best]);
    envelope.force.push_back(c.force[best]);
  };
  std::vector<std::size_t> firsts;  // half cycles that are the first with an amplitude
  std::size_t h = 0;
  for (std::size_t a = 0; a < cycles.amplitudes.size(); h += 2 * static_cast<std::size_t>(cycles.counts[a++]))
    firsts.push_back(h);
  const double side = side_of(cycles);
  for (auto f = firsts.rbegin(); f != firsts.rend(); ++f) add(*f + (side > 0.0 ? 1 : 0), -1.0);
  for (const std::size_t f : firsts) add(f + (side > 0.0 ? 0 : 1), 1.0);
  return envelope;
}

}  // namespace quoin::reproduce
