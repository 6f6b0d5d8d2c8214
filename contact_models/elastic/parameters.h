#pragma once

#include "quoin/quoin.h"

namespace quoin::elastic {

struct Parameters {
  double kn;  // normal stiffness, Pa/m
  double ks;  // shear stiffness, Pa/m
};

}  // namespace quoin::elastic
