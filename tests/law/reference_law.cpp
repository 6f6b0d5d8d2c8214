#include "reference_law.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace quoin::reference {

namespace {

Real tangent_of(Real degrees) { return std::tan(degrees * std::numbers::pi_v<Real> / 180); }

}  // namespace

Point::Point(const Parameters& parameters, bool dry) : p_(parameters) {
  mu0_ = tangent_of(p_.phi0);
  mur_ = tangent_of(p_.phir);
  tan_psi_ = tangent_of(p_.psi0);
  Real area = 0;
  if (p_.shape == Shape::linear) area = Real(1) / 2;
  if (p_.shape == Shape::exponential) area = 1;
  for (std::size_t i = 1; i < p_.table.size() && p_.shape == Shape::table; ++i) {
    area += (p_.table[i].first - p_.table[i - 1].first) * (p_.table[i].second + p_.table[i - 1].second) / 2;
  }
  u0_ = p_.ft / p_.kn;
  if (p_.ft > 0) lt_ = (p_.G1 - p_.ft * u0_ / 2) / (p_.ft * area);
  if (p_.c0 > p_.cr) su_ = p_.G2 / ((p_.c0 - p_.cr) * area);
  if (std::isfinite(p_.fc) && p_.fc > p_.fcr) wu_ = p_.Gc / ((p_.fc - p_.fcr) * area);
  complete_t_ = complete_s_ = dry;
}

Real Point::f(Real xi, bool complete) const {
  if (complete) return 0;
  switch (p_.shape) {
    case Shape::linear:
      return std::max(Real(0), 1 - xi);
    case Shape::exponential:
      return std::exp(-xi);
    case Shape::table:
      for (std::size_t i = 1; i < p_.table.size(); ++i) {
        const auto& [x1, f1] = p_.table[i];
        const auto& [x0, f0] = p_.table[i - 1];
        if (xi < x1) return f0 + (f1 - f0) * (xi - x0) / (x1 - x0);
      }
  }
  return 0;
}

Real Point::f_slope(Real xi, bool complete) const {
  if (complete) return 0;
  switch (p_.shape) {
    case Shape::linear:
      return xi < 1 ? -1 : 0;
    case Shape::exponential:
      return -std::exp(-xi);
    case Shape::table:
      for (std::size_t i = 1; i < p_.table.size(); ++i) {
        const auto& [x1, f1] = p_.table[i];
        const auto& [x0, f0] = p_.table[i - 1];
        if (xi < x1) return (f1 - f0) / (x1 - x0);
      }
  }
  return 0;
}

// Returns e, or 0 if e is only rounding of its parts: a joint that is crushed out is at e = 0 and must stay closed.
Real Point::opening() const {
  const Real e = dn_ + w_ - v_;
  const Real rounding = 16 * std::numeric_limits<Real>::epsilon() * (std::abs(dn_) + w_ + v_);
  return std::abs(e) <= rounding ? 0 : e;
}

Real Point::secant() const {
  if (p_.ft == 0 || complete_t_) return 0;
  return p_.ft * f(xi_t_, false) / (u0_ + xi_t_ * lt_);
}

Real Point::secant_slope() const {
  if (p_.ft == 0 || complete_t_) return 0;
  const Real kappa = u0_ + xi_t_ * lt_;
  return p_.ft * (f_slope(xi_t_, false) * kappa - f(xi_t_, false) * lt_) / (kappa * kappa);
}

Real Point::crushing_strength() const {
  if (!std::isfinite(p_.fc)) return p_.fc;
  if (wu_ == 0) return p_.fc;  // perfectly plastic
  return p_.fcr + (p_.fc - p_.fcr) * f(w_ / wu_, false);
}

Real Point::crushing_slope() const {
  if (wu_ == 0) return 0;
  return (p_.fc - p_.fcr) * f_slope(w_ / wu_, false) / wu_;
}

Real Point::sigma() const {
  const Real e = opening();
  if (e > 0) return secant() * e;
  return std::max(p_.kn * e, -crushing_strength());
}

// True if the joint has no strength left, without residual cohesion.
bool Point::crushed_out() const { return crushing_strength() == 0; }

Real Point::line() const {
  if (crushed_out()) return 0;
  const Real factor = strength_factor_shear();
  const Real cohesion = opening() > 0 ? p_.c0 * factor : p_.cr + (p_.c0 - p_.cr) * factor;
  const Real mu = mu0_ + (mur_ - mu0_) * (1 - factor);
  return cohesion - sigma() * mu;
}

Real Point::shear_strength() const { return std::max(Real(0), line()); }

