#include "law/bound_call.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>

#include "base/error.h"

namespace quoin {

void BoundCall::bind(CallColumns columns) {
  batch = {};
  batch.struct_size = sizeof batch;
  batch.count = columns.count;
  for (std::size_t k = 0; k < 3; ++k)
    batch.traction_old[k] = {columns.traction[k], 1}, batch.traction_new[k] = {columns.traction[k], 1};
  state_old.clear(), state_new.clear();
  for (double* const column : columns.state) state_old.push_back({column, 1}), state_new.push_back({column, 1});
  batch.state_old = state_old.data(), batch.state_new = state_new.data();
  properties = std::move(columns.properties);
  batch.property_column_count = properties.size(), batch.property_columns = properties.data();
}

void BoundCall::bind_jumps(const double* normal, const double* slip_s, const double* slip_t) {
  batch.normal_jump = {normal, 1};
  batch.slip_increment[0] = {slip_s, 1}, batch.slip_increment[1] = {slip_t, 1};
}

void BoundCall::bind_energies(double* stored_column,
                              const std::array<double*, QUOIN_DISSIPATED_COUNT>& dissipated_columns) {
  const auto column = [](double* data) { return data ? quoin_out{data, 1} : quoin_out{}; };
  batch.energy_stored = column(stored_column);
  for (std::size_t k = 0; k < dissipated_columns.size(); ++k) batch.dissipated[k] = column(dissipated_columns[k]);
}

bool BoundCall::evaluate(const Material& material) {
  status = material.evaluate(&batch);
  return failed = status != QUOIN_OK || batch.failed_count > 0;
}

Answers answers_of(const BoundCall& call) {
  Answers answers{call.batch.count, {}, {}};
  for (std::size_t k = 0; k < 3; ++k) answers.traction[k] = call.batch.traction_old[k].data;
  for (const quoin_in& column : call.state_old) answers.state.push_back(column.data);
  return answers;
}

void report_failed_call(const Material& material, const BoundCall& call, const CallSite& site) {
  const std::string law = material.api().id;
  if (const std::string fault = material.fault(); !fault.empty())
    throw Error(Exit::numerical, fmt::format("step {}, {}: {}", site.step, site.points, fault));
  if (call.status != QUOIN_OK) {
    throw Error(Exit::numerical, fmt::format("law '{}' of joint family '{}' refused a batch with status {} at step {}",
                                             law, site.family, call.status, site.step));
  }
  if (call.batch.count == 0)
    throw Error(Exit::numerical, fmt::format("law '{}' failed at step {}, on another rank", law, site.step));
  // Old tractions and states are what the law gave in a step before. They make all jumps around them wrong.
  if (const auto wrong = wrong_answer(material.api(), answers_of(call)); wrong && !wrong->finite) {
    throw Error(Exit::numerical,
                fmt::format("{}, before step {}, time {:.6g} s: joint family '{}', {}; tell its author", wrong->text,
                            site.step, site.time, site.family, site.point(wrong->point)));
  }
  std::vector<std::uint32_t> point_status(call.batch.count, QUOIN_POINT_OK);
  quoin_batch batch = call.batch;
  batch.status = {point_status.data(), 1};
  material.evaluate(&batch);
  const auto first = std::find(point_status.begin(), point_status.end(), std::uint32_t{QUOIN_POINT_FAILED});
  if (first == point_status.end()) {
    throw Error(Exit::numerical,
                fmt::format("law '{}' says at step {} that {} points failed, and names none: {}; tell its author", law,
                            site.step, call.batch.failed_count, site.points));
  }
  const auto i = first - point_status.begin();
  const auto at = [i](const quoin_in& column) { return column.data[i * column.stride]; };
  const auto &jump = batch.normal_jump, &slip_s = batch.slip_increment[0], &slip_t = batch.slip_increment[1];
  const auto& traction = batch.traction_old;
  throw Error(Exit::numerical,
              fmt::format("law '{}' failed at {} of {} points at step {}, time {:.6g} s: joint family '{}', {}, "
                          "opening {:.6g} m, slip in the step ({:.6g}, {:.6g}) m, traction ({:.6g}, {:.6g}, {:.6g}) "
                          "Pa. A smaller solver.time_step_fraction than {:g} may help",
                          law, call.batch.failed_count, call.batch.count, site.step, site.time, site.family,
                          site.point(static_cast<std::size_t>(i)), at(jump), at(slip_s), at(slip_t), at(traction[0]),
                          at(traction[1]), at(traction[2]), site.time_step_fraction));
}

}  // namespace quoin
