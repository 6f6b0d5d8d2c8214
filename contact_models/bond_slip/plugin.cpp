// The bond-slip law behind the C ABI.
#include "shim/plugin.h"

#include <algorithm>
#include <cmath>

#include "bond_slip/kernel.h"

namespace quoin::bond_slip {
namespace {
using namespace quoin::shim;

constexpr std::uint32_t kColumn = QUOIN_PROPERTY_PER_POINT | QUOIN_PROPERTY_LOWER_OPEN;
constexpr std::uint32_t kStiffness = QUOIN_PROPERTY_REQUIRED | kColumn | QUOIN_PROPERTY_UPPER_OPEN;
// lambda of a joint that was never bonded: above the r of any material.
constexpr double kDebonded = 1e12;

constexpr quoin_property_info kKn =
    number_property("normal_stiffness", "kn", "Pa/m", "elastic normal stiffness", kStiffness, 0.0, 0.0, kInfinity);
constexpr quoin_property_info kKs =
    number_property("shear_stiffness", "ks", "Pa/m", "elastic stiffness of slip", kStiffness, 0.0, 0.0, kInfinity);
constexpr quoin_property_info kTauM =
    number_property("bond_strength", "tau_m", "Pa", "largest shear stress of pure slip; infinite: never debonds",
                    kColumn, kInfinity, 0.0, kInfinity);
constexpr quoin_property_info kFp =
    number_property("peel_strength", "f_p", "Pa", "largest tension of pure opening; infinite: opening debonds nothing",
                    kColumn, kInfinity, 0.0, kInfinity);
constexpr quoin_property_info kGf =
    number_property("fracture_energy", "G_f", "J/m2", "of pure slip, all of it; more than tau_m^2/(2 ks)", kColumn,
                    kInfinity, 0.0, kInfinity);

constexpr quoin_state_info slip_state(const char* id, std::uint32_t kind) {
  return {
      sizeof(quoin_state_info), id, "m", "slip since the start", QUOIN_ROLE_HISTORY, kind, 0, 0, -kInfinity, kInfinity};
}
constexpr quoin_state_info kSlipSInfo = slip_state("slip_s", QUOIN_STATE_PAIR_S);
constexpr quoin_state_info kSlipTInfo = slip_state("slip_t", QUOIN_STATE_PAIR_T);
constexpr quoin_state_info kLambdaInfo = scalar_state("lambda", "-", "largest jump over that at which softening begins",
                                                      QUOIN_ROLE_HISTORY, QUOIN_STATE_MONOTONIC, 0.0, kInfinity);

// Returns the undamaged share 1 - D.
double undamaged(const Parameters& p, double lambda) {
  if (lambda <= 1.0 || !std::isfinite(p.tau_m)) return lambda >= kDebonded ? 0.0 : 1.0;
  const double r = 2.0 * (p.G_f / p.tau_m) * p.ks / p.tau_m;
  return std::max(0.0, (r - lambda) / ((r - 1.0) * lambda));
}

struct BondSlipLaw {
  using Material = Parameters;
  static constexpr const char* id = "bond_slip";
  static constexpr const char* name = "Bond of a strip, bilinear";
  static constexpr const char* citation =
      "CNR-DT 200 R1/2013, 4.3; Camanho and Davila (2002) for slip and peel together";
  static constexpr const char* description =
      "Elastic, then linear softening to debonding with a fracture energy; unloads to the origin; elastic in "
      "compression.";
  static constexpr std::uint64_t capabilities = QUOIN_CAN_ENERGY | QUOIN_CAN_TANGENT | QUOIN_CAN_PROPERTY_COLUMNS |
                                                QUOIN_CAN_FLAGS | QUOIN_CAN_MIGRATE | QUOIN_CAN_DAMAGE;
  // In the order of PropertyColumn.
  static constexpr std::array<const quoin_property_info*, kPropertyColumnCount> properties = {&kKn, &kKs, &kTauM, &kFp,
                                                                                              &kGf};
  static constexpr std::array<const quoin_state_info*, kStateCount> states = {&kSlipSInfo, &kSlipTInfo, &kLambdaInfo};
  static constexpr std::array<const char*, 2> initial_states = {"bonded", "dry"};

