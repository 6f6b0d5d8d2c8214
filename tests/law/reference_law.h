// An independent implementation of contact_models/fracture_energy/LAW.md in long double, for tests only. It integrates
// the rate equations of the law explicitly, in at least 1000 sub-steps for each increment. It has no return mapping, no
// equation of the end state and no code of contact_models. It is of first order in the sub-step and exact nowhere, so
// that it does not repeat errors of the law.
#pragma once

#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace quoin::reference {

using Real = long double;

enum class Shape { linear, exponential, table };

struct Parameters {
  Real kn = 0, ks = 0;
  Real ft = 0, c0 = 0, cr = 0;
  Real phi0 = 0, phir = 0, psi0 = 0;  // deg
  Real fc = std::numeric_limits<Real>::infinity(), fcr = 0;
  Real G1 = 0, G2 = 0, Gc = 0;
  Shape shape = Shape::linear;
  std::vector<std::pair<Real, Real>> table;
  bool shared = true;
};

class Point {
 public:
  Point(const Parameters& parameters, bool dry);

  // Computes one increment with the inputs of the law: total d_n at its end, slip increment; in equal sub-steps.
  void advance(Real dn_end, Real ds_step, Real dt_step, int substeps);

  Real sigma() const;
  Real tau_s() const { return tau_[0]; }
  Real tau_t() const { return tau_[1]; }
  Real strength_factor_tension() const { return f(xi_t_, complete_t_); }
  Real strength_factor_shear() const { return p_.shared ? strength_factor_tension() : f(xi_s_, complete_s_); }
  Real w() const { return w_; }
  Real v() const { return v_; }
  Real slip() const { return slip_; }
  Real shear_strength() const;
  // Energies since the start, J/m2: tension, cohesion, friction, crushing.
  const std::array<Real, 4>& dissipated() const { return dissipated_; }

 private:
  struct Softened {  // at the current state
    Real strength, cohesion_slope, friction, friction_slope;
  };
  Real f(Real xi, bool complete) const;
  Real f_slope(Real xi, bool complete) const;
  Real secant() const;        // sigma/e while open
  Real secant_slope() const;  // derivative of secant by xi
  Real opening() const;       // e
  Real crushing_strength() const;
  Real crushing_slope() const;
  bool crushed_out() const;
  bool slip_complete() const { return p_.shared ? complete_t_ : complete_s_; }
  Real xi_of_slip() const { return p_.shared ? xi_t_ : xi_s_; }
  Real line() const;        // Coulomb's line, which may be negative
  Real line_slope() const;  // derivative of line by the xi of slip, including the dependence of sigma
  void soften_by_slip(Real slip);
  void substep(Real dn, Real ds, Real dt);
  void relax(Real direction_s, Real direction_t);
  void slide(Real slip, Real direction_s, Real direction_t);

  Parameters p_;
  Real mu0_, mur_, tan_psi_, u0_, lt_ = 0, su_ = 0, wu_ = 0;
  Real dn_ = 0, xi_t_ = 0, xi_s_ = 0, w_ = 0, v_ = 0, slip_ = 0;
  bool complete_t_ = false, complete_s_ = false;  // shared coupling: complete_t_ is that of both modes
  std::array<Real, 2> tau_{};
  std::array<Real, 4> dissipated_{};
};

}  // namespace quoin::reference
