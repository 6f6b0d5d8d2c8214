#include "joints.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace quoin::cyclic {

double test_scale() {
  const char* text = std::getenv("QUOIN_TEST_SCALE");
  return text == nullptr ? 1.0 : std::atof(text);
}

Joint mortar() {
  Joint j;
  j.kn = 82e9, j.ks = 36e9, j.ft = 0.2e6, j.c0 = 0.3e6, j.phi0 = j.phir = 35;
  j.fc = 5e6, j.fcr = 0.5e6, j.G1 = 15, j.G2 = 125, j.Gc = 8000;
  j.beta = 0.3L, j.pd = 1.5e6, j.psi0 = 15, j.fy = 5e6L / 3, j.wp = 0.09e-3L, j.chi = 0.5L;
  return j;
}

bool admissible(const Joint& j) {
  const Real P = j.crushes() ? j.fc : 0, su = j.su(), wu = j.wu(), m = j.steepest();
  Real moment = j.shape == Shape::exponential ? std::exp(Real(-1)) : Real(1);
  if (j.shape == Shape::table) {
    moment = 0;
    for (std::size_t k = 1; k < j.table.size(); ++k) {
      const auto [x0, f0] = j.table[k - 1];
      const auto [x1, f1] = j.table[k];
      moment = std::max(moment, x1 * (f0 - f1) / (x1 - x0));
    }
  }
  const Real softening = j.c0 > j.cr ? m * std::max(j.c0, j.c0 - j.cr + P * (j.mu0() - j.mur())) / su : 0;
  if (j.ft > 0 && !(j.lt() > 0)) return false;
  if (j.c0 > j.cr && !(su > 0)) return false;
  if (j.ks <= softening + j.mu0() * j.kn * j.tan_psi()) return false;
  if (j.crushes()) {
    if (j.fc > j.fcr && !(wu > 0)) return false;
    const Real drop = j.fc - j.fcr;
    if (drop > 0 && drop * (m * (1 / j.kn + j.chi * j.wp / j.fc) / wu + j.chi * moment / j.fc) >= 1) return false;
    if (j.ks * j.Cs < (1 + j.chi) * j.kn) return false;
    if (j.yield() < j.fc && !(j.wp > 0)) return false;
  }
  if (j.psi0 > j.phir || j.phir > j.phi0 || j.cr > j.c0 || j.fcr > j.fc) return false;
  return !(j.psi0 > 0) || j.dilation_length() > 0;
}

