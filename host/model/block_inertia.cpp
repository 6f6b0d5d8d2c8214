#include "model/block_inertia.h"

#include <algorithm>

namespace quoin::blocks {

using namespace geometry;

RigidInertia::RigidInertia(std::span<const Vector> x, std::span<const double> mass,
                           std::span<const std::uint8_t> held) {
  std::uint8_t any = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    mass_ += mass[i];
    centre_ += mass[i] * (x[i] - x[0]);
    any |= held[i];
  }
  centre_ = x[0] + centre_ / mass_;
  Matrix second = Matrix::zero();
  for (size_t i = 0; i < x.size(); ++i) {
    const Vector r = x[i] - centre_;
    second += outer(mass[i] * r, r);
  }
  *this = RigidInertia(centre_, mass_, second, any);
}

RigidInertia::RigidInertia(const Vector& centre, double mass, const Matrix& second, std::uint8_t held)
    : centre_(centre), mass_(mass), inertia_(trace(second) * Matrix{} - second) {
  for (int k = 0; k < 3; ++k) held_[k] = held >> k & 1;
  invert();
}

RigidInertia::RigidInertia(const RigidInertia& a, const RigidInertia& b) : mass_(a.mass_ + b.mass_) {
  centre_ = a.centre_ + b.mass_ / mass_ * (b.centre_ - a.centre_);
  for (const RigidInertia* part : {&a, &b}) {
    const Vector arm = part->centre_ - centre_;
    inertia_ += part->inertia_ + part->mass_ * (dot(arm, arm) * Matrix{} - outer(arm, arm));
    for (int k = 0; k < 3; ++k) held_[k] = held_[k] || part->held_[k];
  }
  invert();
}

void RigidInertia::invert() {
  if (!held_[0] && !held_[1] && !held_[2]) {
    inverse_ = inverse(inertia_);
    return;
  }
  for (int k = 0; k < 3; ++k) {
    if (!held_[(k + 1) % 3] && !held_[(k + 2) % 3]) inverse_.row[k][k] = 1.0 / inertia_.row[k][k];
  }
}

Rigid RigidInertia::acceleration(const Rigid& force) const {
  Rigid a{force.linear / mass_, inverse_ * force.angular};
  for (int k = 0; k < 3; ++k) {
    if (held_[k]) a.linear[k] = 0.0;
  }
  return a;
}

Rigid RigidInertia::force(const Rigid& acceleration) const {
  return {mass_ * acceleration.linear, inertia_ * acceleration.angular};
}

Rigid sum_about(const Vector& centre, std::span<const Vector> x, std::span<const Vector> y,
                std::span<const double> weight) {
  Rigid sum;
  for (size_t i = 0; i < x.size(); ++i) {
    const Vector f = weight.empty() ? y[i] : weight[i] * y[i];
    sum.linear += f;
    sum.angular += cross(x[i] - centre, f);
  }
  return sum;
}

Rigid UnitInertia::motion(const Rigid (&force)[2]) const {
  Rigid sum;
  for (int b = 0; b < count; ++b) {
    sum.linear += force[b].linear;
    sum.angular += force[b].angular + cross(block[b].centre() - whole.centre(), force[b].linear);
  }
  return whole.acceleration(sum);
}

Rigid UnitInertia::at_block(int b, const Rigid& of_whole) const {
  return {of_whole.linear + cross(of_whole.angular, block[b].centre() - whole.centre()), of_whole.angular};
}

double rigid_energy(const UnitInertia& inertia, const InertiaFactors& s, const Rigid (&velocity)[2]) {
  const double s_u = inertia.count == 1 ? 1.0 : s.unit;
  double energy = 0.0;
  Rigid momentum[2];
  for (int b = 0; b < inertia.count; ++b) {
    energy -= 0.5 * (s.deformation - s_u) * inertia.block[b].twice_energy(velocity[b]);
    momentum[b] = inertia.block[b].force(velocity[b]);
  }
  if (inertia.count == 2) energy -= 0.5 * (s_u - 1.0) * inertia.whole.twice_energy(inertia.motion(momentum));
  return energy;
}

}  // namespace quoin::blocks
