#include "law/answers.h"

#include <fmt/format.h>

#include <cmath>

namespace quoin {

std::optional<WrongAnswer> wrong_answer(const quoin_law& law, const Answers& answers) {
  constexpr const char* kTractions[3] = {"sigma", "tau_s", "tau_t"};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < answers.count; ++i) {
      if (const double value = answers.traction[k][i]; !std::isfinite(value))
        return WrongAnswer{
            fmt::format("law '{}' gave the traction {} = {}, no finite number", law.id, kTractions[k], value), i,
            false};
    }
  }
  for (std::size_t k = 0; k < answers.state.size(); ++k) {
    const quoin_state_info& info = *law.states[k];
    for (std::size_t i = 0; answers.state[k] && i < answers.count; ++i) {
      const double value = answers.state[k][i];
      if (value >= info.lower && value <= info.upper) continue;
      return WrongAnswer{fmt::format("law '{}' gave the state '{}' = {}, outside of [{:g}, {:g}]", law.id, info.id,
                                     value, info.lower, info.upper),
                         i, std::isfinite(value)};
    }
  }
  return std::nullopt;
}

}  // namespace quoin
