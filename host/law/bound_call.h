// Calls of a law in a step: a batch bound to the columns of consecutive contact points, and the results of the last
// call.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "law/answers.h"
#include "law/law_library.h"

namespace quoin {

// Columns of the contact points of a call. Pointers are to the first point; the caller owns what they point to.
struct CallColumns {
  std::size_t count = 0;
  std::array<double*, 3> traction{};                // Pa, old and new in one place
  std::vector<double*> state{};                     // in the order of the law, as traction; null: not kept
  std::vector<quoin_property_column> properties{};  // properties that scatter
};

struct BoundCall {
  quoin_batch batch{};
  std::vector<quoin_in> state_old{};
  std::vector<quoin_out> state_new{};
  std::vector<quoin_property_column> properties{};
  // Results of the last call:
  quoin_status status = QUOIN_OK;
  bool failed = false;
  double stored = 0.0;                                      // elastic energy, J
  std::array<double, QUOIN_DISSIPATED_COUNT> dissipated{};  // energies dissipated in the step, J
  double damping = 0.0;                                     // energy taken by damping of contacts in the step, J

  // Binds all but jumps and energies.
  void bind(CallColumns columns);
  // Opening and slip increments, m.
  void bind_jumps(const double* normal, const double* slip_s, const double* slip_t);
  // Energy densities, J/m2; null: the law does not compute them.
  void bind_energies(double* stored_column, const std::array<double*, QUOIN_DISSIPATED_COUNT>& dissipated_columns);
  // Evaluates the law, and returns whether it failed: refused the batch or failed at a point.
  bool evaluate(const Material& material);

  // visit(first byte, bytes): results, for other ranks.
  template <class Visit>
  void each_result(const Visit& visit) {
    visit(&stored, sizeof stored), visit(&dissipated, sizeof dissipated), visit(&damping, sizeof damping);
    visit(&status, sizeof status), visit(&failed, sizeof failed);
    visit(&batch.failed_count, sizeof batch.failed_count);
  }
};

Answers answers_of(const BoundCall& call);  // tractions and states of its points

// Place and time of a call, for messages.
struct CallSite {
  long step;
  double time;                // s
  double time_step_fraction;  // of the solver
  std::string family;         // joint family
  std::string points;         // place of the batch: "contact points 0 to 255 of joint family 'mortar'"
  std::function<std::string(std::size_t point)> point;  // "blocks 3 and 4, contact point at (...)"
};

// Throws Error(numerical) for a call that failed: the end of the law's process, the status of the batch, or the first
// point that failed. To find that point it evaluates the law once more: failed points keep their old state.
[[noreturn]] void report_failed_call(const Material& material, const BoundCall& call, const CallSite& site);

}  // namespace quoin