Real Point::line_slope() const {
  if (crushed_out()) return 0;
  const Real slope = f_slope(xi_of_slip(), slip_complete());
  const bool open = opening() > 0;
  const Real factor = strength_factor_shear();
  const Real mu = mu0_ + (mur_ - mu0_) * (1 - factor);
  const Real by_cohesion = (open ? p_.c0 : p_.c0 - p_.cr) * slope;
  const Real by_friction = -sigma() * (mu0_ - mur_) * slope;
  const Real by_stress = open && p_.shared ? -mu * secant_slope() * opening() : 0;
  return by_cohesion + by_friction + by_stress;
}

void Point::soften_by_slip(Real slip) {
  if (su_ == 0) {  // no drop of cohesion: complete at the first slip
    (p_.shared ? complete_t_ : complete_s_) = true;
    return;
  }
  (p_.shared ? xi_t_ : xi_s_) += slip / su_;
}

// Updates all variables that depend on slip for a small slip at fixed d_n.
void Point::slide(Real slip, Real direction_s, Real direction_t) {
  const Real factor = strength_factor_shear();
  const Real mu = mu0_ + (mur_ - mu0_) * (1 - factor);
  const Real stress = sigma();
  const Real tau = std::hypot(tau_[0], tau_[1]);
  const bool open = opening() > 0;
  const Real secant_before = secant();
  tau_[0] -= p_.ks * slip * direction_s;
  tau_[1] -= p_.ks * slip * direction_t;
  soften_by_slip(slip);
  slip_ += slip;
  const Real uplift = open ? 0 : tan_psi_ * factor * slip;
  v_ += uplift;
  const Real pressure = std::max(Real(0), -stress);
  dissipated_[2] += pressure * (mu * slip - uplift);
  dissipated_[1] += (tau + std::hypot(tau_[0], tau_[1])) / 2 * slip - pressure * mu * slip;
  if (open && p_.shared) dissipated_[0] += (secant_before - secant()) * opening() * opening() / 2;
}

// Releases stress above the strength after a drop of strength: residual cohesion lost on opening, or a mode without
// softening that completes. Slips at fixed jumps until the excess is 0, in small explicit pieces.
void Point::relax(Real direction_s, Real direction_t) {
  constexpr int kPieces = 400;
  for (int i = 0; i < kPieces; ++i) {
    const Real excess = std::hypot(tau_[0], tau_[1]) - shear_strength();
    if (excess <= 0) return;
    const bool open = opening() > 0;
    const Real mu = mu0_ + (mur_ - mu0_) * (1 - strength_factor_shear());
    Real rate = p_.ks;
    if (line() > 0) {
      rate += su_ > 0 ? line_slope() / su_ : 0;
      if (!open) rate += mu * p_.kn * tan_psi_ * strength_factor_shear();
    }
    slide(excess / rate / (kPieces - i), direction_s, direction_t);
  }
}

void Point::advance(Real dn_end, Real ds_step, Real dt_step, int substeps) {
  const Real dn_start = dn_;
  for (int i = 0; i < substeps; ++i) {
    // Computed without summation, so that a path to zero ends exactly at zero, where the joint is closed.
    const Real next = i + 1 == substeps ? dn_end : dn_start + (dn_end - dn_start) * (i + 1) / substeps;
    const Real dn = next - dn_;
    substep(dn, ds_step / substeps, dt_step / substeps);
    dn_ = next;
    if (p_.ft == 0 && opening() > 0) complete_t_ = true;
    // Only for a drop of the strength, not for the drift of the explicit steps.
    const Real tau = std::hypot(tau_[0], tau_[1]);
    const Real drift = 20 * (p_.ks * std::hypot(ds_step, dt_step) / substeps + p_.kn * std::abs(dn));
    if (tau - shear_strength() > drift + 1e-9L * (p_.c0 + std::abs(sigma()))) relax(tau_[0] / tau, tau_[1] / tau);
  }
}

