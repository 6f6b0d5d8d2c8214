// The elastic law behind the C ABI.
#include "shim/plugin.h"

#include "elastic/kernel.h"

namespace quoin::elastic {
namespace {
using namespace quoin::shim;

constexpr std::uint32_t kStiffness =
    QUOIN_PROPERTY_REQUIRED | QUOIN_PROPERTY_PER_POINT | QUOIN_PROPERTY_LOWER_OPEN | QUOIN_PROPERTY_UPPER_OPEN;
constexpr quoin_property_info kNormal = number_property(
    "normal_stiffness", "kn", "Pa/m", "elastic joint stiffness, normal", kStiffness, 0.0, 0.0, kInfinity);
constexpr quoin_property_info kShear =
    number_property("shear_stiffness", "ks", "Pa/m", "elastic joint stiffness, shear", kStiffness, 0.0, 0.0, kInfinity);

struct ElasticLaw {
  using Material = Parameters;
  static constexpr const char* id = "elastic";
  static constexpr const char* name = "Elastic joint";
  static constexpr const char* citation = "Pulatsu et al. (2020), eq. 4";
  static constexpr const char* description = "Linear elastic in tension, compression and shear; never fails.";
  static constexpr std::uint64_t capabilities = QUOIN_CAN_ENERGY | QUOIN_CAN_TANGENT | QUOIN_CAN_PROPERTY_COLUMNS |
                                                QUOIN_CAN_FLAGS | QUOIN_CAN_MIGRATE | QUOIN_CAN_DAMAGE;
  static constexpr std::array<const quoin_property_info*, 2> properties = {&kNormal, &kShear};
  static constexpr std::array<const quoin_state_info*, 0> states = {};
  static constexpr std::array<const char*, 2> initial_states = {"bonded", "dry"};

  static Material make(const PropertyValues& values, Report&) {
    return {values.number("normal_stiffness"), values.number("shear_stiffness")};
  }

  static bool initial_state(const Material&, std::string_view state, double*) {
    return state == "bonded" || state == "dry";
  }

  static void stiffness_bounds(const Material& material, double& normal, double& shear) {
    normal = material.kn;
    shear = material.ks;
  }

  static void evaluate(const Material& material, const Columns& columns, std::size_t count, Summary& summary) {
    elastic::evaluate(material, columns, count, summary);
  }
  static void evaluate_one(const Material& material, const Columns& columns, Summary& summary) {
    elastic::evaluate_one(material, columns, summary);
  }

  // Damage has no counterpart, nor has an open joint that carries nothing, which is closed without stress at its width:
  // both get CLAMPED.
  static void migrate(const Material& material, const MigrationPoint& from, MigrationResult& to) {
    const bool open = from.sigma == 0.0 && from.normal_jump > 0.0;
    if (open || from.has({"failed", "xi", "xi_t", "xi_s", "w", "lambda"})) to.status = QUOIN_POINT_CLAMPED;
    to.normal_shift = from.sigma / material.kn - from.normal_jump;
    to.energy_stored = 0.5 * (from.sigma * from.sigma / material.kn +
                              (from.tau_s * from.tau_s + from.tau_t * from.tau_t) / material.ks);
  }
};

}  // namespace
}  // namespace quoin::elastic

extern "C" QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  return quoin::shim::single_law_library<quoin::elastic::ElasticLaw>(host, text);
}
