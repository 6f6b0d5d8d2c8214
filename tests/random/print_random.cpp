// Quantiles and means, for against_openturns.py.
#include <cstdio>
#include <limits>

#include "random/distribution.h"

int main() {
  using namespace quoin::random;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  for (const Distribution& d :
       {Distribution{Shape::normal, 2.0, 0.5, -kNone, kNone}, Distribution{Shape::lognormal, 2.0, 0.9, -kNone, kNone},
        Distribution{Shape::weibull, 2.0, 0.6, -kNone, kNone}, Distribution{Shape::uniform, 0.0, 0.0, 1.0, 4.0},
        Distribution{Shape::normal, 2.0, 0.5, 1.2, 2.4}, Distribution{Shape::lognormal, 2.0, 0.9, 1.0, 5.0},
        Distribution{Shape::weibull, 2.0, 0.6, 1.0, kNone}}) {
    for (const double p : {1e-6, 0.01, 0.3, 0.5, 0.9, 0.9999})
      std::printf("%s %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", shape_name(d.shape), d.mean, d.scatter, d.lower,
                  d.upper, p, Sampler(d).quantile(p), Sampler(d).mean());
  }
}
