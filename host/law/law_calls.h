// Calls of laws in progress, by thread: so that a message can name a law that never returns.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "quoin.hpp"

namespace quoin {

class Material;

// The law call of a thread. A call costs two plain stores; no clock is read.
struct alignas(64) LawCallSlot {
  std::atomic<const Material*> material{nullptr};  // null: no law is called
  std::atomic<const quoin_batch*> batch{nullptr};
  std::atomic<unsigned long> calls{0};
  std::atomic<bool> taken{false};
};
inline constexpr std::size_t kLawCallSlots = 512;  // number of threads; further threads are not watched
extern std::array<LawCallSlot, kLawCallSlots> law_call_slots;
LawCallSlot* slot_of_this_thread();  // null: no slot is left

// Registers a call for the lifetime of the object.
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

// Calls `overdue`, from a thread of its own, when one call has lasted this many seconds (0: never). `overdue` should
// end the program: a thread cannot be taken out of a law.
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
inline constexpr double kLawSeconds = 60.0;  // for one batch, whose evaluation takes microseconds

// For work without results to be kept: ends the program with a message that names the law. option: sets the limit;
// empty: none does.
LawWatchdog::Overdue end_program(double seconds, const std::string& option = "");

}  // namespace quoin
