#include "law/at_rest.h"

#include <algorithm>

namespace quoin {

AnswerAtRest evaluate_at_rest(const Material& material, const RestingPoints& points,
                              const std::function<void(quoin_batch&)>& add_outputs) {
  const std::size_t n = points.count;
  std::vector<double> zero(n, 0.0), unused((3 + points.state.size()) * n);
  std::vector<quoin_in> old;
  std::vector<quoin_out> fresh;
  for (std::size_t k = 0; k < points.state.size(); ++k) {
    old.push_back({points.state[k], 1});
    fresh.push_back(points.state[k] ? quoin_out{unused.data() + (3 + k) * n, 1} : quoin_out{});
  }
  quoin_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = n;
  batch.normal_jump = {points.normal_jump, 1};
  for (auto& increment : batch.slip_increment) increment = {zero.data(), 1};
  for (std::size_t k = 0; k < 3; ++k) {
    batch.traction_old[k] = {points.traction[k], 1};
    batch.traction_new[k] = {unused.data() + k * n, 1};
  }
  batch.state_old = old.data(), batch.state_new = fresh.data();
  batch.property_column_count = points.properties.size(), batch.property_columns = points.properties.data();
  add_outputs(batch);
  const quoin_status status = material.evaluate(&batch);
  return {status, batch.failed_count};
}

bool carries_tension(const Material& material, const std::string& initial_state) {
  constexpr double kOpening = 1e-9;  // m
  const quoin_law& law = material.api();
  const bool known = std::any_of(law.initial_states, law.initial_states + law.initial_state_count,
                                 [&](const char* id) { return initial_state == id; });
  if (!known) return false;
  const std::vector<double> state = material.initial_state(initial_state);
  constexpr double kNone = 0.0;
  double sigma = 0.0;
  RestingPoints point{1, &kOpening, {&kNone, &kNone, &kNone}, {}};
  for (const double& value : state) point.state.push_back(&value);
  evaluate_at_rest(material, point, [&](quoin_batch& batch) { batch.traction_new[0] = {&sigma, 1}; });
  material.require_no_fault(Exit::law_refused);
  return sigma > 0.0;
}

}  // namespace quoin
