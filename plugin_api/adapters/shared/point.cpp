#include "shared/point.h"

#include <array>
#include <memory>
#include <stdexcept>

namespace quoin::adapters {

namespace {

struct LawBatches {
  const quoin_law* law;
  std::array<std::unique_ptr<PointBatch>, outputs::all + 1> by_outputs;
};

// A plain pointer, since a thread_local with a constructor costs a test at every use. The TLS model initial-exec places
// it at a fixed offset in the thread's memory, which avoids a function call at every use.
#if defined(__ELF__)
[[gnu::tls_model("initial-exec")]]
#endif
constinit thread_local LawBatches* latest = nullptr;

LawBatches& batches_of(const quoin_law& law) {
  thread_local std::vector<std::unique_ptr<LawBatches>> all;
  for (const std::unique_ptr<LawBatches>& known : all)
    if (known->law == &law) return *known;
  all.push_back(std::make_unique<LawBatches>());
  all.back()->law = &law;
  return *all.back();
}

}  // namespace

PointBatch& PointBatch::of_thread(const quoin_law& law, unsigned asked) {
  if (latest == nullptr || latest->law != &law) latest = &batches_of(law);
  std::unique_ptr<PointBatch>& batch = latest->by_outputs[asked];
  if (batch == nullptr) batch = std::make_unique<PointBatch>(law, asked);
  return *batch;
}

PointBatch::PointBatch(const quoin_law& law, unsigned asked) {
  const auto can = [&](std::uint64_t capability) { return (law.capabilities & capability) != 0; };
  if (((asked & outputs::energies) != 0 && !can(QUOIN_CAN_ENERGY)) ||
      ((asked & outputs::tangent) != 0 && !can(QUOIN_CAN_TANGENT)))
    throw std::runtime_error(std::string(law.id) + " offers no " +
                             ((asked & outputs::energies) != 0 && !can(QUOIN_CAN_ENERGY) ? "energies" : "tangent"));
  for (std::uint64_t k = 0; k < law.state_count; ++k) {
    state_old_.push_back({nullptr, 1});
    state_new_.push_back({nullptr, 1});
  }
  batch_.struct_size = sizeof batch_;
  batch_.count = 1;
  batch_.normal_jump = {&normal_jump, 1};
  for (int k = 0; k < 2; ++k) batch_.slip_increment[k] = {slip + k, 1};
  for (int k = 0; k < 3; ++k) {
    batch_.traction_old[k] = {traction + k, 1};
    batch_.traction_new[k] = {traction + k, 1};
  }
  batch_.state_old = state_old_.data();
  batch_.state_new = state_new_.data();
  if ((asked & outputs::energies) != 0) {
    batch_.energy_stored = {&energy_stored, 1};
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch_.dissipated[k] = {dissipated + k, 1};
  }
  if ((asked & outputs::tangent) != 0)
    for (int k = 0; k < 9; ++k) batch_.tangent[k] = {tangent + k, 1};
  if ((asked & outputs::flags) != 0 && can(QUOIN_CAN_FLAGS)) batch_.flags = {&flags, 1};
}

}  // namespace quoin::adapters
