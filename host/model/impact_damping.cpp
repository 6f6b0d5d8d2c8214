#include "model/impact_damping.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace quoin {

namespace {

constexpr double kZoneDamping = 0.01;  // share of critical at the first frequency of a block that deforms
constexpr double kAlong = 0.5;         // damping along the joint over damping normal to it

}  // namespace

std::array<double, 2> landing_squares(const LandingBlock& landing, double kn, double ks) {
  const double half_area = 0.5 * landing.area, over_mass = 1 / landing.mass;
  return {kn * half_area * (over_mass + landing.tipping),
          ks * half_area * (over_mass + landing.height * landing.height / landing.least_inertia)};
}

std::array<double, 2> impact_viscosity(const std::array<double, 2>& squares, double impact_damping) {
  const double normal = std::sqrt(squares[0]), along = std::sqrt(squares[1]);
  return {normal > 0.0 ? 2.0 * impact_damping / normal : 0.0,
          along > 0.0 ? 2.0 * kAlong * impact_damping / along : 0.0};
}

void lower_zone_viscosity(double& least, double length, const BlockMaterial& material, double mass_scaling) {
  const double speed = std::sqrt(material.young_modulus / (material.density * mass_scaling));
  const double of_block = 2.0 * kZoneDamping * length / (std::numbers::pi * speed);
  least = least > 0.0 ? std::min(least, of_block) : of_block;
}

ImpactStep step_under_impacts(double critical, double rate, const std::function<double(double, double)>& eigenvalue) {
  const double z = 0.5 * rate * critical;
  const double x = std::max(kLeastImpactStep, std::sqrt(1 + 0.25 * z * z) - 0.5 * z), dt = x * critical;
  const double allowed = 4 / (dt * dt), all = eigenvalue(1.0, dt);
  if (all <= allowed) return {2 / (std::sqrt(all) * critical), 1.0};
  const double least = std::min(1.0, (1 - x * x) / (x * z));
  const double some = eigenvalue(least, dt);
  return {x, some < allowed ? least + (1 - least) * (allowed - some) / (all - some) : least};
}

}  // namespace quoin