  static Material make(const PropertyValues& values, Report& report) {
    const Material m{values.number("normal_stiffness"), values.number("shear_stiffness"),
                     values.number("bond_strength"), values.number("peel_strength"), values.number("fracture_energy")};
    if (!std::isfinite(m.tau_m)) {
      if (std::isfinite(m.f_p))
        report.faults.emplace_back("peel_strength: only together with bond_strength; give both");
      return m;
    }
    const double elastic = 0.5 * m.tau_m * m.tau_m / m.ks;
    if (!std::isfinite(m.G_f) || !(m.G_f > elastic))
      report.faults.push_back("fracture_energy = " + to_text(m.G_f) + ": must be finite and more than " +
                              to_text(elastic) + ", which the bond stores at bond_strength (tau_m^2/(2 ks))");
    return m;
  }

  static bool initial_state(const Material&, std::string_view state, double* values) {
    if (state != "bonded" && state != "dry") return false;
    values[kSlipS] = values[kSlipT] = 0.0;
    values[kLambda] = state == "dry" ? kDebonded : 0.0;
    return true;
  }

  static void stiffness_bounds(const Material& material, double& normal, double& shear) {
    normal = material.kn;
    shear = material.ks;
  }

  static void evaluate(const Material& material, const Columns& columns, std::size_t count, Summary& summary) {
    bond_slip::evaluate(material, columns, count, summary);
  }
  static void evaluate_one(const Material& material, const Columns& columns, Summary& summary) {
    bond_slip::evaluate_one(material, columns, summary);
  }

  // Keeps states of this law that agree with the traction and whose jump is within their lambda. Any other point
  // becomes an undamaged bond if that carries the traction, else it gets status FAILED. Damage that is lost so, and
  // that of other laws, gets CLAMPED.
  static void migrate(const Material& p, const MigrationPoint& from, MigrationResult& to) {
    const double lambda = from.state("lambda", 0.0), whole = undamaged(p, lambda);
    const double s = from.state("slip_s", 0.0), t = from.state("slip_t", 0.0);
    const double normal = from.normal_jump > 0.0 ? p.kn * whole : p.kn;
    constexpr double kRounding = 1e-9;
    const auto agrees = [](double given, double own) {
      return std::abs(given - own) <= kRounding * std::max(std::abs(given), std::abs(own));
    };
    const auto relative = [&](double tau, double sigma) {
      return std::hypot(tau / p.tau_m, std::max(0.0, sigma) / p.f_p);
    };
    const bool own = agrees(from.tau_s, p.ks * whole * s) && agrees(from.tau_t, p.ks * whole * t) &&
                     agrees(from.sigma, normal * from.normal_jump) &&
                     (whole == 0.0 || relative(p.ks * std::hypot(s, t), p.kn * from.normal_jump) <=
                                          std::max(1.0, lambda) * (1.0 + kRounding));
    const bool lost = from.is_gap() || from.has({"failed", "xi", "xi_t", "xi_s", "w"}) || (!own && lambda > 0.0);
    if (lost) to.status = QUOIN_POINT_CLAMPED;
    if (own) {
      to.states[kSlipS] = s, to.states[kSlipT] = t, to.states[kLambda] = lambda;
      to.energy_stored = 0.5 * (from.sigma * from.normal_jump + p.ks * whole * (s * s + t * t));
      return;
    }
    const double d_n = from.sigma / p.kn, tau = std::hypot(from.tau_s, from.tau_t);
    to.states[kSlipS] = from.tau_s / p.ks, to.states[kSlipT] = from.tau_t / p.ks;
    to.normal_shift = d_n - from.normal_jump;
    to.energy_stored = 0.5 * (from.sigma * d_n + tau * tau / p.ks);
    if (relative(tau, from.sigma) > 1.0 + kRounding) to.status = QUOIN_POINT_FAILED;
  }
};

}  // namespace
}  // namespace quoin::bond_slip

extern "C" QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  return quoin::shim::single_law_library<quoin::bond_slip::BondSlipLaw>(host, text);
}
