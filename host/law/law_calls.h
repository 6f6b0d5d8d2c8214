// Laws that are being evaluated at this moment, by thread: so that one that never returns can be named.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "quoin.hpp"

namespace quoin {

class Material;

// What a thread is doing. Two plain stores a call: no clock is read.
struct alignas(64) LawCallSlot {
  std::atomic<const Material*> material{nullptr};  // null: in no law
  std::atomic<const quoin_batch*> batch{nullptr};
  std::atomic<unsigned long> calls{0};
  std::atomic<bool> taken{false};
};
inline constexpr std::size_t kLawCallSlots = 512;  // threads; more are not watched
extern std::array<LawCallSlot, kLawCallSlots> law_call_slots;
LawCallSlot* slot_of_this_thread();  // null: there is none left

// A call while this lives.
class LawCallNote {
 public:
  LawCallNote(const Material* material, const quoin_batch* batch) : slot_(slot_of_this_thread()) {
    if (!slot_) return;
    slot_->batch.store(batch, std::memory_order_relaxed);
    slot_->material.store(material, std::memory_order_release);
  }
  ~LawCallNote() {
    if (!slot_) return;
    slot_->material.store(nullptr, std::memory_order_relaxed);
    slot_->calls.store(slot_->calls.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  LawCallNote(const LawCallNote&) = delete;
  LawCallNote& operator=(const LawCallNote&) = delete;

 private:
  LawCallSlot* slot_;
};

// Calls `overdue`, from a thread of its own, when one call has lasted for so many seconds (0: never). It is expected to
// end the program: a thread inside a law cannot be taken out of it.
class LawWatchdog {
 public:
  using Overdue = std::function<void(const Material&, const quoin_batch&)>;
  LawWatchdog(double seconds, Overdue overdue);
  ~LawWatchdog();
  LawWatchdog(const LawWatchdog&) = delete;
  LawWatchdog& operator=(const LawWatchdog&) = delete;

 private:
  void watch(double seconds, const Overdue& overdue);
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ended_ = false;
  std::thread thread_;
};
inline constexpr double kLawSeconds = 60.0;  // for one batch, which takes microseconds

}  // namespace quoin
