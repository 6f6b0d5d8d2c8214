#include "scene/cyclic_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/smooth_step.h"

namespace quoin {

std::string text_of(const Cycles& cycles) {
  std::string text;
  for (std::size_t i = 0; i < cycles.amplitudes.size(); ++i)
    text += fmt::format("{}{}{} of {:g} mm", i == 0 ? "" : ", ", cycles.counts[i],
                        i > 0                  ? ""
                        : cycles.counts[i] > 1 ? " cycles"
                                               : " cycle",
                        1e3 * cycles.amplitudes[i]);
  return text;
}

CyclicMotion::CyclicMotion(const Cycles& cycles) : ramp_time_(cycles.ramp_time) {
  double at = 0.0, time = 0.0;
  const auto go_to = [&](double target) {
    const double way = target - at, speed = std::min(std::abs(cycles.velocity), std::abs(way) / ramp_time_);
    const double duration = std::abs(way) / speed + ramp_time_;
    way_.push_back({at, target, time, duration, std::copysign(speed, way)});
    at = target;
    time += duration;
  };
  for (std::size_t i = 0; i < cycles.amplitudes.size(); ++i) {
    const double first = std::copysign(cycles.amplitudes[i], cycles.velocity);
    for (int k = 0; k < cycles.counts[i]; ++k) go_to(first), go_to(-first);
  }
  go_to(0.0);
}

int CyclicMotion::half_cycle(double time) const {
  const auto next =
      std::upper_bound(way_.begin(), way_.end(), time, [](double t, const HalfCycle& h) { return t < h.start; });
  return std::max(0, static_cast<int>(next - way_.begin()) - 1);
}

double CyclicMotion::shortest_half_cycle() const { return std::ranges::min(way_, {}, &HalfCycle::duration).duration; }

double CyclicMotion::position(double time, double initial_velocity) const {
  const HalfCycle& h = way_[static_cast<std::size_t>(half_cycle(time))];
  const double since = time - h.start, left = h.duration - since;
  // Measured from the closer end, so that both ends are exact to the last bit.
  const double place = left <= 0.0     ? h.to
                       : since <= left ? h.from + h.velocity * smooth_way(since, ramp_time_)
                                       : h.to - h.velocity * smooth_way(left, ramp_time_);
  const double t = std::clamp(time / ramp_time_, 0.0, 1.0), rest = 1.0 - t;
  return place + initial_velocity * ramp_time_ * t * rest * rest * rest * rest;
}

bool ForceLoss::see(double force, int half_cycle, double target, double allowed_fraction) {
  bool lost = false;
  if (half_cycle != now_) {
    Side& side = sides_[target_ > 0.0 ? 0 : 1];
    const double amplitude = std::abs(target_);
    ended_ = now_, of_ended_ = of_now_, reference_ = side.force;
    lost = amplitude >= side.amplitude && of_now_ < allowed_fraction * side.force;
    if (of_now_ > side.force) side = {of_now_, amplitude};
    now_ = half_cycle, of_now_ = 0.0;
  }
  target_ = target;
  of_now_ = std::max(of_now_, target < 0.0 ? -force : force);
  return lost;
}

}  // namespace quoin