void Point::substep(Real dn, Real ds, Real dt) {
  const Real e = opening();
  const bool open = e > 0;
  const Real stress = sigma();
  const Real factor = strength_factor_shear();
  const Real mu = mu0_ + (mur_ - mu0_) * (1 - factor);
  const Real softening = line() > 0 && su_ > 0 ? line_slope() / su_ : 0;
  // At S = 0 the strength does not depend on sigma, unless growing pressure raises it.
  const Real friction = line() > 0 || (line() == 0 && dn < 0) ? mu : 0;

  // Direction of slip: that of the stress in the middle of the sub-step. For a stress below its increment in the
  // sub-step (strength near 0) it is the direction of sliding.
  const Real tau = std::hypot(tau_[0], tau_[1]);
  const bool follows = tau < 2 * p_.ks * std::hypot(ds, dt);
  Real direction_s = tau_[0] + p_.ks * ds * (follows ? 1 : Real(1) / 2);
  Real direction_t = tau_[1] + p_.ks * dt * (follows ? 1 : Real(1) / 2);
  const Real norm = std::hypot(direction_s, direction_t);
  if (norm > 0) direction_s /= norm, direction_t /= norm;
  const Real stretch = follows ? norm : tau + p_.ks * (direction_s * ds + direction_t * dt);
  const Real loading = stretch - shear_strength();

  if (open) {
    Real xi_step = 0;
    if (p_.ft == 0) {
      complete_t_ = true;
    } else if (!complete_t_) {
      xi_step = std::max(Real(0), (e + dn - u0_ - xi_t_ * lt_) / lt_);
    }
    const Real by_opening = friction * secant() * dn;  // decrease of strength by tension
    Real slip = 0;
    bool slip_drives = true;
    if (p_.shared) {
      const Real strength_step = line() > 0 ? line_slope() * xi_step : 0;
      slip = (loading + by_opening - strength_step) / p_.ks;
      slip_drives = su_ == 0 || slip / su_ > xi_step;
      if (slip_drives) slip = (loading + by_opening) / (p_.ks + softening);
    } else {
      const Real tension_step = friction * secant_slope() * e * xi_step;
      slip = (loading + by_opening + tension_step) / (p_.ks + softening);
    }
    slip = std::clamp(slip, Real(0), stretch / p_.ks);  // the strength cannot fall below 0
    const Real secant_before = secant();
    const Real tau_before = std::hypot(tau_[0], tau_[1]);
    tau_[0] += p_.ks * (ds - slip * direction_s);
    tau_[1] += p_.ks * (dt - slip * direction_t);
    slip_ += slip;
    dissipated_[1] += (tau_before + std::hypot(tau_[0], tau_[1])) / 2 * slip;
    if (p_.shared) {
      if (slip > 0 && slip_drives) {
        soften_by_slip(slip);
      } else {
        xi_t_ += xi_step;
      }
    } else {
      xi_t_ += xi_step;
      if (slip > 0) soften_by_slip(slip);
    }
    dissipated_[0] += (secant_before - secant()) * (e + dn / 2) * (e + dn / 2) / 2;
    return;
  }

  // Closed: crushing w' = -kn (d_n' - v')/(kn + F'), dilation v' = tan(psi0) f slip'.
  const Real dilation = tan_psi_ * factor;
  const bool can_crush = std::isfinite(p_.fc);
  const Real over = can_crush ? -p_.kn * e - crushing_strength() : 0;  // above the crushing strength
  const Real hardness = p_.kn + crushing_slope();
  const auto crush = [&](Real uplift) {
    if (!can_crush) return Real(0);
    // At most the crushing at which F = fcr, beyond which the slope of F is not valid and would open the joint.
    const Real most = -(e + dn - uplift) - p_.fcr / p_.kn;
    return std::clamp((over - p_.kn * (dn - uplift)) / hardness, Real(0), std::max(Real(0), most));
  };
  const auto slip_for = [&](bool crushing) {
    // sigma' = fixed + by_slip * slip'
    const Real fixed = p_.kn * (dn + (crushing ? (over - p_.kn * dn) / hardness : 0));
    const Real by_slip = p_.kn * dilation * (crushing ? p_.kn / hardness - 1 : -1);
    return std::clamp((loading + friction * fixed) / (p_.ks + softening - friction * by_slip), Real(0),
                      stretch / p_.ks);
  };
  bool crushing = crush(0) > 0;
  Real slip = slip_for(crushing);
  if ((crush(dilation * slip) > 0) != crushing) {
    crushing = !crushing;
    slip = slip_for(crushing);
  }
  const Real uplift = dilation * slip;
  const Real closure = crush(uplift);
  const Real tau_before = std::hypot(tau_[0], tau_[1]);
  const Real strength_before = can_crush ? crushing_strength() : 0;
  tau_[0] += p_.ks * (ds - slip * direction_s);
  tau_[1] += p_.ks * (dt - slip * direction_t);
  slip_ += slip;
  v_ += uplift;
  w_ += closure;
  if (slip > 0) soften_by_slip(slip);
  const Real stress_after =
      std::max(p_.kn * (e + dn + closure - uplift), can_crush ? -crushing_strength() : -HUGE_VALL);
  const Real pressure = (std::max(Real(0), -stress) + std::max(Real(0), -stress_after)) / 2;
  dissipated_[2] += pressure * (mu * slip - uplift);
  dissipated_[1] += (tau_before + std::hypot(tau_[0], tau_[1])) / 2 * slip - pressure * mu * slip;
  if (closure > 0) dissipated_[3] += (strength_before + crushing_strength()) / 2 * closure;
}

}  // namespace quoin::reference
