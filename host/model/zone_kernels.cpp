#include "model/zone_kernels.h"

#include <algorithm>

#include "base/fetch_ahead.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/zone_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

struct Tensor {
  V x[3][3];
};
struct Symmetric {
  V xx, yy, zz, xy, yz, zx;
};

// Gradient of y in a zone: sum of (y_k - y_0) g_k over its corners 1 to 3.
HWY_INLINE Tensor gradient_of(const ZoneLanes& zone, int first, const double* y) {
  const D d;
  V at[4][kFour];
  for (int k = 0; k < 4; ++k) load_rows([&](int l) { return y + kFour * zone.node[k][first + l]; }, at[k]);
  Tensor h;
  for (int i = 0; i < 3; ++i) {
    V apart[3];
    for (int k = 0; k < 3; ++k) apart[k] = hn::Sub(at[k + 1][i], at[0][i]);
    for (int j = 0; j < 3; ++j) {
      const auto g = [&](int k) HWY_ATTR { return hn::Load(d, zone.gradient[k][j] + first); };
      h.x[i][j] = hn::MulAdd(apart[2], g(2), hn::MulAdd(apart[1], g(1), hn::Mul(apart[0], g(0))));
    }
  }
  return h;
}

HWY_INLINE Tensor scaled(double f, const Tensor& a) {
  Tensor product;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) product.x[i][j] = hn::Mul(hn::Set(D(), f), a.x[i][j]);
  }
  return product;
}

HWY_INLINE Tensor sum_of(const Tensor& a, const Tensor& b) {
  Tensor sum;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) sum.x[i][j] = hn::Add(a.x[i][j], b.x[i][j]);
  }
  return sum;
}

// Component (i, j) of the symmetric part of a + b^T c.
HWY_INLINE V part(const Tensor& a, const Tensor& b, const Tensor& c, int i, int j) {
  V sum = hn::Add(a.x[i][j], a.x[j][i]);
  for (int m = 0; m < 3; ++m) {
    sum = hn::MulAdd(b.x[m][i], c.x[m][j], sum);
    sum = hn::MulAdd(b.x[m][j], c.x[m][i], sum);
  }
  return hn::Mul(hn::Set(D(), 0.5), sum);
}

HWY_INLINE Symmetric symmetric_part(const Tensor& a, const Tensor& b, const Tensor& c) {
  return {part(a, b, c, 0, 0), part(a, b, c, 1, 1), part(a, b, c, 2, 2),
          part(a, b, c, 0, 1), part(a, b, c, 1, 2), part(a, b, c, 2, 0)};
}

// lambda tr(e) 1 + 2 mu e.
HWY_INLINE Symmetric stress_of(const Symmetric& e, V lambda, V twice_mu) {
  const V pressure = hn::Mul(lambda, hn::Add(e.xx, hn::Add(e.yy, e.zz)));
  return {hn::MulAdd(twice_mu, e.xx, pressure),
          hn::MulAdd(twice_mu, e.yy, pressure),
          hn::MulAdd(twice_mu, e.zz, pressure),
          hn::Mul(twice_mu, e.xy),
          hn::Mul(twice_mu, e.yz),
          hn::Mul(twice_mu, e.zx)};
}

HWY_INLINE V product_of(const Symmetric& s, const Symmetric& e) {
  const V sides = hn::MulAdd(s.xy, e.xy, hn::MulAdd(s.yz, e.yz, hn::Mul(s.zx, e.zx)));
  return hn::MulAdd(s.xx, e.xx, hn::MulAdd(s.yy, e.yy, hn::MulAdd(s.zz, e.zz, hn::Add(sides, sides))));
}

// Adds the forces s g of shape gradients g to the corners, in the order of the zones. s: stress times volume.
HWY_INLINE void add_to_corners(const ZoneLanes& zone, int first, const V (&s)[3][3], double* force) {
  const D d;
  V of_corner[4][kFour];
  for (auto& corner : of_corner) corner[3] = hn::Zero(d);
  for (int i = 0; i < 3; ++i) {
    V all = hn::Zero(d);
    for (int k = 0; k < 3; ++k) {
      const auto g = [&](int j) HWY_ATTR { return hn::Load(d, zone.gradient[k][j] + first); };
      const V f = hn::MulAdd(s[i][2], g(2), hn::MulAdd(s[i][1], g(1), hn::Mul(s[i][0], g(0))));
      of_corner[k + 1][i] = f;
      all = hn::Sub(all, f);
    }
    of_corner[0][i] = all;
  }
  // The sums run zone by zone, so that their order does not depend on the length of the vector.
  const int count = std::min(kWidth, zone.count - first);
  alignas(64) double row[kWidth][4][kFour];
  for (int k = 0; k < 4; ++k) {
    for_rows(of_corner[k], kWidth, [&](int l, int c, F f) HWY_ATTR { hn::StoreU(f, Four(), row[l][k] + c); });
  }
  for (int l = 0; l < count; ++l) {
    for (int k = 0; k < 4; ++k) {
      double* const at = force + kFour * zone.node[k][first + l];
      for (int c = 0; c < kFour; c += kPart)
        hn::StoreU(hn::Add(hn::LoadU(Four(), at + c), hn::LoadU(Four(), row[l][k] + c)), Four(), at + c);
    }
  }
}

