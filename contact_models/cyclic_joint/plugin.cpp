// The cyclic joint law behind the C ABI: metadata, refused properties (LAW.md, "Refused"), migration.
#include "shim/plugin.h"

#include <algorithm>
#include <cmath>

#include "cyclic_joint/kernel.h"
#include "shim/softening_property.h"

namespace quoin::cyclic_joint {
namespace {
using namespace quoin::shim;

constexpr std::uint32_t kColumn = QUOIN_PROPERTY_PER_POINT;
constexpr std::uint32_t kFinite = QUOIN_PROPERTY_UPPER_OPEN;
constexpr std::uint32_t kPositive = QUOIN_PROPERTY_LOWER_OPEN;
constexpr std::uint32_t kStiffness = QUOIN_PROPERTY_REQUIRED | kColumn | kPositive | kFinite;

constexpr quoin_property_info number(const char* id, const char* symbol, const char* unit, const char* text,
                                     double value = 0.0, const char* from = nullptr) {
  return number_property(id, symbol, unit, text, kColumn | kFinite, value, 0.0, kInfinity, from);
}
constexpr quoin_property_info angle(const char* id, const char* symbol, const char* text, const char* from = nullptr) {
  return number_property(id, symbol, "deg", text, kColumn | kFinite, 0.0, 0.0, 90.0, from);
}

constexpr quoin_property_info kKn =
    number_property("normal_stiffness", "kn", "Pa/m", "elastic normal stiffness", kStiffness, 0.0, 0.0, kInfinity);
constexpr quoin_property_info kKs =
    number_property("shear_stiffness", "ks", "Pa/m", "elastic shear stiffness", kStiffness, 0.0, 0.0, kInfinity);
constexpr quoin_property_info kFt = number("tensile_strength", "ft", "Pa", "tensile strength");
constexpr quoin_property_info kC0 = number("cohesion", "c0", "Pa", "cohesion");
constexpr quoin_property_info kCr =
    number("cohesion_residual", "cr", "Pa", "residual cohesion, while the joint is closed");
constexpr quoin_property_info kPhi0 = angle("friction_angle", "phi0", "friction angle, mu0 = tan(phi0)");
constexpr quoin_property_info kPhir =
    angle("friction_angle_residual", "phir", "friction angle at full damage", "friction_angle");
constexpr quoin_property_info kPsi0 =
    angle("dilation_angle", "psi0", "dilation angle at first slip without pressure, at most phir");
constexpr quoin_property_info kFc =
    number_property("compressive_strength", "fc", "Pa", "compressive strength; infinite: no crushing",
                    kColumn | kPositive, kInfinity, 0.0, kInfinity);
constexpr quoin_property_info kFcr =
    number("compressive_strength_residual", "fcr", "Pa", "residual compressive strength");
constexpr quoin_property_info kG1 =
    number("fracture_energy_tension", "G1", "J/m2", "total area under the tension curve; needed when ft > 0");
constexpr quoin_property_info kG2 = number("fracture_energy_shear", "G2", "J/m2",
                                           "work above residual and friction over the slip; needed when c0 > cr");
constexpr quoin_property_info kGc = number("fracture_energy_compression", "Gc", "J/m2",
                                           "work above fcr beyond the peak; needed when fc is finite and > fcr");
constexpr quoin_property_info kBeta = number_property(
    "residual_opening", "beta", "-", "share of the softening opening that stays", kColumn, 0.0, 0.0, 1.0);
constexpr quoin_property_info kSd =
    number("dilation_length", "sd", "m", "slip over which dilation is used up; 0: su = G2/((c0 - cr) A)");
constexpr quoin_property_info kPd = number_property("dilation_pressure", "pd", "Pa", "pressure at which dilation is 0",
                                                    kColumn | kPositive, kInfinity, 0.0, kInfinity);
constexpr quoin_property_info kFy =
    number_property("compressive_yield", "fy", "Pa", "pressure at which crushing starts, at most fc",
                    kColumn | kPositive, 0.0, 0.0, kInfinity, "compressive_strength");
constexpr quoin_property_info kWp = number("compressive_peak_closure", "wp", "m", "crushing at fc; > 0 when fy < fc");
constexpr quoin_property_info kChi = number_property(
    "crushing_recovery", "chi", "-", "growth of compliance with crushing, times fc", kColumn | kFinite, 0.0, 0.0, 1.0);
constexpr quoin_property_info kCs =
    number_property("cap_shear", "Cs", "-", "cap p^2 + Cs tau^2 = F^2; at least (1 + chi) kn/ks",
                    kColumn | kPositive | kFinite, 9.0, 0.0, kInfinity);

constexpr quoin_state_info history(const char* id, const char* unit, const char* text, std::uint32_t flags) {
  return scalar_state(id, unit, text, QUOIN_ROLE_HISTORY, flags, 0.0, kInfinity);
}
constexpr quoin_state_info seat(const char* id, const char* text, std::uint32_t kind) {
  return {sizeof(quoin_state_info), id, "m", text, QUOIN_ROLE_HISTORY, kind, 0, 0, -kInfinity, kInfinity};
}
constexpr quoin_state_info kXiInfo = history("xi", "-", "bond damage", QUOIN_STATE_MONOTONIC);
constexpr quoin_state_info kKappaInfo =
    history("kappa", "m", "opening reached; below u0 = ft/kn it counts as u0", QUOIN_STATE_MONOTONIC);
constexpr quoin_state_info kQInfo = history("q", "m", "residual opening", 0);
constexpr quoin_state_info kLInfo = history("l", "m", "crushing", QUOIN_STATE_MONOTONIC);
constexpr quoin_state_info kWInfo = history("w", "m", "closure by crushing that stays", QUOIN_STATE_MONOTONIC);
constexpr quoin_state_info kGsInfo = seat("g_s", "position of the faces on their seat", QUOIN_STATE_PAIR_S);
constexpr quoin_state_info kGtInfo = seat("g_t", "position of the faces on their seat", QUOIN_STATE_PAIR_T);
constexpr quoin_state_info kRmInfo = history("r_m", "m", "farthest from the seat", QUOIN_STATE_MONOTONIC);
constexpr quoin_state_info kVmInfo = history("v_m", "m", "uplift there", QUOIN_STATE_MONOTONIC);
constexpr quoin_state_info kSlipInfo =
    scalar_state("slip", "m", "accumulated slip", QUOIN_ROLE_DIAGNOSTIC, QUOIN_STATE_MONOTONIC, 0.0, kInfinity);

struct Lengths {
  double u0, lt, su, wu;
};
Lengths lengths(const Parameters& m) {
  const Properties& g = m.given;
  const double u0 = g.ft / g.kn;
  return {u0, g.ft > 0.0 ? (g.G1 - 0.5 * g.ft * u0) / (g.ft * m.A) : 0.0,
          g.c0 > g.cr ? g.G2 / ((g.c0 - g.cr) * m.A) : 0.0,
          std::isfinite(g.fc) && g.fc > g.fcr ? g.Gc / ((g.fc - g.fcr) * m.A) : 0.0};
}

double crushing_strength(const Parameters& m, double l) {  // F
  const Properties& g = m.given;
  if (!std::isfinite(g.fc)) return g.fc;
  if (l < g.wp) return g.fy + (g.fc - g.fy) * (l / g.wp) * (2.0 - l / g.wp);
  return g.fc > g.fcr ? g.fcr + (g.fc - g.fcr) * m.factor((l - g.wp) / lengths(m).wu) : g.fc;
}

// Returns the largest f + k xi |f'| over xi.
double most_of_bond(const Parameters& m, double k) {
  if (m.shape == Shape::linear) return std::max(1.0, k);
  if (m.shape == Shape::exponential) return k > 1.0 ? k * std::exp(1.0 / k - 1.0) : 1.0;
  const shim::SofteningTable& t = m.table;
  double most = 1.0;
  for (int i = 1; i < t.points; ++i) {
    const double fall = k * (t.f[i - 1] - t.f[i]) / (t.x[i] - t.x[i - 1]);
    most = std::max({most, t.f[i - 1] + t.x[i - 1] * fall, t.f[i] + t.x[i] * fall});
  }
  return most;
}
// Longest slip of one step, over su, for which the bound on the normal stiffness holds where ft mu0 is near or above
// c0.
constexpr double kLongestSlip = 4.0;

// Checks LAW.md, "Refused": order of strengths and angles, and a unique solution of every step.
void check_admissible(const Parameters& m, const PropertyValues& values, Report& report) {
  const Properties& g = m.given;
  const auto fault = [&](const char* id, const std::string& why) {
    report.faults.push_back(std::string(id) + " = " + to_text(values.number(id)) + ": " + why);
  };
  const auto not_above = [&](const char* id, const char* limit, const char* why = "") {
    if (values.number(id) > values.number(limit)) {
      fault(id, std::string("must not exceed ") + limit + " = " + to_text(values.number(limit)) + why);
    }
  };
  not_above("cohesion_residual", "cohesion");
  not_above("friction_angle_residual", "friction_angle");
  not_above("compressive_strength_residual", "compressive_strength");
  not_above("compressive_yield", "compressive_strength");
  not_above("dilation_angle", "friction_angle_residual", ": a worn joint would create energy");

  const Lengths length = lengths(m);
  const bool crushes = std::isfinite(g.fc);
  const double drop = g.c0 - g.cr, friction_drop = g.mu0 - g.mur;
  if (g.tan_psi > 0.0 && !(g.sd > 0.0) && !(length.su > 0.0)) {
    fault("dilation_length",
          "must be > 0 m when dilation_angle > 0 and cohesion_residual = cohesion, which leaves no su");
  }
  if (crushes && g.fy < g.fc && !(g.wp > 0.0)) {
    fault("compressive_peak_closure", "must be > 0 m when compressive_yield is below compressive_strength");
  }

  const auto snaps_back = [&](const char* id, double bound, const char* why) {
    fault(id, "the joint would snap back; must be greater than " + to_text(bound) + " J/m2 (" + why +
                  "); raise it, or lower the strength or raise the stiffness");
  };
  const double lowest_G1 = 0.5 * g.ft * g.ft / g.kn;
  if (g.ft > 0.0 && !(g.G1 > lowest_G1)) snaps_back("fracture_energy_tension", lowest_G1, "ft^2/(2 kn)");

  const double P = crushes ? g.fc : 0.0;
  const double by_uplift = g.mu0 * g.kn * g.tan_psi;
  if (!(g.ks > by_uplift)) {
    fault("shear_stiffness", "must be greater than mu0 kn tan(psi0) = " + to_text(by_uplift) +
                                 " Pa/m, or the falling seat leaves more than one answer; raise it, or lower the "
                                 "dilation_angle, the friction_angle or the normal_stiffness");
  } else if (drop > 0.0) {
    const double steepest = std::max(g.c0, drop + P * friction_drop);
    const double lowest_G2 = m.slope * steepest * drop * m.A / (g.ks - by_uplift);
    if (!(g.G2 > lowest_G2)) {
      snaps_back("fracture_energy_shear", lowest_G2,
                 "m max(c0, c0 - cr + P (mu0 - mur)) (c0 - cr) A/(ks - mu0 kn tan(psi0)), P = fc");
    } else if (!crushes && friction_drop > 0.0) {
      const double confinement = (g.G2 * (g.ks - by_uplift) / (drop * m.A) / m.slope - drop) / friction_drop;
      report.warnings.push_back("friction_angle_residual: softening of friction is unstable beyond a confinement of " +
                                to_text(confinement) + " Pa; give compressive_strength, or keep the confinement below");
    }
  }
  if (crushes && g.fc > g.fcr) {
    // (fc - fcr)(m (1/kn + chi wp/fc)/wu + chi M/fc) < 1, for Gc
    const double loss = g.fc - g.fcr;
    const double by_compliance = loss * g.chi * m.moment / g.fc;
    const double lowest_Gc =
        loss * loss * m.A * m.slope * (1.0 / g.kn + g.chi * g.wp / g.fc) / std::max(0.0, 1.0 - by_compliance);
    if (!(g.Gc > lowest_Gc)) {
      snaps_back("fracture_energy_compression", lowest_Gc,
                 "m (fc - fcr)^2 A (1/kn + chi wp/fc)/(1 - (fc - fcr) chi M/fc), M = max xi |f'|");
    }
  }
  if (crushes && !(g.ks * g.Cs >= (1.0 + g.chi) * g.kn)) {
    fault("cap_shear", "must be at least (1 + chi) kn/ks = " + to_text((1.0 + g.chi) * g.kn / g.ks));
  }
  if (g.ft * g.mu0 > g.c0) {
    report.warnings.push_back("tensile_strength: ft tan(phi0) = " + to_text(g.ft * g.mu0) + " Pa exceeds cohesion = " +
                              to_text(g.c0) + " Pa; the shear strength is 0 before ft is reached");
  }
  if (crushes && g.c0 * std::sqrt(g.Cs) > g.fc) {
    report.warnings.push_back("cap_shear: cohesion sqrt(Cs) = " + to_text(g.c0 * std::sqrt(g.Cs)) +
                              " Pa exceeds compressive_strength = " + to_text(g.fc) +
                              " Pa; shear crushes the joint before it slips");
  }
}

struct CyclicJointLaw {
  using Material = cyclic_joint::Material;
  static constexpr const char* id = "cyclic_joint";
  static constexpr const char* name = "Cyclic joint";
  static constexpr const char* citation = "LAW.md beside the law (share/quoin/laws/cyclic_joint)";
  static constexpr const char* description =
      "One bond damage by the energy spent in any mode, residual opening, elliptical cap, dilation that comes back.";
  static constexpr std::uint64_t capabilities = QUOIN_CAN_ENERGY | QUOIN_CAN_TANGENT | QUOIN_CAN_PROPERTY_COLUMNS |
                                                QUOIN_CAN_FLAGS | QUOIN_CAN_MIGRATE | QUOIN_CAN_DAMAGE;
  // The first kPropertyColumnCount in the order of PropertyColumn.
  static constexpr std::array<const quoin_property_info*, 22> properties = {
      &kKn, &kKs, &kFt,   &kC0, &kCr, &kPhi0, &kPhir, &kPsi0, &kFc, &kFcr,       &kG1,
      &kG2, &kGc, &kBeta, &kSd, &kPd, &kFy,   &kWp,   &kChi,  &kCs, &kSoftening, &kTable};
  static constexpr std::array<const quoin_state_info*, kStateCount> states = {
      &kXiInfo, &kKappaInfo, &kQInfo, &kLInfo, &kWInfo, &kGsInfo, &kGtInfo, &kRmInfo, &kVmInfo, &kSlipInfo};
  static constexpr std::array<const char*, 2> initial_states = {"bonded", "dry"};

