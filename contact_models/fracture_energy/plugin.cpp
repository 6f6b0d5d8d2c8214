// The fracture-energy law behind the C ABI: metadata, admissibility (LAW.md, statement 6), migration.
#include "shim/plugin.h"

#include <algorithm>
#include <cmath>

#include "fracture_energy/kernel.h"
#include "shim/softening_property.h"

namespace quoin::fracture_energy {
namespace {
using namespace quoin::shim;

constexpr std::uint32_t kColumn = QUOIN_PROPERTY_PER_POINT;
constexpr std::uint32_t kFinite = QUOIN_PROPERTY_UPPER_OPEN;
constexpr std::uint32_t kStiffness = QUOIN_PROPERTY_REQUIRED | kColumn | QUOIN_PROPERTY_LOWER_OPEN | kFinite;

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
constexpr quoin_property_info kPsi0 = angle("dilation_angle", "psi0", "dilation angle, fading with f");
constexpr quoin_property_info kFc =
    number_property("compressive_strength", "fc", "Pa", "compressive strength; infinite: no crushing", kColumn,
                    kInfinity, 0.0, kInfinity);
constexpr quoin_property_info kFcr =
    number("compressive_strength_residual", "fcr", "Pa", "residual compressive strength");
constexpr quoin_property_info kG1 =
    number("fracture_energy_tension", "G1", "J/m2", "total area under the tension curve; needed when ft > 0");
constexpr quoin_property_info kG2 = number("fracture_energy_shear", "G2", "J/m2",
                                           "work above residual and friction over the slip; needed when c0 > cr");
constexpr quoin_property_info kGc =
    number("fracture_energy_compression", "Gc", "J/m2",
           "work above fcr over the plastic closure; needed when fc is finite and > fcr");
constexpr const char* kCouplings[] = {"shared", "none"};
constexpr quoin_property_info kCoupling = {sizeof(quoin_property_info),
                                           "coupling",
                                           "-",
                                           "-",
                                           "shared: one damage for tension and shear, so that opening with slip spends "
                                           "neither G1 nor G2 exactly; none: one each",
                                           QUOIN_PROPERTY_CHOICE,
                                           0,
                                           0.0,
                                           0.0,
                                           0.0,
                                           nullptr,
                                           "shared",
                                           2,
                                           kCouplings};

constexpr quoin_state_info history(const char* id, const char* unit, const char* text) {
  return scalar_state(id, unit, text, QUOIN_ROLE_HISTORY, QUOIN_STATE_MONOTONIC, 0.0, kInfinity);
}
constexpr quoin_state_info kXiTInfo = history("xi_t", "-", "internal variable of tension");
constexpr quoin_state_info kXiSInfo = history("xi_s", "-", "internal variable of shear; equals xi_t when shared");
constexpr quoin_state_info kWInfo = history("w", "m", "plastic closure by crushing");
constexpr quoin_state_info kVInfo = history("v", "m", "uplift by dilation");
constexpr quoin_state_info kSlipInfo =
    scalar_state("slip", "m", "accumulated slip", QUOIN_ROLE_DIAGNOSTIC, QUOIN_STATE_MONOTONIC, 0.0, kInfinity);

// Checks LAW.md, statement 6: order of strengths and angles, and no snap-back in any mode that loses strength.
void check_admissible(const Parameters& m, const PropertyValues& values, Report& report) {
  const Properties& g = m.given;
  const auto not_above = [&](const char* id, const char* limit) {
    if (values.number(id) > values.number(limit)) {
      report.faults.push_back(std::string(id) + " = " + to_text(values.number(id)) + ": must not exceed " + limit +
                              " = " + to_text(values.number(limit)));
    }
  };
  not_above("cohesion_residual", "cohesion");
  not_above("friction_angle_residual", "friction_angle");
  not_above("compressive_strength_residual", "compressive_strength");
  not_above("dilation_angle", "friction_angle");

  const auto snaps_back = [&](const char* id, double value, double bound, const char* why) {
    report.faults.push_back(std::string(id) + " = " + to_text(value) +
                            " J/m2: the joint would snap back; must be greater than " + to_text(bound) + " J/m2 (" +
                            why + "); raise it, or lower the strength or raise the stiffness");
  };
  const double lowest_G1 = 0.5 * g.ft * g.ft / g.kn;
  if (g.ft > 0.0 && !(g.G1 > lowest_G1)) snaps_back("fracture_energy_tension", g.G1, lowest_G1, "ft^2/(2 kn)");
  const bool crushes = std::isfinite(g.fc);
  const double P = crushes ? g.fc : 0.0;
  const double drop = g.c0 - g.cr;
  const double friction_drop = g.mu0 - g.mur;
  // Bound on the decrease of S along the slip by uplift, Pa/m: uplift crushes the joint, and S falls with the pressure.
  const double q = crushes && g.fc > g.fcr ? m.slope * (g.fc - g.fcr) * (g.fc - g.fcr) * m.A / (g.Gc * g.kn) : 0.0;
  const double by_uplift =
      q > 0.0 && q < 1.0 ? g.kn * g.mu0 * g.tan_psi * q / (1.0 - q) : 0.0;  // q >= 1: Gc is refused
  if (drop > 0.0) {
    const double lowest_G2 =
        m.slope * std::max(g.c0, drop + P * friction_drop) * drop * m.A / std::max(0.0, g.ks - by_uplift);
    if (by_uplift >= g.ks) {
      report.faults.push_back("dilation_angle: with it and fracture_energy_compression = " + to_text(g.Gc) +
                              " J/m2 the joint would snap back whatever fracture_energy_shear: kn mu0 tan(psi0) q/(1 - "
                              "q) = " +
                              to_text(by_uplift) + " Pa/m must be below shear_stiffness = " + to_text(g.ks) +
                              " Pa/m, q = m (fc - fcr)^2 A/(Gc kn); raise fracture_energy_compression, or lower the "
                              "dilation_angle or the compressive_strength");
    } else if (!(g.G2 > lowest_G2)) {
      snaps_back("fracture_energy_shear", g.G2, lowest_G2,
                 by_uplift > 0.0 ? "m max(c0, c0 - cr + P (mu0 - mur)) (c0 - cr) A/(ks - kn mu0 tan(psi0) q/(1 - q)), "
                                   "P = fc, q = m (fc - fcr)^2 A/(Gc kn)"
                                 : "m max(c0, c0 - cr + P (mu0 - mur)) (c0 - cr) A/ks, P = fc");
    } else if (!crushes && friction_drop > 0.0) {
      const double confinement = (g.G2 * g.ks / (drop * m.A) / m.slope - drop) / friction_drop;
      report.warnings.push_back("friction_angle_residual: softening of friction is unstable beyond a confinement of " +
                                to_text(confinement) + " Pa; give compressive_strength, or keep the confinement below");
    }
  }
  if (crushes && g.fc > g.fcr) {
    const double lowest_Gc = m.slope * (g.fc - g.fcr) * (g.fc - g.fcr) * m.A / g.kn;
    if (!(g.Gc > lowest_Gc)) snaps_back("fracture_energy_compression", g.Gc, lowest_Gc, "m (fc - fcr)^2 A/kn");
  }
  if (g.ft * g.mu0 > g.c0) {
    report.warnings.push_back("tensile_strength: ft tan(phi0) = " + to_text(g.ft * g.mu0) + " Pa exceeds cohesion = " +
                              to_text(g.c0) + " Pa; the shear strength is 0 before ft is reached");
  }
}

struct FractureEnergyLaw {
  using Material = fracture_energy::Material;
  static constexpr const char* id = "fracture_energy";
  static constexpr const char* name = "Fracture-energy joint";
  static constexpr const char* citation =
      "Pulatsu, Erdogmus, Lourenco, Lemos, Tuncay (2020), Simulation of the in-plane structural behavior of "
      "unreinforced "
      "masonry walls and buildings using DEM, section 2 and Figure 3";
  static constexpr const char* description =
      "Softening in tension, shear and compression with fracture energies; Coulomb friction, residuals, dilation.";
  static constexpr std::uint64_t capabilities = QUOIN_CAN_ENERGY | QUOIN_CAN_TANGENT | QUOIN_CAN_PROPERTY_COLUMNS |
                                                QUOIN_CAN_FLAGS | QUOIN_CAN_MIGRATE | QUOIN_CAN_DAMAGE;
  // The first kPropertyColumnCount in the order of PropertyColumn.
  static constexpr std::array<const quoin_property_info*, 16> properties = {
      &kKn, &kKs,  &kFt, &kC0, &kCr, &kPhi0,      &kPhir,  &kPsi0,
      &kFc, &kFcr, &kG1, &kG2, &kGc, &kSoftening, &kTable, &kCoupling};
  static constexpr std::array<const quoin_state_info*, kStateCount> states = {&kXiTInfo, &kXiSInfo, &kWInfo, &kVInfo,
                                                                              &kSlipInfo};
  static constexpr std::array<const char*, 2> initial_states = {"bonded", "dry"};

