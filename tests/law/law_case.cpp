#include "law_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace quoin::test {

namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

PropertySetting number(const char* id, long double value) { return {id, {static_cast<double>(value)}, {}, {}}; }

}  // namespace

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

double log_uniform(Random& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}

std::string law_under_test() {
  const char* name = std::getenv("QUOIN_TEST_LAW");
  return name == nullptr ? "fracture_energy" : name;
}

double test_scale() {
  const char* text = std::getenv("QUOIN_TEST_SCALE");
  return text == nullptr ? 1.0 : std::max(1e-3, std::atof(text));
}

std::vector<PropertySetting> Case::settings() const {
  std::vector<PropertySetting> result = {number("normal_stiffness", p.kn),
                                         number("shear_stiffness", p.ks),
                                         number("tensile_strength", p.ft),
                                         number("cohesion", p.c0),
                                         number("cohesion_residual", p.cr),
                                         number("friction_angle", p.phi0),
                                         number("friction_angle_residual", p.phir),
                                         number("dilation_angle", p.psi0),
                                         number("compressive_strength", p.fc),
                                         number("compressive_strength_residual", p.fcr),
                                         number("fracture_energy_tension", p.G1),
                                         number("fracture_energy_shear", p.G2),
                                         number("fracture_energy_compression", p.Gc),
                                         {"coupling", {}, p.shared ? "shared" : "none", {}}};
  const char* shapes[] = {"linear", "exponential", "table"};
  result.push_back({"softening", {}, shapes[static_cast<int>(p.shape)], {}});
  if (p.shape == reference::Shape::table) {
    PropertySetting table{"softening_table", {}, {}, {}};
    for (const auto& [x, y] : p.table) {
      table.numbers.push_back(static_cast<double>(x));
      table.numbers.push_back(static_cast<double>(y));
    }
    result.push_back(table);
  }
  return result;
}

std::shared_ptr<const Material> Case::material() const {
  static const Law law = Law::find(law_under_test());
  return std::make_shared<const Material>(law, settings());
}

MaterialPoint Case::point() const { return MaterialPoint(material(), dry ? "dry" : "bonded"); }

std::string Case::text() const {
  std::string result = dry ? "dry" : "bonded";
  for (const PropertySetting& setting : settings()) {
    result += fmt::format(" --set {}=", setting.id);
    if (setting.numbers.size() == 1) {
      result += fmt::format("{:.17g}", setting.numbers[0]);
    } else if (setting.numbers.empty()) {
      result += setting.text;
    } else {
      for (std::size_t i = 0; i < setting.numbers.size(); i += 2) {
        result += fmt::format("{}{:.17g}:{:.17g}", i == 0 ? "" : ",", setting.numbers[i], setting.numbers[i + 1]);
      }
    }
  }
  return result;
}

double Case::area() const {
  if (p.shape == reference::Shape::linear) return 0.5;
  if (p.shape == reference::Shape::exponential) return 1.0;
  long double sum = 0;
  for (std::size_t i = 1; i < p.table.size(); ++i) {
    sum += (p.table[i].first - p.table[i - 1].first) * (p.table[i].second + p.table[i - 1].second) / 2;
  }
  return static_cast<double>(sum);
}

double Case::max_slope() const {
  if (p.shape != reference::Shape::table) return 1.0;
  long double m = 0;
  for (std::size_t i = 1; i < p.table.size(); ++i) {
    m = std::max(m, (p.table[i - 1].second - p.table[i].second) / (p.table[i].first - p.table[i - 1].first));
  }
  return static_cast<double>(m);
}

double Case::u0() const { return static_cast<double>(p.ft / p.kn); }
double Case::lt() const {
  return p.ft > 0 ? static_cast<double>((p.G1 - p.ft * p.ft / p.kn / 2) / (p.ft * area())) : 0.0;
}
double Case::su() const { return p.c0 > p.cr ? static_cast<double>(p.G2 / ((p.c0 - p.cr) * area())) : 0.0; }
double Case::wu() const {
  return std::isfinite(p.fc) && p.fc > p.fcr ? static_cast<double>(p.Gc / ((p.fc - p.fcr) * area())) : 0.0;
}
double Case::end() const {
  if (p.shape == reference::Shape::linear) return 1.0;
  if (p.shape == reference::Shape::exponential) return 8.0;
  return static_cast<double>(p.table.back().first);
}
double Case::f(double xi) const {
  if (p.shape == reference::Shape::linear) return std::max(0.0, 1.0 - xi);
  if (p.shape == reference::Shape::exponential) return std::exp(-xi);
  for (std::size_t i = 1; i < p.table.size(); ++i) {
    const double x0 = static_cast<double>(p.table[i - 1].first), y0 = static_cast<double>(p.table[i - 1].second);
    const double x1 = static_cast<double>(p.table[i].first), y1 = static_cast<double>(p.table[i].second);
    if (xi < x1) return y0 + (y1 - y0) * (xi - x0) / (x1 - x0);
  }
  return 0.0;
}
double Case::mu0() const { return std::tan(radians(static_cast<double>(p.phi0))); }
double Case::mur() const { return std::tan(radians(static_cast<double>(p.phir))); }
double Case::tan_psi() const { return std::tan(radians(static_cast<double>(p.psi0))); }

