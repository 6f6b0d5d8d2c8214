// A law called directly through the C ABI, for comparison with the adapters. All points have the same step.
#pragma once

#include <array>
#include <cstdlib>
#include <vector>

#include "quoin/quoin.h"
#include "shared/law_library.h"
#include "shared/material.h"
#include "tests/adapters/paths.h"
#include "tests/mortar.h"

namespace quoin::tests {

inline std::vector<adapters::PropertyValue> mortar_of(const quoin_law& law) {
  std::vector<adapters::PropertyValue> values;
  for (std::uint64_t i = 0; i < law.property_count; ++i)
    for (const auto& [id, number] : test::mortar::properties)
      if (std::string(id) == law.properties[i]->id) values.push_back({id, {number}, {}});
  return values;
}

class DirectLaw {
 public:
  explicit DirectLaw(const quoin_law& law, std::size_t points = 1) : DirectLaw(law, points, mortar_of(law)) {}
  DirectLaw(const quoin_law& law, std::size_t points, const std::vector<adapters::PropertyValue>& values)
      : material(law, values), jump(points), state(law.state_count, std::vector<double>(points)) {
    for (auto* columns : {&traction[0], &traction[1], &traction[2], &slip[0], &slip[1], &stored})
      columns->assign(points, 0.0);
    for (auto& column : dissipated) column.assign(points, 0.0);
    for (auto& column : tangent) column.assign(points, 0.0);
    flags.assign(points, 0);
    const std::vector<double> initial = material.initial_state(law.initial_states[0]);
    for (std::uint64_t k = 0; k < law.state_count; ++k) {
      state[k].assign(points, initial[k]);
      state_old.push_back({state[k].data(), 1});
      state_new.push_back({state[k].data(), 1});
    }
    batch.struct_size = sizeof batch;
    batch.count = points;
    batch.normal_jump = {jump.data(), 1};
    for (int k = 0; k < 2; ++k) batch.slip_increment[k] = {slip[k].data(), 1};
    for (int k = 0; k < 3; ++k) {
      batch.traction_old[k] = {traction[k].data(), 1};
      batch.traction_new[k] = {traction[k].data(), 1};
    }
    batch.state_old = state_old.data();
    batch.state_new = state_new.data();
    batch.flags = {flags.data(), 1};
  }

  void want_energies() {
    batch.energy_stored = {stored.data(), 1};
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch.dissipated[k] = {dissipated[k].data(), 1};
  }
  void want_tangent() {
    for (int k = 0; k < 9; ++k) batch.tangent[k] = {tangent[k].data(), 1};
  }
  void step(double normal_jump, double slip_s, double slip_t) {
    jump.assign(jump.size(), normal_jump);
    slip[0].assign(jump.size(), slip_s);
    slip[1].assign(jump.size(), slip_t);
    evaluate();
  }
  void evaluate() {
    material.evaluate(batch);
    if (batch.failed_count > 0) std::abort();
  }

  adapters::Material material;
  std::vector<double> jump, slip[2], traction[3], stored, dissipated[QUOIN_DISSIPATED_COUNT], tangent[9];
  std::vector<std::vector<double>> state;
  std::vector<std::uint32_t> flags;
  quoin_batch batch{};

 private:
  std::vector<quoin_in> state_old;
  std::vector<quoin_out> state_new;
};

}  // namespace quoin::tests