Joint random_joint(Random& random, double margin, double spread) {
  const auto size = [&](double low, double high) { return log_uniform(random, low / spread, high * spread); };
  for (;;) {
    Joint j;
    j.kn = size(1e9, 1e12);
    j.ks = j.kn * uniform(random, 0.2, 1.5);
    j.ft = chance(random, 0.1) ? 0.0 : size(2e4, 2e6);
    j.c0 = chance(random, 0.1) ? 0.0 : size(3e4, 3e6);
    j.cr = chance(random, 0.5) ? 0.0L : chance(random, 0.1) ? j.c0 : j.c0 * uniform(random, 0.05, 0.6);
    j.phi0 = chance(random, 0.05) ? 0.0 : uniform(random, 5.0, 50.0);
    j.phir = chance(random, 0.5) ? j.phi0 : j.phi0 * uniform(random, 0.4, 1.0);
    if (chance(random, 0.6)) j.psi0 = j.phir * uniform(random, 0.05, 0.9);
    if (chance(random, 0.5)) j.sd = size(1e-5, 1e-2);
    const double strength = static_cast<double>(std::max(j.ft, j.c0)) + 1e4;
    if (chance(random, 0.8)) {
      j.fc = strength * log_uniform(random, 2.0, 30.0);
      j.fcr = chance(random, 0.3) ? 0.0L : chance(random, 0.1) ? j.fc : j.fc * uniform(random, 0.02, 0.7);
      if (chance(random, 0.5)) {
        j.wp = size(1e-6, 1e-3);
        if (chance(random, 0.8)) j.fy = j.fc * uniform(random, 0.1, 1.0);
      }
      if (chance(random, 0.5)) j.chi = uniform(random, 0.0, 0.95);
      j.Cs = (1 + j.chi) * j.kn / j.ks * (chance(random, 0.2) ? 1.0 : log_uniform(random, 1.0, 10.0)) * 1.0000001L;
    }
    if (chance(random, 0.5)) j.pd = strength * log_uniform(random, 0.1, 30.0);
    if (chance(random, 0.6)) j.beta = chance(random, 0.1) ? 1.0 : uniform(random, 0.0, 1.0);
    const double shape = uniform(random, 0.0, 1.0);
    j.shape = shape < 0.4 ? Shape::linear : shape < 0.7 ? Shape::exponential : Shape::table;
    if (j.shape == Shape::table) {
      const int points = 2 + static_cast<int>(uniform(random, 0.0, 4.0));
      j.table = {{0.0L, 1.0L}};
      double x = 0.0, y = 1.0;
      for (int i = 1; i < points; ++i) {
        x += uniform(random, 0.1, 0.6);
        y = i + 1 == points ? 0.0 : y * uniform(random, 0.2, 0.8);
        j.table.emplace_back(x, y);
      }
    }
    const Real A = j.total_area(), m = j.steepest();
    const auto above = [&](Real bound) { return bound * (margin + log_uniform(random, 0.01, 30.0)); };
    j.G1 = above(j.ft * j.ft / j.kn / 2);
    // Without a cap the refusals do not bound the pressure under which friction softens. Here the bound is the largest
    // pressure of the tests, including uplift.
    const Real P = j.crushes() ? j.fc : 4 * normal_scale(j), left = j.ks - j.mu0() * j.kn * j.tan_psi();
    if (left <= 0.02L * j.ks) continue;
    j.G2 = above(m * std::max(j.c0, j.c0 - j.cr + P * (j.mu0() - j.mur())) * (j.c0 - j.cr) * A / left);
    if (j.crushes()) {
      const Real loss = j.fc - j.fcr;
      j.Gc = above(m * loss * loss * A * (1 / j.kn + j.chi * j.wp / j.fc));
      if (j.chi > 0) j.Gc *= 2 / (1 - j.chi);
    }
    // Parameters are rounded to double, as in the law.
    for (Real Joint::*number :
         {&Joint::kn,   &Joint::ks,  &Joint::ft, &Joint::c0, &Joint::cr,  &Joint::phi0, &Joint::phir,
          &Joint::psi0, &Joint::fcr, &Joint::fc, &Joint::G1, &Joint::G2,  &Joint::Gc,   &Joint::beta,
          &Joint::sd,   &Joint::pd,  &Joint::fy, &Joint::wp, &Joint::chi, &Joint::Cs}) {
      j.*number = static_cast<double>(j.*number);
    }
    if (admissible(j)) return j;
  }
}

quoin::test::Values values_of(const Joint& j) {
  quoin::test::Values v;
  const auto add = [&](const char* id, Real value) { v.numbers.emplace_back(id, static_cast<double>(value)); };
  add("normal_stiffness", j.kn), add("shear_stiffness", j.ks), add("tensile_strength", j.ft), add("cohesion", j.c0);
  add("cohesion_residual", j.cr), add("friction_angle", j.phi0), add("friction_angle_residual", j.phir);
  add("dilation_angle", j.psi0), add("compressive_strength", j.fc), add("compressive_strength_residual", j.fcr);
  add("fracture_energy_tension", j.G1), add("fracture_energy_shear", j.G2), add("fracture_energy_compression", j.Gc);
  add("residual_opening", j.beta), add("dilation_pressure", j.pd), add("compressive_peak_closure", j.wp);
  add("crushing_recovery", j.chi), add("cap_shear", j.Cs);
  if (j.sd >= 0) add("dilation_length", j.sd);
  if (j.fy >= 0) add("compressive_yield", j.fy);
  const char* shapes[] = {"linear", "exponential", "table"};
  v.words = {{"softening", shapes[static_cast<int>(j.shape)]}};
  for (const auto& [x, y] : j.table) {
    v.table.push_back(static_cast<double>(x));
    v.table.push_back(static_cast<double>(y));
  }
  return v;
}

std::string text_of(const Joint& joint) {
  const quoin::test::Values v = values_of(joint);
  std::string text;
  char digits[64];
  for (const auto& [id, value] : v.numbers) {
    std::snprintf(digits, sizeof digits, "%.17g", value);
    text += " --set " + id + "=" + digits;
  }
  text += " --set softening=" + v.words[0].second;
  for (std::size_t k = 0; k < v.table.size(); k += 2) {
    std::snprintf(digits, sizeof digits, "%.17g:%.17g", v.table[k], v.table[k + 1]);
    text += (k == 0 ? " --set softening_table=" : ",") + std::string(digits);
  }
  return text;
}