double Case::nearness() const {
  double result = 0.0;
  const double m = max_slope();
  const double q = wu() > 0.0 ? m * static_cast<double>((p.fc - p.fcr) / p.kn) / wu() : 0.0;
  // While the joint crushes, uplift by dilation reduces the pressure, so that S falls with slip by that, too.
  if (q < 1.0) result = mu0() * tan_psi() * static_cast<double>(p.kn / p.ks) * q / (1.0 - q);
  if (su() > 0.0) {
    const double P = std::isfinite(p.fc) ? static_cast<double>(p.fc) : -static_cast<double>(p.kn) * -closing_range();
    const double drop = std::max(static_cast<double>(p.c0), static_cast<double>(p.c0 - p.cr) + P * (mu0() - mur()));
    result += m * drop / (su() * static_cast<double>(p.ks));
  }
  return std::max(result, q);
}

double Case::opening_range() const { return p.ft > 0 ? u0() + 1.2 * end() * lt() : 1e-5; }
double Case::closing_range() const {
  if (!std::isfinite(p.fc)) return 4.0 * static_cast<double>(std::max(p.c0, p.ft) + 1e5L) / static_cast<double>(p.kn);
  return static_cast<double>(p.fc / p.kn) + (wu() > 0 ? 0.8 * end() * wu() : static_cast<double>(p.fc / p.kn));
}
double Case::sliding_range() const {
  const double elastic =
      (static_cast<double>(p.c0) + mu0() * static_cast<double>(p.kn) * std::min(closing_range(), 1e-3)) /
      static_cast<double>(p.ks);
  return su() > 0 ? 1.2 * end() * su() + 0.2 * elastic : 3.0 * elastic + 1e-7;
}
double Case::normal_scale() const {
  const double crushing = std::isfinite(p.fc) ? static_cast<double>(p.fc) : static_cast<double>(p.kn) * closing_range();
  return std::max(static_cast<double>(p.ft), crushing);
}
double Case::shear_scale() const { return static_cast<double>(p.c0) + mu0() * normal_scale(); }
double Case::fall_by_uplift() const {
  if (!(p.fc > p.fcr) || !std::isfinite(p.fc)) return 0.0;
  const double loss = static_cast<double>(p.fc - p.fcr), kn = static_cast<double>(p.kn);
  const double q = max_slope() * loss / (wu() * kn);
  return kn * mu0() * std::tan(static_cast<double>(p.psi0) * (std::numbers::pi / 180.0)) * q / (1.0 - q);
}
double Case::shear_strength(double e, double sigma, double xi) const {
  const double D = 1.0 - f(xi);
  const double c0 = static_cast<double>(p.c0), cr = static_cast<double>(p.cr);
  const double c = e > 0.0 ? c0 * (1.0 - D) : cr + (c0 - cr) * (1.0 - D);
  return std::max(0.0, c - sigma * (mu0() + (mur() - mu0()) * D));
}

Case mortar() {
  Case c;
  c.p.kn = 82e9;
  c.p.ks = 36e9;
  c.p.ft = 0.16e6;
  c.p.c0 = 0.224e6;
  c.p.cr = 0;
  c.p.phi0 = c.p.phir = 36.86989764584402;  // mu = 0.75
  c.p.fc = 11.5e6;
  c.p.fcr = 1e6;
  c.p.G1 = 12;
  c.p.G2 = 50;
  c.p.Gc = 8000;
  return c;
}

