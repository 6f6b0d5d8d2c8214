#include "scene/scatter_text.h"

#include <fmt/format.h>

#include <cmath>

namespace quoin {

const char* level_name(ScatterLevel level) {
  switch (level) {
    case ScatterLevel::point:
      return "point";
    case ScatterLevel::joint:
      return "joint";
    case ScatterLevel::unit:
      return "unit";
    case ScatterLevel::course:
      return "course";
    case ScatterLevel::wall:
      return "wall";
  }
  return "?";
}

std::string text_of(const random::Distribution& d) {
  if (d.shape == random::Shape::uniform) return fmt::format("uniform, {:g} to {:g}", d.lower, d.upper);
  std::string text =
      fmt::format("{}, mean {:g}, {} {:g}", random::shape_name(d.shape), d.mean, d.mean != 0.0 ? "cov" : "sd",
                  d.mean != 0.0 ? d.scatter / std::abs(d.mean) : d.scatter);
  if (std::isfinite(d.lower)) text += fmt::format(", {:g} or more", d.lower);
  if (std::isfinite(d.upper)) text += fmt::format(", {:g} or less", d.upper);
  return text;
}

std::string text_of(const Scatter& s) {
  std::string text = fmt::format("{}, by {}", text_of(s.distribution), level_name(s.level));
  if (s.of_joint_mean) text += " (of the mean over a joint)";
  if (s.correlation_length > 0.0) text += fmt::format(", correlated over {:g} m", s.correlation_length);
  return text;
}

}  // namespace quoin
