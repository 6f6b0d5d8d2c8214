#include "page_update.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace quoin::cyclic {

namespace {

constexpr Real kEpsilon = 2.220446049250313e-16L;  // of double, as in the law
constexpr Real kExponentialEnd = 746;

Real tangent_of(Real degrees) { return std::tan(degrees * std::numbers::pi_v<Real> / 180); }

// Returns the largest number of [low, high] at which a falling function is positive.
Real root(Real low, Real high, const std::function<Real(Real)>& falling) {
  for (int i = 0; i < 400; ++i) {
    const Real middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) break;
    (falling(middle) > 0 ? low : high) = middle;
  }
  return high;
}

}  // namespace

// ---- Parameters and functions ---------------------------------------------------------------------------------------

Real Joint::end() const {
  if (shape == Shape::linear) return 1;
  return shape == Shape::exponential ? kExponentialEnd : table.back().first;
}
Real Joint::f(Real xi) const {
  if (xi >= end()) return 0;
  if (shape == Shape::linear) return 1 - xi;
  if (shape == Shape::exponential) return std::exp(-xi);
  for (std::size_t k = 1; k < table.size(); ++k) {
    const auto [x0, f0] = table[k - 1];
    const auto [x1, f1] = table[k];
    if (xi < x1) return f0 + (f1 - f0) * (xi - x0) / (x1 - x0);
  }
  return 0;
}
Real Joint::area(Real from, Real to) const {
  to = std::min(to, end());
  if (from >= to) return 0;
  if (shape == Shape::linear) return (to - from) * (f(from) + f(to)) / 2;
  if (shape == Shape::exponential) return std::exp(-from) * -std::expm1(from - to);
  Real sum = 0;
  for (std::size_t k = 1; k < table.size(); ++k) {
    // No structured bindings, since clang 14 does not capture them in lambdas.
    const Real x0 = table[k - 1].first, f0 = table[k - 1].second, x1 = table[k].first, f1 = table[k].second;
    const Real a = std::max(from, x0), b = std::min(to, x1);
    const auto line = [&](Real x) { return f0 + (f1 - f0) * (x - x0) / (x1 - x0); };
    if (a < b) sum += (b - a) * (line(a) + line(b)) / 2;
  }
  return sum;
}
Real Joint::steepest() const {
  Real m = shape == Shape::table ? 0 : 1;
  for (std::size_t k = 1; k < table.size() && shape == Shape::table; ++k) {
    m = std::max(m, (table[k - 1].second - table[k].second) / (table[k].first - table[k - 1].first));
  }
  return m;
}
bool Joint::crushes() const { return std::isfinite(fc); }
Real Joint::mu0() const { return tangent_of(phi0); }
Real Joint::mur() const { return tangent_of(phir); }
Real Joint::tan_psi() const { return tangent_of(psi0); }
Real Joint::u0() const { return ft / kn; }
Real Joint::lt() const { return ft > 0 ? (G1 - ft * u0() / 2) / (ft * total_area()) : 0; }
Real Joint::su() const { return c0 > cr ? G2 / ((c0 - cr) * total_area()) : 0; }
Real Joint::wu() const { return crushes() && fc > fcr ? Gc / ((fc - fcr) * total_area()) : 0; }
Real Joint::dilation_length() const { return sd < 0 ? su() : sd; }
Real Joint::yield() const { return fy < 0 ? fc : fy; }
Real Joint::F(Real l) const {
  if (!crushes()) return fc;
  if (l < wp) return yield() + (fc - yield()) * (l / wp) * (2 - l / wp);
  return fc == fcr ? fc : fcr + (fc - fcr) * f((l - wp) / wu());
}
Real Joint::F_area(Real from, Real to) const {
  Real sum = 0;
  if (from < wp) {
    const Real a = from / wp, b = std::min(to, wp) / wp;
    sum += wp * (yield() * (b - a) + (fc - yield()) * ((b * b - a * a) - (b * b * b - a * a * a) / 3));
  }
  const Real a = std::max(from, wp), b = std::max(to, wp);
  sum += fcr * (b - a);
  return fc == fcr ? sum : sum + (fc - fcr) * wu() * area((a - wp) / wu(), (b - wp) / wu());
}
Real Joint::compliance(Real l) const { return 1 / kn + (crushes() ? chi * l / fc : 0); }
Real Joint::bond(Real l) const { return crushes() && l > wp ? F(l) / fc : 1; }

History initial(const Joint& joint, bool dry) {
  History s;
  s.kappa = joint.u0();
  s.xi = dry ? joint.end() : 0;
  return s;
}

Real uplift(const History& s) { return s.r_m > 0 ? s.v_m * std::min(Real(1), std::hypot(s.g[0], s.g[1]) / s.r_m) : 0; }

// ---- The update -----------------------------------------------------------------------------------------------------

