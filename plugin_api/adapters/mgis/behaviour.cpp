#include "mgis/behaviour.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "mgis/request.h"
#include "shared/law_library.h"
#include "shared/point.h"

namespace quoin::mgis {

namespace {

int fail(const BehaviourData& data, const char* reason) {
  if (data.error_message != nullptr) std::snprintf(data.error_message, error_message_size, "%s", reason);
  return integration_failed;
}

void elastic_operator(const adapters::Material& material, double* K) {
  const quoin_stiffness_bounds& stiffness = material.stiffness();
  for (int k = 0; k < 9; ++k) K[k] = k == 0 ? stiffness.normal : k % 4 == 0 ? stiffness.shear : 0.0;
}

// The tangent of a step that does not move: outputs other than the operator go nowhere.
void prediction_operator(const adapters::Material& material, const BehaviourData& data) {
  double traction[3], state[adapters::max_states];
  adapters::PointStep step;
  step.normal_jump = data.s0.gradients[0];
  step.traction_old = data.s0.thermodynamic_forces;
  step.state_old = data.s0.internal_state_variables;
  step.traction_new = traction;
  step.state_new = state;
  step.tangent = data.K;
  if (adapters::evaluate(material, step) == QUOIN_POINT_FAILED)
    throw std::runtime_error("the state at the start of the step is not finite");
}

int step(const adapters::Material& material, const BehaviourData& data, bool tangent) {
  double dissipated[QUOIN_DISSIPATED_COUNT];
  const bool energies = (material.law().capabilities & QUOIN_CAN_ENERGY) != 0;
  adapters::PointStep step;
  step.normal_jump = data.s1.gradients[0];
  for (int k = 0; k < 2; ++k) step.slip[k] = data.s1.gradients[k + 1] - data.s0.gradients[k + 1];
  step.traction_old = data.s0.thermodynamic_forces;
  step.state_old = data.s0.internal_state_variables;
  step.traction_new = data.s1.thermodynamic_forces;
  step.state_new = data.s1.internal_state_variables;
  if (energies) step.energy_stored = data.s1.stored_energy;
  if (energies && data.s1.dissipated_energy != nullptr) step.dissipated = dissipated;
  if (tangent) step.tangent = data.K;
  const std::uint32_t status = adapters::evaluate(material, step);
  if (status == QUOIN_POINT_FAILED) {
    char reason[error_message_size];
    std::snprintf(reason, sizeof reason,
                  "opening (%g, %g, %g) m from (%g, %g, %g) m, or the state at the start of the step, is not finite",
                  data.s1.gradients[0], data.s1.gradients[1], data.s1.gradients[2], data.s0.gradients[0],
                  data.s0.gradients[1], data.s0.gradients[2]);
    throw std::runtime_error(reason);
  }
  if (step.dissipated != nullptr) {
    double total = data.s0.dissipated_energy != nullptr ? *data.s0.dissipated_energy : 0.0;
    for (const double mode : dissipated) total += mode;
    *data.s1.dissipated_energy = total;
  }
  return status == QUOIN_POINT_CLAMPED ? results_unreliable : results_reliable;
}

}  // namespace

int Behaviour::integrate(BehaviourData& data) const noexcept {
  try {
    const Request request(data.K[0]);
    if (request.speed_of_sound)
      throw std::runtime_error("speed of sound: a cohesive zone model has none; ask with K[0] below 50");
    const adapters::Material& point = material(data.s1.material_properties);
    const bool tangent = request.wanted == Request::Operator::tangent;
    if (tangent && (point.law().capabilities & QUOIN_CAN_TANGENT) == 0)
      throw std::runtime_error(std::string(law_name_) + " offers no tangent; ask for the elastic operator (K[0] = 1)");
    const int result = request.integration ? step(point, data, tangent) : results_reliable;
    if (!request.integration && tangent) prediction_operator(point, data);
    if (request.wanted == Request::Operator::elastic) elastic_operator(point, data.K);
    return result;
  } catch (const std::exception& error) {
    return fail(data, error.what());
  }
}

int Behaviour::initialize(BehaviourData& data, const char* initial_state) const noexcept {
  try {
    material(data.s1.material_properties).initial_state(initial_state, data.s1.internal_state_variables);
    return results_reliable;
  } catch (const std::exception& error) {
    return fail(data, error.what());
  }
}

// A host passes the properties again at every call: the last material of the thread is nearly always the right one.
const adapters::Material& Behaviour::material(const double* properties) const {
  struct Last {
    const Behaviour* behaviour = nullptr;
    std::string key;  // the bytes of the property values
    const adapters::Material* material = nullptr;
  };
  thread_local Last last;
  const std::size_t bytes = property_count_ * sizeof(double);
  if (last.behaviour == this && std::memcmp(last.key.data(), properties, bytes) == 0) return *last.material;

  const adapters::Material& found = adapters::shared_material(law(), {properties, property_count_});
  last = {this, std::string(reinterpret_cast<const char*>(properties), bytes), &found};
  return found;
}

const quoin_law& Behaviour::law() const {
  const quoin_law& found = adapters::law_by_name(law_name_);
  const std::vector<const quoin_property_info*> infos = adapters::scalar_properties(found);
  const bool same =
      found.state_schema == state_schema_ &&
      std::equal(infos.begin(), infos.end(), properties_, properties_ + property_count_,
                 [](const quoin_property_info* info, const char* id) { return std::strcmp(info->id, id) == 0; });
  if (!same)
    throw std::runtime_error(
        std::string(law_name_) + ": the law " + found.version +
        " has other states or properties than this behaviour was generated for; generate it again");
  return found;
}

}  // namespace quoin::mgis
