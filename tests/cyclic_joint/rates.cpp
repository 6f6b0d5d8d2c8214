#include "rates.h"

#include <algorithm>
#include <cmath>

namespace quoin::cyclic_rates {

namespace {

enum { kTension, kCohesion, kFriction, kCrushing };

// After every piece the flow removes the share kShare of the excess over a surface, kFlows times. The share is below 1,
// so that corrections for two active surfaces do not oscillate.
constexpr Real kShare = 0.5L;
constexpr int kFlows = 4;

Real length(const std::array<Real, 2>& a) { return std::hypot(a[0], a[1]); }

}  // namespace

Point::Point(const Parameters& parameters, bool dry) : p_(parameters), u0_(p_.ft / p_.kn), kappa_(u0_) {
  end_ = p_.softening.empty() ? std::numeric_limits<Real>::infinity() : p_.softening.back().first;
  if (p_.ft > 0) lt_ = (p_.G1 - p_.ft * u0_ / 2) / (p_.ft * area());
  if (p_.c0 > p_.cr) su_ = p_.G2 / ((p_.c0 - p_.cr) * area());
  if (std::isfinite(p_.fc) && p_.fc > p_.fcr) wu_ = p_.Gc / ((p_.fc - p_.fcr) * area());
  if (dry) xi_ = std::numeric_limits<Real>::infinity();
}

// ---- Functions ------------------------------------------------------------------------------------------------------

Real Point::f(Real xi) const {
  if (xi >= end_ || std::isinf(xi)) return 0;
  if (p_.softening.empty()) return std::exp(-xi);
  std::size_t k = 1;
  while (p_.softening[k].first <= xi) ++k;
  return p_.softening[k - 1].second + f_slope(xi) * (xi - p_.softening[k - 1].first);
}
Real Point::f_slope(Real xi) const {
  if (xi >= end_ || std::isinf(xi)) return 0;
  if (p_.softening.empty()) return -std::exp(-xi);
  std::size_t k = 1;
  while (p_.softening[k].first <= xi) ++k;
  const auto &a = p_.softening[k - 1], &b = p_.softening[k];
  return (b.second - a.second) / (b.first - a.first);
}
Real Point::area() const {
  if (p_.softening.empty()) return 1;
  Real sum = 0;
  for (std::size_t k = 1; k < p_.softening.size(); ++k) {
    const auto &a = p_.softening[k - 1], &b = p_.softening[k];
    sum += (b.first - a.first) * (a.second + b.second) / 2;
  }
  return sum;
}

Real Point::F(Real l) const {
  if (l < p_.wp) return p_.fy + (p_.fc - p_.fy) * (1 - (1 - l / p_.wp) * (1 - l / p_.wp));
  return wu_ > 0 ? p_.fcr + (p_.fc - p_.fcr) * f((l - p_.wp) / wu_) : p_.fc;
}
Real Point::F_slope(Real l) const {
  if (l < p_.wp) return 2 * (p_.fc - p_.fy) * (1 - l / p_.wp) / p_.wp;
  return wu_ > 0 ? (p_.fc - p_.fcr) * f_slope((l - p_.wp) / wu_) / wu_ : 0;
}

Real Point::uplift() const { return r_m_ > 0 ? v_m_ * std::min(Real(1), length(g_) / r_m_) : 0; }

Real Point::pressure() const { return std::max(Real(0), (q_ - e()) / C()); }

Real Point::sigma() const {
  const Real h = e() - q_;
  if (h <= 0) return -pressure();
  return p_.ft > 0 ? p_.ft * b() * f(xi_) / (kappa_ - q_) * h : 0;
}

// ---- Rates ----------------------------------------------------------------------------------------------------------

void Point::go(Real d_n, Real d_s, Real d_t, int pieces) {
  const Real from = d_n_;
  for (int i = 1; i <= pieces; ++i) {
    d_n_ = i == pieces ? d_n : from + (d_n - from) * i / pieces;
    tau_[0] += p_.ks * d_s / pieces;
    tau_[1] += p_.ks * d_t / pieces;
    for (int k = 0; k < kFlows; ++k) flow();
  }
}

void Point::flow() {
  if (e() - q_ > 0) {
    open_further();
    flow_open();
  } else {
    give_way();
    flow_closed();
  }
}

void Point::lose_bond(Real xi_more, bool complete) {
  xi_ = complete ? std::numeric_limits<Real>::infinity() : xi_ + xi_more;
}

// dkappa = de, dxi = de/lt, dq = beta f dkappa. The dissipation is -dpsi at fixed e.
void Point::open_further() {
  const Real further = e() - kappa_;
  if (further <= 0) return;
  kappa_ += further;
  if (p_.ft == 0) return lose_bond(0, true);
  const Real f0 = f(xi_), width = kappa_ - q_, stays = p_.beta * f0 * further;
  lose_bond(further / lt_, false);
  q_ += stays;
  dissipated_[kTension] += p_.ft * b() * (f0 * (further + stays) + (f0 - f(xi_)) * width) / 2;
}

// The residual opening decreases where the pressure exceeds ft.
void Point::give_way() {
  if (q_ == 0 || pressure() <= p_.ft) return;
  const Real rest = std::max(Real(0), p_.ft * C() + e());
  dissipated_[kTension] += p_.ft * (q_ - rest);
  q_ = rest;
}

// dxi = (T/c0) dgamma/su; the seat does not move.
void Point::flow_open() {
  const Real tau = length(tau_), h = e() - q_, f0 = f(xi_);
  const Real s0 = p_.ft > 0 ? p_.ft * h / (kappa_ - q_) : 0;
  const Real T = std::max(Real(0), p_.c0 - p_.mu0 * s0);
  const Real excess = tau - b() * f0 * T;
  if (!(excess > 0)) return;
  const Real rate = su_ > 0 ? T / (p_.c0 * su_) : 0;
  const Real gamma = kShare * excess / (p_.ks + b() * T * f_slope(xi_) * rate);
  dissipated_[kCohesion] += (tau - p_.ks * gamma / 2) * gamma;
  for (Real& component : tau_) component *= 1 - p_.ks * gamma / tau;
  lose_bond(rate * gamma, su_ == 0);
  dissipated_[kTension] += b() * s0 * h * (f0 - f(xi_)) / 2;
  slip_ += gamma;
}

Real Point::seat_slope(const std::array<Real, 2>& n) const {
  const Real r = length(g_), along = r > 0 ? (g_[0] * n[0] + g_[1] * n[1]) / r : 1;
  if (r < r_m_ || along < 0) return r_m_ > 0 ? along * v_m_ / r_m_ : 0;
  if (p_.tan_psi == 0) return 0;
  return along * p_.tan_psi * f(r / p_.sd) * std::max(Real(0), 1 - pressure() / p_.pd);
}

// dg = dgamma along tau; a falling seat stops where the pressure is 0.
void Point::move_seat(Real gamma, const std::array<Real, 2>& n) {
  const std::array<Real, 2> from = g_;
  const auto move = [&](Real share) {
    for (int k = 0; k < 2; ++k) g_[k] = from[k] + share * gamma * n[k];
  };
  const Real p = pressure();
  move(1);
  const Real beyond = length(g_) - r_m_;
  if (beyond > 0 && p_.tan_psi > 0) {
    v_m_ += p_.tan_psi * f(r_m_ / p_.sd) * std::max(Real(0), 1 - p / p_.pd) * beyond;
    r_m_ += beyond;
  } else if (e() > q_) {
    Real closed = 0, open = 1;
    for (int k = 0; k < 64; ++k) {
      const Real middle = (closed + open) / 2;
      move(middle);
      (e() > q_ ? open : closed) = middle;
    }
    move(closed);
  }
}

// Slip along tau, dxi = dgamma/su. Crushing with dgamma_c = dl Cs tau/F, dw = dl p (1/F - chi/(2 fc)); N replaces F, to
// which it is equal on the cap. Both are computed from the same traction.
void Point::flow_closed() {
  const Real tau = length(tau_), p = pressure(), f0 = f(xi_), mu_drop = p_.mu0 - p_.mur;
  const Real mu = p_.mur + mu_drop * f0, c = p_.cr + (p_.c0 - p_.cr) * b() * f0;
  const std::array<Real, 2> n = tau > 0 ? std::array<Real, 2>{tau_[0] / tau, tau_[1] / tau} : std::array<Real, 2>{1, 0};

  Real gamma = 0, dl = 0, flow_c = 0, dw = 0;
  const Real excess = tau - c - mu * p;
  if (excess > 0) {
    const Real softening = su_ > 0 ? (mu_drop * p + (p_.c0 - p_.cr) * b()) * f_slope(xi_) / su_ : 0;
    gamma = kShare * excess / (p_.ks + softening + mu * seat_slope(n) / C());
  }
  const Real N = std::sqrt(p * p + p_.Cs * tau * tau), over = N - F(l_);
  if (over > 0) {
    const Real half_chi = p_.chi / (2 * p_.fc);
    const Real fall = p * p * (1 / N + half_chi) / (C() * N) + p_.Cs * p_.Cs * p_.ks * tau * tau / (N * N);
    dl = kShare * over / (fall + F_slope(l_));
    flow_c = dl * p_.Cs * tau / N;
    dw = dl * p * (1 / N - half_chi);
    dissipated_[kCrushing] += (F(l_) + F(l_ + dl)) / 2 * dl;
  }

  if (gamma > 0) {
    const Real v = uplift();
    move_seat(gamma, n);
    const Real rubbed = p * (mu * gamma - (uplift() - v));
    dissipated_[kFriction] += rubbed;
    // A friction that is lost at the first slip leaves tau above the strength.
    dissipated_[kCohesion] += (su_ == 0 ? tau - p_.ks * gamma / 2 - mu * p : c) * gamma;
    lose_bond(su_ > 0 ? gamma / su_ : 0, su_ == 0);
    slip_ += gamma;
  }
  l_ += dl, w_ += dw;
  for (int k = 0; k < 2; ++k) tau_[k] -= p_.ks * (gamma + flow_c) * n[k];
}

}  // namespace quoin::cyclic_rates
