// An independent implementation of contact_models/cyclic_joint/LAW.md ("ORDER of the update", "Energies"), for tests
// only. One point, long double, every root by bisection, no closed forms, no code of contact_models.
#pragma once

#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace quoin::cyclic {

using Real = long double;

enum class Shape { linear, exponential, table };

// Parameters with the symbols of the law's page, SI, angles in degrees. sd < 0: equal to su.
struct Joint {
  Real kn = 0, ks = 0, ft = 0, c0 = 0, cr = 0, phi0 = 0, phir = 0, psi0 = 0;
  Real fc = std::numeric_limits<Real>::infinity(), fcr = 0, G1 = 0, G2 = 0, Gc = 0;
  Real beta = 0, sd = -1, pd = std::numeric_limits<Real>::infinity();
  Real fy = -1, wp = 0, chi = 0, Cs = 9;  // fy < 0: equal to fc
  Shape shape = Shape::linear;
  std::vector<std::pair<Real, Real>> table;

  Real f(Real xi) const;
  Real area(Real from, Real to) const;  // integral of f
  Real end() const;                     // xi from which f = 0
  Real total_area() const { return area(0, end()); }
  Real steepest() const;  // max |f'|
  bool crushes() const;
  Real mu0() const, mur() const, tan_psi() const;
  Real u0() const, lt() const, su() const, wu() const;
  Real dilation_length() const, yield() const;
  Real F(Real l) const, F_area(Real from, Real to) const;
  Real compliance(Real l) const;  // C
  Real bond(Real l) const;        // b
};

struct History {
  Real xi = 0, kappa = 0, q = 0, l = 0, w = 0, g[2] = {0, 0}, r_m = 0, v_m = 0, tau[2] = {0, 0};
};
History initial(const Joint& joint, bool dry);

struct Outcome {
  Real sigma = 0, gamma = 0, h = 0;
  bool open = false;
  Real stored = 0;
  std::array<Real, 4> dissipated{};  // tension, cohesion, friction, crushing
};

Real uplift(const History& state);
// Computes one step: d_n at its end, slip (d_s, d_t) during it. Updates state to the end of the step.
Outcome update(const Joint& joint, History& state, Real d_n, Real d_s, Real d_t);

}  // namespace quoin::cyclic
