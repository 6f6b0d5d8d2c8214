#include "shared/point.h"

#include <stdexcept>

namespace quoin::adapters {

std::uint32_t evaluate(const Material& material, PointStep& step) {
  const quoin_law& law = material.law();
  quoin_in state_old[max_states];
  quoin_out state_new[max_states];
  for (std::uint64_t k = 0; k < law.state_count; ++k) {
    state_old[k] = {step.state_old + k, 1};
    state_new[k] = {step.state_new + k, 1};
  }
  std::uint32_t status = QUOIN_POINT_OK;
  quoin_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.normal_jump = {&step.normal_jump, 1};
  for (int k = 0; k < 2; ++k) batch.slip_increment[k] = {&step.slip[k], 1};
  for (int k = 0; k < 3; ++k) {
    batch.traction_old[k] = {step.traction_old + k, 1};
    batch.traction_new[k] = {step.traction_new + k, 1};
  }
  batch.state_old = state_old;
  batch.state_new = state_new;
  if (step.energy_stored != nullptr) batch.energy_stored = {step.energy_stored, 1};
  if (step.dissipated != nullptr)
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch.dissipated[k] = {step.dissipated + k, 1};
  if (step.tangent != nullptr)
    for (int k = 0; k < 9; ++k) batch.tangent[k] = {step.tangent + k, 1};
  step.flags = 0;
  if ((law.capabilities & QUOIN_CAN_FLAGS) != 0) batch.flags = {&step.flags, 1};
  batch.status = {&status, 1};
  if (const quoin_status code = law.evaluate(material.handle(), &batch); code != QUOIN_OK)
    throw std::runtime_error(std::string(law.id) + ": evaluate refuses the step with status " + std::to_string(code));
  return status;
}

}  // namespace quoin::adapters