Outcome update(const Joint& j, History& s, Real d_n, Real d_s, Real d_t) {
  s.kappa = std::max(s.kappa, j.u0());  // kappa of a bonded joint is 0 in the law
  Outcome out;
  const Real v0 = uplift(s);
  const Real e = d_n + s.w - v0;
  Real h = e - s.q;
  out.open = h > 0;
  const Real trial[2] = {s.tau[0] + j.ks * d_s, s.tau[1] + j.ks * d_t};
  const Real t = std::hypot(trial[0], trial[1]), t_old = std::hypot(s.tau[0], s.tau[1]);
  const Real n[2] = {t > 0 ? trial[0] / t : 0, t > 0 ? trial[1] / t : 0};
  const Real reach = j.kn * (std::abs(d_n) + s.w + v0 + s.q);
  const auto beyond = [&](Real excess, Real strength) {
    return excess > 8 * kEpsilon * std::max({strength, reach, t});
  };
  const Real su = j.su(), f_old = j.f(s.xi);
  const bool brittle = j.c0 <= j.cr;  // the first slip completes xi
  Real tau = t;

  if (out.open) {  // steps 1 and 2
    const Real b = j.bond(s.l);
    const Real f0 = j.f(s.xi), secant0 = s.kappa - s.q;
    bool completes = false;
    Real passed = 0;
    if (beyond(j.kn * (e - s.kappa), j.ft)) {
      if (j.ft > 0) {
        const Real xi = s.xi + (e - s.kappa) / j.lt();
        passed = j.area(s.xi, xi);
        s.q += j.beta * j.lt() * passed;
        s.xi = xi;
      } else {
        completes = f0 > 0;
        s.xi = std::max(s.xi, j.end());
      }
      s.kappa = e;
      h = e - s.q;
    }
    const Real xi1 = s.xi, f1 = j.f(xi1);
    const Real s0 = j.ft > 0 ? j.ft * h / (s.kappa - s.q) : 0;
    const Real T = std::max(Real(0), j.c0 - j.mu0() * s0);
    const Real B = b * f1;
    out.dissipated[0] = b * j.ft * (j.lt() * passed + (f0 * secant0 - f1 * (s.kappa - s.q)) / 2);
    if (beyond(t - B * T, B * T)) {
      if (brittle) {
        out.gamma = t / j.ks;
        completes = completes || f1 > 0;
        s.xi = std::max(s.xi, j.end());
      } else if (T > 0) {
        const Real rate = T / (j.c0 * su);
        out.gamma = root(0, t / j.ks, [&](Real x) { return t - j.ks * x - b * T * j.f(xi1 + rate * x); });
        s.xi += rate * out.gamma;
      } else {
        out.gamma = t / j.ks;
      }
      const Real f2 = j.f(s.xi);
      tau = b * T * f2;
      out.dissipated[0] += b * s0 * h * (f1 - f2) / 2;
      if (!brittle) out.dissipated[1] = b * j.c0 * su * j.area(xi1, s.xi);
      const Real held = std::min(t_old, t);
      const Real x = completes ? held : std::max(Real(0), std::min(j.cr * (1 - B), held - B * T));
      out.dissipated[1] += x * x / (2 * j.ks);
    }
    out.sigma = b * j.f(s.xi) * s0;
    out.h = h;
    out.stored = out.sigma * h / 2;
  } else {  // steps 3, 4 and 5
    const Real C0 = j.compliance(s.l), F0 = j.F(s.l), b0 = j.bond(s.l);
    const auto p_of = [&](Real y) {
      const Real bare = std::max(Real(0), (y + s.q) / C0);
      return bare <= j.ft || s.q == 0 ? bare : std::max(j.ft, y / C0);
    };
    const Real g_n = s.g[0] * n[0] + s.g[1] * n[1];
    Real stop = std::numeric_limits<Real>::infinity();
    if (s.v_m > 0 && g_n < 0 && d_n + s.w > s.q) {
      const Real seat = s.r_m * (d_n + s.w - s.q) / s.v_m;
      const Real under = g_n * g_n - (s.g[0] * s.g[0] + s.g[1] * s.g[1]) + seat * seat;
      if (under >= 0) stop = std::max(Real(0), -g_n - std::sqrt(under));
    }
    const auto radius = [&](Real gamma) {
      const Real x = std::min(gamma, stop);
      return std::hypot(s.g[0] + x * n[0], s.g[1] + x * n[1]);
    };
    const auto v_of = [&](Real gamma) {
      const Real r = radius(gamma);
      if (r <= s.r_m) return s.r_m > 0 ? s.v_m * r / s.r_m : Real(0);
      if (j.tan_psi() == 0) return s.v_m;
      const Real sd = j.dilation_length();
      const Real X = j.tan_psi() * sd * j.area(s.r_m / sd, r / sd);
      const Real p0 = p_of(s.v_m - d_n - s.w);
      return s.v_m + X * std::max(Real(0), 1 - p0 / j.pd) / (1 + X / (C0 * j.pd));
    };
    const auto y_of = [&](Real gamma) { return v_of(gamma) - (d_n + s.w); };
    const auto f_of = [&](Real gamma) {
      if (brittle) return gamma > 0 ? Real(0) : f_old;
      return j.f(s.xi + gamma / su);
    };
    const auto mu_of = [&](Real gamma) { return j.mur() + (j.mu0() - j.mur()) * f_of(gamma); };
    const auto strength = [&](Real gamma) {
      return j.cr + (j.c0 - j.cr) * b0 * f_of(gamma) + mu_of(gamma) * std::min(p_of(y_of(gamma)), F0);
    };
    Real gamma_A = 0;
    if (beyond(t - strength(0), strength(0))) {
      gamma_A = root(0, t / j.ks, [&](Real x) { return t - j.ks * x - strength(x); });
    }

    struct Crushed {
      Real D, p, tau, w, J;
    };
    const auto crush = [&](Real gamma) {
      Crushed c{0, p_of(y_of(gamma)), t - j.ks * gamma, 0, 0};
      const Real p = c.p, T1 = c.tau, N = std::sqrt(p * p + j.Cs * T1 * T1);
      Real a = F0, k = F0, l = s.l;
      if (j.crushes() && beyond(N - F0, F0)) {
        const auto a_of = [&](Real D) {
          return (j.F(s.l + D) * j.compliance(s.l + D) + D - j.chi / (2 * j.fc) * j.F_area(s.l, s.l + D)) / C0;
        };
        const auto k_of = [&](Real D) { return j.F(s.l + D) + j.ks * j.Cs * D; };
        c.D = root(0, N * C0 / (1 - j.chi / 2),
                   [&](Real D) { return (p / a_of(D)) * (p / a_of(D)) + j.Cs * (T1 / k_of(D)) * (T1 / k_of(D)) - 1; });
        l = s.l + c.D, a = a_of(c.D), k = k_of(c.D);
        c.p = p * j.F(l) / a;
        c.tau = T1 * j.F(l) / k;
        c.w = p / a * (c.D - j.chi / (2 * j.fc) * j.F_area(s.l, l));
      }
      if (j.crushes()) {
        const Real F1 = j.F(l), b_over_F = l > j.wp ? 1 / j.fc : 1 / F1;
        c.J = T1 / k - (j.cr > 0 ? j.cr / F1 : 0) - (j.c0 - j.cr) * f_of(gamma) * b_over_F - mu_of(gamma) * p / a;
      }
      return c;
    };
    Real gamma = gamma_A;
    Crushed c = crush(gamma);
    if (c.D > 0 && gamma_A > 0) {
      gamma = crush(0).J <= 0 ? 0 : root(0, gamma_A, [&](Real x) { return crush(x).J; });
      c = crush(gamma);
    }

    const Real y = y_of(gamma);
    Real q = s.q;
    if ((y + s.q) / C0 > j.ft && s.q > 0) q = std::max(Real(0), j.ft * C0 - y);
    out.dissipated[0] = j.ft * (s.q - q);
    const Real l1 = s.l + c.D, r1 = radius(gamma), v1 = v_of(gamma);
    if (gamma > 0) {
      const Real xi1 = brittle ? std::max(s.xi, j.end()) : s.xi + gamma / su;
      const Real softened = brittle ? 0 : su * j.area(s.xi, xi1);
      out.dissipated[1] = j.cr * gamma + (j.c0 - j.cr) * j.bond(l1) * softened;
      Real p_mean = c.p;
      if (brittle && s.xi < j.end()) {
        const Real p0 = p_of(y_of(0)), held = std::min(p0, F0);
        const Real x = (j.mu0() - j.mur()) * f_old * held;
        const Real rise = j.mur() * (std::min(p_of(y_of(gamma)), F0) - held) / gamma;
        out.dissipated[1] += x * x / (2 * (j.ks + rise));
        if (c.D == 0) p_mean = (p0 + c.p) / 2;
      }
      out.dissipated[2] = p_mean * (j.mur() * gamma + (j.mu0() - j.mur()) * softened - (v1 - v0));
      s.xi = xi1;
      const Real x = std::min(gamma, stop);
      for (int k = 0; k < 2; ++k) s.g[k] += x * n[k];
      if (r1 > s.r_m && j.tan_psi() > 0) s.r_m = r1, s.v_m = v1;
    }
    out.dissipated[3] = j.F_area(s.l, l1);
    s.q = q;
    s.l = l1;
    s.w += c.w;
    tau = c.tau;
    out.gamma = gamma;
    out.sigma = -c.p;
    out.h = d_n + s.w - uplift(s) - s.q;
    out.stored = c.p * c.p * j.compliance(s.l) / 2;
  }
  for (int k = 0; k < 2; ++k) s.tau[k] = tau * n[k];
  out.stored += tau * tau / (2 * j.ks);
  return out;
}

}  // namespace quoin::cyclic