  static Material make(const PropertyValues& values, Report& report) {
    const auto tangent = [&](const char* property) { return std::tan(values.number(property) * (M_PI / 180.0)); };
    Material material{};
    Parameters& m = material.parameters;
    m.given = {values.number("normal_stiffness"),           values.number("shear_stiffness"),
               values.number("tensile_strength"),           values.number("cohesion"),
               values.number("cohesion_residual"),          tangent("friction_angle"),
               tangent("friction_angle_residual"),          tangent("dilation_angle"),
               values.number("compressive_strength"),       values.number("compressive_strength_residual"),
               values.number("fracture_energy_tension"),    values.number("fracture_energy_shear"),
               values.number("fracture_energy_compression")};
    m.own_mur = values.is_given("friction_angle_residual");
    m.shared = values.text("coupling") != "none";
    m.crushing = std::isfinite(m.given.fc);
    m.dilation = m.given.tan_psi > 0.0;
    if (read_softening(values, m, report)) check_admissible(m, values, report);
    choose_kernels(material);
    return material;
  }

  static bool initial_state(const Material& material, std::string_view state, double* values) {
    if (state != "bonded" && state != "dry") return false;
    std::fill(values, values + kStateCount, 0.0);
    if (state == "dry") values[kXiT] = values[kXiS] = material.parameters.end;
    return true;
  }

