#include "mgis/behaviour.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "mgis/property_sets.h"
#include "mgis/request.h"
#include "shared/law_library.h"
#include "shared/point.h"

namespace quoin::mgis {

namespace {

int fail(const BehaviourData& data, const char* reason) {
  if (data.error_message != nullptr) std::snprintf(data.error_message, error_message_size, "%s", reason);
  return integration_failed;
}

// Sets K to the elastic stiffness, row by row.
void elastic_operator(const quoin_stiffness_bounds& stiffness, int components, double* K) {
  std::fill_n(K, components * components, 0.0);
  for (int k = 0; k < components; ++k) K[k * components + k] = k == 0 ? stiffness.normal : stiffness.shear;
}

void put_tangent(const double* tangent, int components, double* K) {
  for (int row = 0; row < components; ++row) std::copy_n(tangent + 3 * row, components, K + components * row);
}

std::uint32_t evaluate(adapters::PointBatch& point, const PointMaterial& of) {
  return point.evaluate(*of.material, of.column_count, of.columns);
}

// Sets point to the start of the step. In plane strain its third components are 0. states: memory for the new states.
void put_start(const BehaviourData& data, int components, double* states, adapters::PointBatch& point) {
  point.slip[1] = point.traction[2] = 0.0;
  std::copy_n(data.s0.thermodynamic_forces, components, point.traction);
  point.states(data.s0.internal_state_variables, states);
}

// Throws the reason why the law fails a point: its own properties are refused, or a value is not finite.
[[noreturn]] void throw_reason(const BehaviourData& data, int components, const PropertySets& sets,
                               const PointMaterial& of) {
  if (of.column_count > 0) sets.make(data.s1.material_properties);
  std::string reason = "opening (";
  const auto append = [&](const double* gradients) {
    for (int k = 0; k < components; ++k) {
      char number[32];
      std::snprintf(number, sizeof number, k > 0 ? ", %g" : "%g", gradients[k]);
      reason += number;
    }
  };
  append(data.s1.gradients);
  reason += ") m from (";
  append(data.s0.gradients);
  throw std::runtime_error(reason + ") m, or the state at the start of the step, is not finite");
}

// Computes the tangent of a step without motion. Only the operator is written to data.
void prediction_operator(const PropertySets& sets, const PointMaterial& of, const BehaviourData& data, int components) {
  adapters::PointBatch& point = adapters::PointBatch::of_thread(sets.law(), adapters::outputs::tangent);
  point.normal_jump = data.s0.gradients[0];
  point.slip[0] = 0.0;
  std::array<double, adapters::max_states> unused;
  put_start(data, components, unused.data(), point);
  if (evaluate(point, of) == QUOIN_POINT_FAILED) throw_reason(data, components, sets, of);
  put_tangent(point.tangent, components, data.K);
}

int step(const PropertySets& sets, const PointMaterial& of, const BehaviourData& data, int components, bool energies,
         bool tangent) {
  energies = energies && (data.s1.stored_energy != nullptr || data.s1.dissipated_energy != nullptr);
  adapters::PointBatch& point = adapters::PointBatch::of_thread(
      sets.law(), (energies ? adapters::outputs::energies : adapters::outputs::nothing) |
                      (tangent ? adapters::outputs::tangent : adapters::outputs::nothing));
  put_start(data, components, data.s1.internal_state_variables, point);
  point.normal_jump = data.s1.gradients[0];
  for (int k = 1; k < components; ++k) point.slip[k - 1] = data.s1.gradients[k] - data.s0.gradients[k];
  const std::uint32_t status = evaluate(point, of);
  if (status == QUOIN_POINT_FAILED) throw_reason(data, components, sets, of);
  std::copy_n(point.traction, components, data.s1.thermodynamic_forces);
  if (tangent) put_tangent(point.tangent, components, data.K);
  if (energies && data.s1.stored_energy != nullptr) *data.s1.stored_energy = point.energy_stored;
  if (energies && data.s1.dissipated_energy != nullptr) {
    double total = data.s0.dissipated_energy != nullptr ? *data.s0.dissipated_energy : 0.0;
    for (const double mode : point.dissipated) total += mode;
    *data.s1.dissipated_energy = total;
  }
  return status == QUOIN_POINT_CLAMPED ? results_unreliable : results_reliable;
}

}  // namespace

int Behaviour::integrate(BehaviourData& data, Hypothesis hypothesis) const noexcept {
  try {
    const int components = static_cast<int>(hypothesis);
    const Request request(data.K[0]);
    if (request.speed_of_sound)
      throw std::runtime_error("speed of sound: a cohesive zone model has none; ask with K[0] below 50");
    PropertySets& sets = PropertySets::of_thread(law());
    const double* const properties = data.s1.material_properties;
    const PointMaterial point = sets.find(properties);
    const bool tangent = request.wanted == Request::Operator::tangent;
    if (tangent && (sets.law().capabilities & QUOIN_CAN_TANGENT) == 0)
      throw std::runtime_error(std::string(law_name_) + " offers no tangent; ask for the elastic operator (K[0] = 1)");
    const int result = request.integration ? step(sets, point, data, components, energies_, tangent) : results_reliable;
    if (!request.integration && tangent) prediction_operator(sets, point, data, components);
    if (request.wanted == Request::Operator::elastic) {
      const bool exact = point.column_count == 0;
      elastic_operator(exact ? point.material->elastic() : sets.make(properties)->elastic(), components, data.K);
    }
    return result;
  } catch (const std::exception& error) {
    return fail(data, error.what());
  } catch (...) {
    return fail(data, "the law has thrown what no law may throw");
  }
}

int Behaviour::initialize(BehaviourData& data, const char* initial_state) const noexcept {
  try {
    PropertySets& sets = PropertySets::of_thread(law());
    const double* const properties = data.s1.material_properties;
    const PointMaterial point = sets.find(properties);
    double* const states = data.s1.internal_state_variables;
    std::ranges::copy(point.column_count == 0 ? point.material->initial_state(initial_state)
                                              : sets.make(properties)->initial_state(initial_state),
                      states);
    return results_reliable;
  } catch (const std::exception& error) {
    return fail(data, error.what());
  } catch (...) {
    return fail(data, "the law has thrown what no law may throw");
  }
}

// Finds the law at the first call only: reading the environment and the file system costs as much as a thousand steps.
const quoin_law& Behaviour::law() const {
  const quoin_law* known = law_.load(std::memory_order_acquire);
  if (known == nullptr) {
    known = &find_law();
    law_.store(known, std::memory_order_release);
  }
  return *known;
}

const quoin_law& Behaviour::find_law() const {
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
