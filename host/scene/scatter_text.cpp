#include "scene/scatter_text.h"

#include <fmt/format.h>

#include <cmath>

namespace quoin {

const std::vector<std::pair<std::string, ScatterLevel>>& scatter_levels() {
  static const std::vector<std::pair<std::string, ScatterLevel>> levels{{"point", ScatterLevel::point},
                                                                        {"joint", ScatterLevel::joint},
                                                                        {"unit", ScatterLevel::unit},
                                                                        {"course", ScatterLevel::course},
                                                                        {"wall", ScatterLevel::wall}};
  return levels;
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
  std::string text =
      fmt::format("{}, by {}", text_of(s.distribution), scatter_levels()[static_cast<std::size_t>(s.level)].first);
  if (s.of_joint_mean) text += " (of the mean over a joint)";
  if (s.correlation_length > 0.0) text += fmt::format(", correlated over {:g} m", s.correlation_length);
  return text;
}

}  // namespace quoin