namespace {

Case any_case(Random& random, double margin) {
  const auto chance = [&](double probability) { return uniform(random, 0.0, 1.0) < probability; };
  Case c;
  c.p.kn = log_uniform(random, 1e9, 1e12);
  c.p.ks = c.p.kn * uniform(random, 0.2, 1.0);
  c.p.ft = chance(0.1) ? 0.0 : log_uniform(random, 2e4, 2e6);
  c.p.c0 = chance(0.1) ? 0.0 : log_uniform(random, 3e4, 3e6);
  if (chance(0.4)) c.p.cr = c.p.c0 * uniform(random, 0.05, 0.6);
  if (chance(0.05)) c.p.cr = c.p.c0;
  c.p.phi0 = uniform(random, 5.0, 50.0);
  c.p.phir = chance(0.5) ? c.p.phi0 : c.p.phi0 * uniform(random, 0.4, 1.0);
  if (chance(0.5)) c.p.psi0 = c.p.phi0 * uniform(random, 0.05, 0.6);
  const double strength = static_cast<double>(std::max(c.p.ft, c.p.c0)) + 1e4;
  if (chance(0.7)) {
    c.p.fc = strength * log_uniform(random, 2.0, 30.0);
    c.p.fcr = chance(0.3) ? 0.0L : c.p.fc * uniform(random, 0.02, 0.7);
    if (chance(0.1)) c.p.fcr = c.p.fc;
  }
  const double shape = uniform(random, 0.0, 1.0);
  c.p.shape = shape < 0.4   ? reference::Shape::linear
              : shape < 0.7 ? reference::Shape::exponential
                            : reference::Shape::table;
  if (c.p.shape == reference::Shape::table) {
    const int points = 2 + static_cast<int>(uniform(random, 0.0, 4.0));
    c.p.table = {{0.0L, 1.0L}};
    double x = 0.0, y = 1.0;
    for (int i = 1; i < points; ++i) {
      x += uniform(random, 0.1, 0.6);
      y = i + 1 == points ? 0.0 : y * uniform(random, 0.2, 0.8);
      c.p.table.emplace_back(x, y);
    }
  }
  c.p.shared = chance(0.6);
  c.dry = chance(0.1);
  // Energies are above their bounds. With infinite fc the bound depends on the largest pressure of the path.
  const double A = c.area(), m = c.max_slope();
  const auto above = [&](double bound) { return bound * (margin + log_uniform(random, 0.01, 30.0)); };
  c.p.G1 = above(static_cast<double>(c.p.ft * c.p.ft / c.p.kn / 2));
  const double P =
      std::isfinite(c.p.fc) ? static_cast<double>(c.p.fc) : static_cast<double>(c.p.kn) * c.closing_range();
  const double drop = static_cast<double>(c.p.c0 - c.p.cr);
  c.p.G2 = above(m * std::max(static_cast<double>(c.p.c0), drop + P * (c.mu0() - c.mur())) * drop * A /
                 static_cast<double>(c.p.ks));
  if (std::isfinite(c.p.fc)) {
    const double loss = static_cast<double>(c.p.fc - c.p.fcr);
    c.p.Gc = above(m * loss * loss * A / static_cast<double>(c.p.kn));
    // The fall of S by uplift is kept below ks/2, so that the margin of G2 is effective.
    while (c.fall_by_uplift() > 0.5 * static_cast<double>(c.p.ks)) c.p.Gc *= 2;
    c.p.G2 /= 1.0 - c.fall_by_uplift() / static_cast<double>(c.p.ks);
  }
  return c;
}

}  // namespace

Case random_case(Random& random, double margin) {
  for (;;) {
    const Case c = any_case(random, margin);
    if (c.nearness() < 0.9) return c;
  }
}

std::vector<Jump> random_path(const Case& c, Random& random, int corners) {
  std::vector<Jump> path;
  Jump at{0.0, 0.0, 0.0};
  const double slide = c.sliding_range();
  for (int i = 0; i < corners; ++i) {
    const double kind = uniform(random, 0.0, 1.0);
    if (kind < 0.30) {
      at.dn = uniform(random, 0.0, 1.0) * c.opening_range() * (kind < 0.15 ? 0.3 : 1.0);
    } else if (kind < 0.65) {
      at.dn = -uniform(random, 0.0, 1.0) * c.closing_range() * (kind < 0.5 ? 0.2 : 1.0);
    } else if (kind < 0.75) {
      at.dn = 0.0;  // a corner exactly at zero
    }
    if (uniform(random, 0.0, 1.0) < 0.7) {
      const double angle = uniform(random, 0.0, 2.0 * std::numbers::pi);
      const double length = slide * uniform(random, 0.02, 0.5);
      at.ds += length * std::cos(angle);
      at.dt += length * std::sin(angle);
    }
    path.push_back(at);
  }
  return path;
}

int substeps_between(const Case& c, const Jump& from, const Jump& to, int refinement) {
  const double per_length = 400.0 * refinement;
  const double most = 40000.0 * refinement;
  double normal = HUGE_VAL, shear = HUGE_VAL;
  for (const double length : {c.u0(), c.lt(), c.wu()}) {
    if (length > 0.0) normal = std::min(normal, length);
  }
  if (c.su() > 0.0) shear = c.su();
  const double steps =
      per_length * std::max(std::abs(to.dn - from.dn) / normal, std::hypot(to.ds - from.ds, to.dt - from.dt) / shear);
  return static_cast<int>(std::clamp(steps, 1000.0 * refinement, most));
}

}  // namespace quoin::test