// Adds the forces -volume (1 + H) S g to the corners.
HWY_INLINE void add_forces(const ZoneLanes& zone, int first, const Tensor& h, const Symmetric& s, double* force) {
  const V less_volume = hn::Neg(hn::Load(D(), zone.volume + first));
  const V second[3][3] = {{s.xx, s.xy, s.zx}, {s.xy, s.yy, s.yz}, {s.zx, s.yz, s.zz}};
  V first_pk[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      V sum = second[i][j];
      for (int m = 0; m < 3; ++m) sum = hn::MulAdd(h.x[i][m], second[m][j], sum);
      first_pk[i][j] = hn::Mul(less_volume, sum);
    }
  }
  add_to_corners(zone, first, first_pk, force);
}

// Zones are read once a step, from main memory. The kernel takes about as long for eight zones as the fetch of eight.
constexpr int kZonesAhead = 2;

void StiffnessTimes(std::span<const ZoneLanes> zones, std::span<const double> w, double* product) {
  const D d;
  const V half = hn::Set(d, 0.5);
  std::fill(product, product + w.size(), 0.0);
  for (const ZoneLanes& zone : zones) {
    if (zones.data() + zones.size() - &zone > kZonesAhead) fetch_ahead(&zone + kZonesAhead, sizeof zone);
    for (int first = 0; first < zone.count; first += kWidth) {
      const Tensor h = gradient_of(zone, first, w.data());
      const V volume = hn::Load(d, zone.volume + first);
      const V mu = hn::Mul(half, hn::Mul(volume, hn::Load(d, zone.twice_mu + first)));
      const V trace = hn::Add(h.x[0][0], hn::Add(h.x[1][1], h.x[2][2]));
      const V pressure = hn::Mul(hn::Mul(volume, hn::Load(d, zone.lambda + first)), trace);
      V s[3][3];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j <= i; ++j) s[i][j] = s[j][i] = hn::Mul(mu, hn::Add(h.x[i][j], h.x[j][i]));
        s[i][i] = hn::Add(s[i][i], pressure);
      }
      add_to_corners(zone, first, s, product);
    }
  }
}

double ZoneForces(std::span<const ZoneLanes> zones, const ZoneStep& step, const ZoneColumns& columns) {
  const D d;
  double energy = 0.0;
  for (const ZoneLanes& zone : zones) {
    for (int first = 0; first < zone.count; first += kWidth) {
      const V lambda = hn::Load(d, zone.lambda + first), twice_mu = hn::Load(d, zone.twice_mu + first);
      const Tensor h = gradient_of(zone, first, columns.displacement);
      const Symmetric strain = symmetric_part(h, h, scaled(0.5, h));
      Symmetric stress = stress_of(strain, lambda, twice_mu);
      if (step.energies) {
        const V volume = hn::Load(d, zone.volume + first);
        alignas(64) double twice[kWidth];
        hn::Store(hn::Mul(volume, product_of(stress, strain)), d, twice);
        for (const double e : twice) energy += 0.5 * e;
      }
      if (step.beta > 0.0) {
        // (E_n - E_(n-1))/dt, exactly, from the velocity between both: sym((1 + H - dt/2 H')^T H')
        const Tensor rate = gradient_of(zone, first, columns.velocity);
        const Symmetric strain_rate = symmetric_part(rate, sum_of(h, scaled(-0.5 * step.dt, rate)), rate);
        const V beta = hn::Set(d, step.beta);
        const Symmetric viscous = stress_of(strain_rate, hn::Mul(beta, lambda), hn::Mul(beta, twice_mu));
        if (step.energies) add_forces(zone, first, h, viscous, columns.viscous);
        stress = {hn::Add(stress.xx, viscous.xx), hn::Add(stress.yy, viscous.yy), hn::Add(stress.zz, viscous.zz),
                  hn::Add(stress.xy, viscous.xy), hn::Add(stress.yz, viscous.yz), hn::Add(stress.zx, viscous.zx)};
      }
      add_forces(zone, first, h, stress, columns.force);
    }
  }
  return energy;
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace quoin::blocks {

HWY_EXPORT(ZoneForces);
HWY_EXPORT(StiffnessTimes);

double zone_forces(std::span<const ZoneLanes> zones, const ZoneStep& step, const ZoneColumns& columns) {
  return HWY_DYNAMIC_DISPATCH(ZoneForces)(zones, step, columns);
}

void stiffness_times(std::span<const ZoneLanes> zones, std::span<const double> w, double* product) {
  HWY_DYNAMIC_DISPATCH(StiffnessTimes)(zones, w, product);
}

}  // namespace quoin::blocks

#endif  // HWY_ONCE
