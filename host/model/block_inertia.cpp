#include "model/block_inertia.h"

#include <algorithm>
#include <cmath>

namespace quoin::blocks {

using namespace geometry;

namespace {

// c^2 with c = 2 sin(theta/2) / sin(theta), sin(theta) = |w| dt.
double chord_factor(const Vector& spin, double dt) {
  return 2.0 / (1.0 + std::sqrt(std::max(0.0, 1.0 - dot(spin, spin) * dt * dt)));
}

// Eq. 1: gamma |f| against the velocity.
double damped(double gamma, double force, double velocity) {
  return velocity == 0.0 ? 0.0 : std::copysign(gamma * std::abs(force), velocity);
}
Rigid damped(double gamma, const Rigid& force, const Rigid& velocity) {
  Rigid damping;
  for (int k = 0; k < 3; ++k) {
    damping.linear[k] = damped(gamma, force.linear[k], velocity.linear[k]);
    damping.angular[k] = damped(gamma, force.angular[k], velocity.angular[k]);
  }
  return damping;
}

}  // namespace

Matrix cross_matrix(const Vector& v) { return {{{0, -v.z, v.y}, {v.z, 0, -v.x}, {-v.y, v.x, 0}}}; }

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

Vector RigidInertia::gyration(const Vector& spin) const { return inverse_ * cross(spin, inertia_ * spin); }

Matrix RigidInertia::turning(const Vector& spin, double dt) const {
  const Matrix w = cross_matrix(spin);
  return chord_factor(spin, dt) * (w * w - cross_matrix(gyration(spin)));
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

RigidStep rigid_step(const UnitInertia& inertia, const InertiaFactors& s, double gamma, double dt,
                     const Rigid (&momentum)[2], const Rigid (&force)[2]) {
  RigidStep step;
  Rigid acceleration[2];  // of rigid motion, without damping
  for (int b = 0; b < inertia.count; ++b) {
    step.velocity[b] = inertia.block[b].acceleration(momentum[b]);
    acceleration[b] = inertia.block[b].acceleration(force[b]);
  }
  const double s_b = s.deformation, s_u = inertia.count == 1 ? 1.0 : s.unit;
  Vector unit_spin[2];  // before and after
  if (inertia.count == 1) {
    step.damping[0] = damped(gamma, force[0], step.velocity[0]);
    step.change[0] = dt * (acceleration[0] - inertia.block[0].acceleration(step.damping[0]));
  } else {
    const Rigid velocity = inertia.motion(momentum), whole = inertia.motion(force);
    const Rigid whole_damping = inertia.whole.acceleration(damped(gamma, inertia.whole.force(whole), velocity));
    unit_spin[0] = velocity.angular;
    unit_spin[1] = velocity.angular + dt * (whole.angular - whole_damping.angular);
    Rigid beside_damping[2];
    for (int b = 0; b < 2; ++b) {
      const Rigid beside = inertia.block[b].force(acceleration[b] - inertia.at_block(b, whole));
      beside_damping[b] = damped(gamma, beside, step.velocity[b] - inertia.at_block(b, velocity));
    }
    // What halves do beside the unit must not brake the unit.
    const Rigid leak = inertia.motion(beside_damping);
    for (int b = 0; b < 2; ++b) {
      const RigidInertia& block = inertia.block[b];
      const Rigid of_whole = inertia.at_block(b, whole), damping_of_whole = inertia.at_block(b, whole_damping);
      const Rigid beside = block.acceleration(beside_damping[b]) - inertia.at_block(b, leak);
      step.damping[b] = block.force(damping_of_whole + beside);
      step.change[b] = dt * (of_whole - damping_of_whole + 1.0 / s_u * (acceleration[b] - of_whole - beside));
      const Vector arm = block.centre() - inertia.whole.centre();
      for (const Vector& spin : unit_spin) {
        const double weight = 0.5 * dt * (1.0 - 1.0 / s_u) * chord_factor(spin, dt);
        const Vector gyration = inertia.whole.gyration(spin);
        step.change[b].linear += weight * (cross(spin, cross(spin, arm)) - cross(gyration, arm));
        step.change[b].angular += weight * (block.gyration(spin) - gyration);
      }
    }
  }
  for (int b = 0; b < inertia.count; ++b) {
    const RigidInertia& block = inertia.block[b];
    const Rigid gain = step.change[b] - dt / s_b * acceleration[b];
    step.gain[b] = {block.centre(), gain.linear, cross_matrix(gain.angular)};
    const Vector before = step.velocity[b].angular, after = before + step.change[b].angular;
    for (const Vector& spin : {before, after})
      step.gain[b].turning += 0.5 * dt * (1.0 - s_u / s_b) * block.turning(spin, dt);
    if (inertia.count == 1) continue;
    for (const Vector& spin : unit_spin) step.gain[b].turning += 0.5 * dt * (s_u - 1.0) / s_b * block.turning(spin, dt);
  }
  return step;
}

}  // namespace quoin::blocks
