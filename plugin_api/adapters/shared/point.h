// One contact point and step, for programs that call a law point by point.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/material.h"

namespace quoin::adapters {

constexpr std::uint64_t max_states = 32;

// What a step requests of a law beyond traction and state. What is not requested is not computed.
namespace outputs {
constexpr unsigned nothing = 0, energies = 1, tangent = 2, flags = 4, all = 7;
}  // namespace outputs

// A batch of one point whose columns but for the states lie in this object: they are described once, a step only moves
// numbers. In the convention of the contract: tension and opening positive, traction in Pa, slip over the step.
class PointBatch {
 public:
  // The batch of this thread for this law; request: outputs::... It holds the numbers of its last use. Throws
  // std::runtime_error for a law that does not offer what is requested; flags that a law does not offer are 0.
  static PointBatch& of_thread(const quoin_law& law, unsigned asked);

  // In.
  double normal_jump = 0.0;
  double slip[2] = {0.0, 0.0};
  // Old in, new out; the old ones again where the step failed.
  double traction[3] = {0.0, 0.0, 0.0};
  // The caller's own states at the start and the end of the next steps, state_count each: the same, or disjoint.
  void states(const double* old, double* now) {
    for (std::size_t k = 0; k < state_old_.size(); ++k) state_old_[k].data = old + k, state_new_[k].data = now + k;
  }
  // Out, where requested.
  double energy_stored = 0.0;
  double dissipated[QUOIN_DISSIPATED_COUNT] = {};
  double tangent[9] = {};  // row by row
  std::uint32_t flags = 0;

  // Returns the status of the point (QUOIN_POINT_...). columns: properties of the point's own in place of the
  // material's. Throws std::runtime_error when the law refuses the call.
  std::uint32_t evaluate(const Material& material, std::uint64_t column_count = 0,
                         const quoin_property_column* columns = nullptr) {
    batch_.property_column_count = column_count;
    batch_.property_columns = columns;
    material.evaluate(batch_);
    return batch_.worst_status;
  }

  // After a step: whether any internal variable moved in it.
  bool any_yielding() const { return batch_.any_yielding != 0; }

  PointBatch(const quoin_law& law, unsigned asked);  // use of_thread
  PointBatch(const PointBatch&) = delete;
  PointBatch& operator=(const PointBatch&) = delete;

 private:
  std::vector<quoin_in> state_old_;
  std::vector<quoin_out> state_new_;
  quoin_batch batch_{};
};

}  // namespace quoin::adapters