  static Material make(const PropertyValues& values, Report& report) {
    const auto tangent = [&](const char* property) { return std::tan(values.number(property) * (M_PI / 180.0)); };
    Material material{};
    Parameters& m = material.parameters;
    m.given = {values.number("normal_stiffness"),
               values.number("shear_stiffness"),
               values.number("tensile_strength"),
               values.number("cohesion"),
               values.number("cohesion_residual"),
               tangent("friction_angle"),
               tangent("friction_angle_residual"),
               tangent("dilation_angle"),
               values.number("compressive_strength"),
               values.number("compressive_strength_residual"),
               values.number("fracture_energy_tension"),
               values.number("fracture_energy_shear"),
               values.number("fracture_energy_compression"),
               values.number("residual_opening"),
               values.number("dilation_length"),
               values.number("dilation_pressure"),
               values.number("compressive_yield"),
               values.number("compressive_peak_closure"),
               values.number("crushing_recovery"),
               values.number("cap_shear")};
    m.own_mur = values.is_given("friction_angle_residual"), m.own_fy = values.is_given("compressive_yield");
    if (read_softening(values, m, report)) check_admissible(m, values, report);
    choose_kernels(material);
    return material;
  }

  static bool initial_state(const Material& material, std::string_view state, double* values) {
    if (state != "bonded" && state != "dry") return false;
    const Parameters& m = material.parameters;
    std::fill(values, values + kStateCount, 0.0);
    if (state == "dry") values[kXi] = m.end;
    return true;
  }

