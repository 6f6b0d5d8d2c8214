// Evaluation of one contact point, for programs that call a law point by point.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/material.h"

namespace quoin::adapters {

constexpr std::uint64_t max_states = 32;

// Outputs of a step beyond traction and states; bits of a request. Other outputs are not computed.
namespace outputs {
constexpr unsigned nothing = 0, energies = 1, tangent = 2, flags = 4, all = 7;
}  // namespace outputs

// A batch of one point. All its columns but the states are members of this object, so that a step copies only numbers.
// Signs and units are those of the contract: tension and opening positive, traction in Pa, slip over the step.
class PointBatch {
 public:
  // Returns the batch of this thread for this law; asked: bits of outputs. Its members have the values of the last use.
  // Throws std::runtime_error if the law does not offer a requested output. Flags that it does not offer are 0.
  static PointBatch& of_thread(const quoin_law& law, unsigned asked);

  // Inputs
  double normal_jump = 0.0;
  double slip[2] = {0.0, 0.0};
  // Traction: on input the old one, on output the new one, or again the old one if the step failed.
  double traction[3] = {0.0, 0.0, 0.0};
  // Sets the caller's arrays of states at the start and the end of the next steps. Each has state_count numbers; they
  // are the same array or disjoint.
  void states(const double* old, double* now) {
    for (std::size_t k = 0; k < state_old_.size(); ++k) state_old_[k].data = old + k, state_new_[k].data = now + k;
  }
  // Outputs, set where requested
  double energy_stored = 0.0;
  double dissipated[QUOIN_DISSIPATED_COUNT] = {};
  double tangent[9] = {};  // row by row
  std::uint32_t flags = 0;

  // Evaluates a step and returns the status of the point (QUOIN_POINT_...). columns: per-point properties in place of
  // those of the material. Throws std::runtime_error when the law refuses the call.
  std::uint32_t evaluate(const Material& material, std::uint64_t column_count = 0,
                         const quoin_property_column* columns = nullptr) {
    batch_.property_column_count = column_count;
    batch_.property_columns = columns;
    material.evaluate(batch_);
    return batch_.worst_status;
  }

  // True if an internal variable changed in the last step.
  bool any_yielding() const { return batch_.any_yielding != 0; }

  PointBatch(const quoin_law& law, unsigned asked);  // for of_thread only
  PointBatch(const PointBatch&) = delete;
  PointBatch& operator=(const PointBatch&) = delete;

 private:
  std::vector<quoin_in> state_old_;
  std::vector<quoin_out> state_new_;
  quoin_batch batch_{};
};

}  // namespace quoin::adapters