double normal_scale(const Joint& j) {
  return static_cast<double>(std::max(j.ft, j.crushes() ? j.fc : 4 * (j.c0 + j.ft + 1e5L)));
}
double shear_scale(const Joint& j) { return static_cast<double>(j.c0 + j.mu0() * normal_scale(j)) + 1e3; }

Reach reach_of(const Joint& j) {
  const Real end = j.shape == Shape::exponential ? 6 : j.end();
  const Real elastic = shear_scale(j) / j.ks;
  Reach r;
  r.open = static_cast<double>(j.ft > 0 ? j.u0() + 1.2L * end * j.lt() : 1e-5L);
  r.close = static_cast<double>(normal_scale(j) / j.kn + (j.crushes() ? j.wp + 0.8L * end * j.wu() : 0));
  r.slide = static_cast<double>(j.su() > 0 ? 1.2L * end * j.su() + 0.2L * elastic : 3 * elastic + 1e-7L);
  return r;
}

cyclic_rates::Parameters rates_of(const Joint& j) {
  cyclic_rates::Parameters p{j.kn, j.ks, j.ft,   j.c0, j.cr, j.mu0(), j.mur(), j.tan_psi(), j.fc, j.fcr,  j.G1,
                             j.G2, j.Gc, j.beta, j.sd, j.pd, j.fy,    j.wp,    j.chi,       j.Cs, j.table};
  if (j.sd < 0) p.sd = j.su();
  if (j.fy < 0) p.fy = j.fc;
  if (j.shape == Shape::linear) p.softening = {{0, 1}, {1, 0}};
  return p;
}

Surfaces beyond_surfaces(const Joint& j, const History& s, double sigma, double tau, double d_n, double trial) {
  const Real v = uplift(s), h = d_n + s.w - v - s.q, B = j.bond(s.l) * j.f(s.xi), f = j.f(s.xi);
  // Includes the seat: a rounding error of g changes the uplift by tan(psi0) times the error.
  const Real reach = j.kn * (std::abs(d_n) + s.w + v + s.q + j.tan_psi() * std::hypot(s.g[0], s.g[1]));
  const double scale = static_cast<double>(std::max({j.ft, j.c0, reach, static_cast<Real>(trial)}));
  if (std::abs(h) < 1e-15L * reach / j.kn) return {0.0, scale};
  const double p = std::max(0.0, -sigma);
  if (h > 0) {
    const Real s0 = j.ft > 0 ? j.ft * h / (std::max(s.kappa, j.u0()) - s.q) : 0;
    return {std::max(static_cast<double>(sigma - j.ft * B),
                     static_cast<double>(tau - B * std::max(Real(0), j.c0 - j.mu0() * s0))),
            scale};
  }
  const Real mu = j.mur() + (j.mu0() - j.mur()) * f;
  double over = static_cast<double>(tau - (j.cr + (j.c0 - j.cr) * B + mu * p));
  if (j.crushes())
    over = std::max(over, std::sqrt(p * p + static_cast<double>(j.Cs) * tau * tau) - static_cast<double>(j.F(s.l)));
  if (s.q > 0) over = std::max(over, static_cast<double>(p - j.ft));
  return {over, scale};
}

const char* beyond_bounds(const Joint& j, const History& s) {
  if (s.q > j.beta * j.total_area() * j.lt() * (1 + 1e-12L)) return "q > beta A lt";
  if (s.v_m > j.tan_psi() * j.dilation_length() * j.total_area() * (1 + 1e-9L)) return "v_m > tan(psi0) sd A";
  if (std::max(s.kappa, j.u0()) - s.q < j.u0() * (1 - 1e-12L)) return "K > kn";
  return nullptr;
}

LawPoints::LawPoints(const quoin_law& law, const Joint& joint, std::size_t count, bool dry)
    : material(test::make_material(law, values_of(joint))), batch(law, count) {
  const std::vector<double> start = material.initial_state(dry ? "dry" : "bonded");
  for (std::size_t k = 0; k < start.size(); ++k) batch.in[6 + k].assign(count, start[k]);
}

History LawPoints::history(std::size_t i) const {
  const auto in = [&](std::size_t k) { return static_cast<Real>(batch.in[k][i]); };
  return {in(6), in(7), in(8), in(9), in(10), {in(11), in(12)}, in(13), in(14), {in(4), in(5)}};
}

}  // namespace quoin::cyclic