  // closed: a higher pressure reduces the slip down a falling seat. open: a wider opening reduces the bond lost by
  // slip. LAW.md, "Stiffness bounds".
  static void stiffness_bounds(const Material& material, double& normal, double& shear) {
    const Parameters& m = material.parameters;
    const Properties& g = m.given;
    const double drop = g.c0 - g.cr, P = std::isfinite(g.fc) ? g.fc : 0.0;
    const double su = lengths(m).su;
    const double softening = drop > 0.0 ? m.slope * std::max(g.c0, drop + P * (g.mu0 - g.mur)) / su : 0.0;
    const double closed = 1.0 / (1.0 - g.mu0 * g.kn * g.tan_psi / (g.ks - softening));
    double open = 1.0;
    if (drop > 0.0) {
      const double z = std::min(1.0, g.ft * g.mu0 / g.c0), left = 1.0 - z;
      const double rate = z / (1.0 - m.slope * g.c0 / (g.ks * su) * left * left);
      open = std::min(most_of_bond(m, rate / left), 1.0 + m.slope * kLongestSlip * rate);
    }
    normal = g.kn * std::max(closed, open);
    shear = g.ks;
  }

  static void evaluate(const Material& material, const Columns& columns, std::size_t count, Summary& summary) {
    const Kernel kernel = columns.extras ? material.full : material.lean;
    kernel(material, columns, count, summary);
  }