  static void stiffness_bounds(const Material& material, double& normal, double& shear) {
    normal = material.parameters.given.kn;
    shear = material.parameters.given.ks;
  }

  static void evaluate(const Material& material, const Columns& columns, std::size_t count, Summary& summary) {
    const Parameters& m = material.parameters;
    const auto by_point = [&](PropertyColumn k) { return columns.in[kProperty + k] != nullptr; };
    const bool lean = !columns.extras || (!columns.more_outputs && (m.crushing || !by_point(kColumnFc)) &&
                                          (m.dilation || !by_point(kColumnPsi0)));
    (lean ? material.lean : material.full)(material, columns, count, summary);
  }

  static void evaluate_one(const Material& material, const Columns& columns, Summary& summary) {
    material.one(material, columns, 1, summary);
  }

  // Keeps the traction: e is chosen so that sigma(e) equals the normal stress. A point whose traction is outside the
  // strength that its history leaves gets status FAILED. A joint that a brittle law has failed becomes fully softened,
  // and the bond damage xi of cyclic_joint that of both modes. Damage of bond_slip has no counterpart: CLAMPED.
  static void migrate(const Material& material, const MigrationPoint& from, MigrationResult& to) {
    const Parameters& m = material.parameters;
    const Properties& g = m.given;
    const double of_both = from.has({"failed"}) || from.is_gap() ? m.end : from.state("xi", 0.0);
    double xi_t = std::max(of_both, from.state("xi_t", 0.0));
    double xi_s = std::max(of_both, from.state("xi_s", xi_t));
    if (m.shared) xi_t = xi_s = std::max(xi_t, xi_s);
    const double w = from.state("w", 0.0), v = from.state("v", 0.0);
    to.states[kXiT] = xi_t, to.states[kXiS] = xi_s, to.states[kW] = w, to.states[kV] = v;
    to.states[kSlip] = from.state("slip", 0.0);

    const double slack = 1e-9 * std::max({std::abs(from.sigma), g.ft, g.c0, std::hypot(from.tau_s, from.tau_t)});
    const double f_t = m.factor(xi_t);
    const double drop_c = g.fc - g.fcr;
    const double wu = std::isfinite(g.fc) && drop_c > 0.0 ? g.Gc / (drop_c * m.A) : kInfinity;
    const double F = std::isfinite(g.fc) ? g.fcr + drop_c * m.factor(w / wu) : kInfinity;
    bool inside = from.sigma >= -F - slack && from.sigma <= g.ft * f_t + slack;

    double e = from.sigma / g.kn;
    if (from.sigma > 0.0) {
      const double u0 = g.ft / g.kn;
      const double lt = g.ft > 0.0 ? (g.G1 - 0.5 * g.ft * u0) / (g.ft * m.A) : 0.0;
      e = f_t > 0.0 ? from.sigma * (u0 + xi_t * lt) / (g.ft * f_t) : 0.0;
    } else if (from.sigma == 0.0) {
      e = std::max(0.0, f_t == 0.0 ? from.normal_jump + w - v : 0.0);  // an open crack keeps its width
    }
    to.normal_shift = e - w + v - from.normal_jump;

    const double f_s = m.factor(xi_s);
    const double mu = g.mu0 + (g.mur - g.mu0) * (1.0 - f_s);
    const double cohesion = e > 0.0 ? g.c0 * f_s : g.cr + (g.c0 - g.cr) * f_s;
    const double tau = std::hypot(from.tau_s, from.tau_t);
    const double S = F > 0.0 ? std::max(0.0, cohesion - from.sigma * mu) : 0.0;
    inside = inside && tau <= S + slack;
    to.energy_stored = 0.5 * from.sigma * e + 0.5 * tau * tau / g.ks;
    to.status = !inside || !std::isfinite(e) ? QUOIN_POINT_FAILED
                : from.has({"lambda"})       ? QUOIN_POINT_CLAMPED
                                             : QUOIN_POINT_OK;
  }
};

}  // namespace
}  // namespace quoin::fracture_energy

extern "C" QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  return quoin::shim::single_law_library<quoin::fracture_energy::FractureEnergyLaw>(host, text);
}
