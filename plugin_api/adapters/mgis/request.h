// The request in K[0]. Negative: only a prediction operator; else the step is integrated. The absolute value selects
// the operator. Above 50 the request includes the speed of sound (K[0] = 100 + request).
#pragma once

#include <cmath>

namespace quoin::mgis {

struct Request {
  enum class Operator { none, elastic, tangent };

  Operator wanted;
  bool integration;
  bool speed_of_sound;

  explicit Request(double k0) : speed_of_sound(k0 > 50.0) {
    const double code = speed_of_sound ? k0 - 100.0 : k0;
    integration = code > -0.5;
    const double size = std::abs(code);
    // 2 secant, 3 tangent, 4 consistent tangent: a Quoin law has only the consistent tangent.
    wanted = size < 0.5 ? Operator::none : size < 1.5 ? Operator::elastic : Operator::tangent;
  }
};

}  // namespace quoin::mgis
