// The brittle Coulomb-slip law behind the C ABI.
#include "shim/plugin.h"

#include <algorithm>
#include <cmath>

#include "coulomb_slip/kernel.h"

namespace quoin::coulomb_slip {
namespace {
using namespace quoin::shim;

constexpr std::uint32_t kColumn = QUOIN_PROPERTY_PER_POINT | QUOIN_PROPERTY_UPPER_OPEN;
constexpr std::uint32_t kStiffness = QUOIN_PROPERTY_REQUIRED | kColumn | QUOIN_PROPERTY_LOWER_OPEN;

constexpr quoin_property_info strength(const char* id, const char* symbol, const char* text) {
  return number_property(id, symbol, "Pa", text, kColumn, 0.0, 0.0, kInfinity);
}

constexpr quoin_property_info kKn =
    number_property("normal_stiffness", "kn", "Pa/m", "elastic normal stiffness", kStiffness, 0.0, 0.0, kInfinity);
constexpr quoin_property_info kKs =
    number_property("shear_stiffness", "ks", "Pa/m", "elastic shear stiffness", kStiffness, 0.0, 0.0, kInfinity);
constexpr quoin_property_info kFt = strength("tensile_strength", "ft", "tensile cut-off until the first failure");
constexpr quoin_property_info kFtr = strength("tensile_strength_residual", "ftr", "tensile cut-off after it");
constexpr quoin_property_info kC0 = strength("cohesion", "c0", "cohesion until the first failure");
constexpr quoin_property_info kCr = strength("cohesion_residual", "cr", "cohesion after it, while the joint is closed");
constexpr quoin_property_info kPhi0 =
    number_property("friction_angle", "phi0", "deg", "friction angle until the first failure", kColumn, 0.0, 0.0, 90.0);
constexpr quoin_property_info kPhir = number_property(
    "friction_angle_residual", "phir", "deg", "friction angle after it", kColumn, 0.0, 0.0, 90.0, "friction_angle");

constexpr quoin_state_info kFailedInfo = scalar_state("failed", "-", "1 after the first failure in tension or shear",
                                                      QUOIN_ROLE_HISTORY, QUOIN_STATE_MONOTONIC, 0.0, 1.0);
constexpr quoin_state_info kSlipInfo =
    scalar_state("slip", "m", "accumulated slip", QUOIN_ROLE_DIAGNOSTIC, QUOIN_STATE_MONOTONIC, 0.0, kInfinity);

struct CoulombSlipLaw {
  using Material = Parameters;
  static constexpr const char* id = "coulomb_slip";
  static constexpr const char* name = "Coulomb slip, brittle";
  static constexpr const char* citation =
      "Pulatsu et al. (2020), section 3 and Figure 8: the standard joint law of 3DEC";
  static constexpr const char* description =
      "Coulomb friction with cohesion and tension cut-off that drop at once to residuals; elastic in compression.";
  static constexpr std::uint64_t capabilities = QUOIN_CAN_ENERGY | QUOIN_CAN_TANGENT | QUOIN_CAN_PROPERTY_COLUMNS |
                                                QUOIN_CAN_FLAGS | QUOIN_CAN_MIGRATE | QUOIN_CAN_DAMAGE;
  // In the order of PropertyColumn.
  static constexpr std::array<const quoin_property_info*, kPropertyColumnCount> properties = {
      &kKn, &kKs, &kFt, &kFtr, &kC0, &kCr, &kPhi0, &kPhir};
  static constexpr std::array<const quoin_state_info*, kStateCount> states = {&kFailedInfo, &kSlipInfo};
  static constexpr std::array<const char*, 2> initial_states = {"bonded", "dry"};

  static Material make(const PropertyValues& values, Report& report) {
    for (const auto& [residual, limit] :
         {std::pair{"tensile_strength_residual", "tensile_strength"}, std::pair{"cohesion_residual", "cohesion"},
          std::pair{"friction_angle_residual", "friction_angle"}}) {
      if (values.number(residual) > values.number(limit)) {
        report.faults.push_back(std::string(residual) + " = " + to_text(values.number(residual)) +
                                ": must not exceed " + limit + " = " + to_text(values.number(limit)));
      }
    }
    const auto tangent = [&](const char* property) { return std::tan(values.number(property) * (M_PI / 180.0)); };
    return {values.number("normal_stiffness"),
            values.number("shear_stiffness"),
            values.number("tensile_strength"),
            values.number("tensile_strength_residual"),
            values.number("cohesion"),
            values.number("cohesion_residual"),
            tangent("friction_angle"),
            tangent("friction_angle_residual"),
            values.is_given("friction_angle_residual")};
  }

  static bool initial_state(const Material&, std::string_view state, double* values) {
    if (state != "bonded" && state != "dry") return false;
    values[kFailed] = state == "dry" ? 1.0 : 0.0;
    values[kSlip] = 0.0;
    return true;
  }

  static void stiffness_bounds(const Material& material, double& normal, double& shear) {
    normal = material.kn;
    shear = material.ks;
  }

  static void evaluate(const Material& material, const Columns& columns, std::size_t count, Summary& summary) {
    coulomb_slip::evaluate(material, columns, count, summary);
  }
  static void evaluate_one(const Material& material, const Columns& columns, Summary& summary) {
    coulomb_slip::evaluate_one(material, columns, summary);
  }

  // A fully softened joint becomes failed if the residual strengths carry its traction. A partly softened joint has no
  // counterpart in a brittle law: it becomes intact and gets status CLAMPED, as a crushed one does.
  static void migrate(const Material& p, const MigrationPoint& from, MigrationResult& to) {
    const double xi = std::max({from.state("xi_t", 0.0), from.state("xi_s", 0.0), from.state("xi", 0.0)});
    const double tau = std::hypot(from.tau_s, from.tau_t);
    const double slack = 1e-9 * std::max({std::abs(from.sigma), p.ft, p.c0, tau});
    const bool was_failed = from.has({"failed"}) || from.is_gap();
    // A crack without residual tension keeps its width.
    const bool crack = from.sigma == 0.0 && from.normal_jump > 0.0 && p.ftr == 0.0 && (was_failed || xi >= 1.0);
    const double d_n = crack ? from.normal_jump : from.sigma / p.kn;
    const auto carries = [&](bool failed) {
      const double cohesion = !failed ? p.c0 : d_n > 0.0 ? 0.0 : p.cr;
      const double S = std::max(0.0, cohesion - from.sigma * (failed ? p.mur : p.mu0));
      return from.sigma <= (failed ? p.ftr : p.ft) + slack && tau <= S + slack;
    };
    const bool failed = was_failed || (xi >= 1.0 && carries(true));
    to.states[kFailed] = failed ? 1.0 : 0.0;
    to.states[kSlip] = from.state("slip", 0.0);
    to.normal_shift = d_n - from.normal_jump;
    to.energy_stored = 0.5 * from.sigma * d_n + 0.5 * tau * tau / p.ks;
    const bool lost = (!failed && (xi > 0.0 || from.has({"lambda"}))) || from.has({"w"});
    to.status = !carries(failed) ? QUOIN_POINT_FAILED : lost ? QUOIN_POINT_CLAMPED : QUOIN_POINT_OK;
  }
};

}  // namespace
}  // namespace quoin::coulomb_slip

extern "C" QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  return quoin::shim::single_law_library<quoin::coulomb_slip::CoulombSlipLaw>(host, text);
}
