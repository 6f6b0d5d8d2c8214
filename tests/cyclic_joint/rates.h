// Integration of the rate equations of contact_models/cyclic_joint/LAW.md ("Free energy", "Surfaces", "Evolution"), for
// tests only: one point, long double. Jumps grow in small pieces. After each, slip and crushing flow along the
// directions of the law's page by a share of the excess over the surfaces, a few times. It solves no step and is
// independent of "ORDER of the update", of the law's code and of its other tests. It is of first order in the piece.
#pragma once

#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace quoin::cyclic_rates {

using Real = long double;

// Symbols of the law's page, SI; friction and dilation as tangents; softening by points, or exponential without points.
struct Parameters {
  Real kn, ks, ft, c0, cr, mu0, mur, tan_psi;
  Real fc, fcr, G1, G2, Gc;
  Real beta, sd, pd, fy, wp, chi, Cs;  // sd > 0 where tan_psi > 0
  std::vector<std::pair<Real, Real>> softening;
};

class Point {
 public:
  Point(const Parameters& parameters, bool dry);

  // Moves to the normal jump d_n with slip (d_s, d_t), in a straight line of equal pieces.
  void go(Real d_n, Real d_s, Real d_t, int pieces);

  Real sigma() const;
  const std::array<Real, 2>& tau() const { return tau_; }
  Real bond() const { return f(xi_); }  // f
  Real residual_opening() const { return q_; }
  Real crushing() const { return l_; }
  Real closure() const { return w_; }
  Real uplift() const;
  Real slip() const { return slip_; }
  const std::array<Real, 4>& dissipated() const { return dissipated_; }  // tension, cohesion, friction, crushing

 private:
  Real f(Real xi) const;
  Real f_slope(Real xi) const;
  Real area() const;
  Real F(Real l) const;
  Real F_slope(Real l) const;
  Real C() const { return 1 / p_.kn + p_.chi * l_ / p_.fc; }
  Real b() const { return l_ > p_.wp ? F(l_) / p_.fc : Real(1); }
  Real e() const { return d_n_ + w_ - uplift(); }
  Real pressure() const;
  Real seat_slope(const std::array<Real, 2>& n) const;  // dv/dgamma for slip along n
  void open_further();
  void give_way();
  void flow();
  void flow_open();
  void flow_closed();
  void move_seat(Real gamma, const std::array<Real, 2>& n);
  void lose_bond(Real xi_more, bool complete);

  Parameters p_;
  Real u0_, lt_ = 0, su_ = 0, wu_ = 0, end_;
  Real d_n_ = 0, xi_ = 0, kappa_, q_ = 0, l_ = 0, w_ = 0, r_m_ = 0, v_m_ = 0, slip_ = 0;
  std::array<Real, 2> g_{}, tau_{};
  std::array<Real, 4> dissipated_{};
};

}  // namespace quoin::cyclic_rates