  static void evaluate_one(const Material& material, const Columns& columns, Summary& summary) {
    material.one(material, columns, 1, summary);
  }

  // Keeps the traction: h is chosen so that sigma(h) equals the normal stress. A point whose traction is outside the
  // strength that its history leaves gets status FAILED. A joint that a brittle law has failed becomes unbonded. From a
  // law without a seat: the faces are seated at their current position, and plastic closure becomes crushing beyond the
  // peak. Damage of bond_slip has no counterpart: CLAMPED.
  static void migrate(const Material& material, const MigrationPoint& from, MigrationResult& to) {
    const Parameters& m = material.parameters;
    const Properties& g = m.given;
    const Lengths length = lengths(m);
    const bool same_law = from.state("kappa", -1.0) >= 0.0;
    double* const s = to.states;
    const double damage = std::max(from.state("xi_t", 0.0), from.state("xi_s", 0.0));
    const double xi = from.has({"failed"}) || from.is_gap() ? m.end : from.state("xi", damage);
    const double w = from.state("w", 0.0);
    s[kXi] = xi;
    s[kW] = w;
    s[kQ] = from.state("q", 0.0);
    s[kKappa] = from.state("kappa", length.u0 + std::min(xi, m.end) * length.lt);
    s[kL] = from.state("l", w > 0.0 ? g.wp + w : 0.0);
    s[kGs] = from.state("g_s", 0.0), s[kGt] = from.state("g_t", 0.0);
    s[kRm] = from.state("r_m", 0.0), s[kVm] = from.state("v_m", 0.0);
    s[kSlip] = from.state("slip", 0.0);
    const double v = s[kRm] > 0.0 ? s[kVm] * std::min(1.0, std::hypot(s[kGs], s[kGt]) / s[kRm]) : 0.0;

    const double F = crushing_strength(m, s[kL]), f = m.factor(xi);
    const double b = s[kL] > g.wp && std::isfinite(g.fc) ? F / g.fc : 1.0, B = b * f;
    const double compliance = 1.0 / g.kn + (std::isfinite(g.fc) ? g.chi * s[kL] / g.fc : 0.0);
    const double tau = std::hypot(from.tau_s, from.tau_t), pressure = std::max(0.0, -from.sigma);
    const double slack = 1e-9 * std::max({std::abs(from.sigma), g.ft, g.c0, tau});

    double h = from.sigma * compliance, S = g.cr + (g.c0 - g.cr) * B + (g.mur + (g.mu0 - g.mur) * f) * pressure;
    bool inside =
        std::hypot(pressure, std::sqrt(g.Cs) * tau) <= F + slack && (s[kQ] == 0.0 || pressure <= g.ft + slack);
    if (from.sigma > 0.0) {
      const double K = g.ft > 0.0 ? g.ft * B / (std::max(length.u0, s[kKappa]) - s[kQ]) : 0.0;
      h = K > 0.0 ? from.sigma / K : 0.0;
      S = b * f * std::max(0.0, g.c0 - (B > 0.0 ? g.mu0 * from.sigma / B : 0.0));
      inside = from.sigma <= g.ft * B + slack;
    } else if (from.sigma == 0.0) {
      // An open crack keeps its width.
      const double open = from.normal_jump + w - (same_law ? v : from.state("v", 0.0)) - s[kQ];
      h = B == 0.0 ? std::max(0.0, open) : 0.0;
      if (h > 0.0) S = 0.0;
    }
    to.normal_shift = h + s[kQ] - w + v - from.normal_jump;
    to.energy_stored = 0.5 * from.sigma * h + 0.5 * tau * tau / g.ks;
    to.status = !inside || tau > S + slack || !std::isfinite(h) ? QUOIN_POINT_FAILED
                : from.has({"lambda"})                          ? QUOIN_POINT_CLAMPED
                                                                : QUOIN_POINT_OK;
  }
};

}  // namespace
}  // namespace quoin::cyclic_joint

extern "C" QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  return quoin::shim::single_law_library<quoin::cyclic_joint::CyclicJointLaw>(host, text);
}
