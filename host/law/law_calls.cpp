#include "law/law_calls.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <system_error>

#include "base/error.h"
#include "files/notice.h"
#include "law/law_library.h"

namespace quoin {

std::array<LawCallSlot, kLawCallSlots> law_call_slots;

namespace {

struct Holder {
  LawCallSlot* slot = nullptr;
  Holder() {
    for (LawCallSlot& s : law_call_slots) {
      if (!s.taken.exchange(true)) {
        slot = &s;
        return;
      }
    }
  }
  ~Holder() {
    if (slot) slot->taken = false;
  }
};

}  // namespace

LawCallSlot* slot_of_this_thread() {
  thread_local const Holder holder;
  return holder.slot;
}

LawWatchdog::LawWatchdog(double seconds, Overdue overdue) {
  if (seconds <= 0.0) return;
  try {
    thread_ = std::thread([this, seconds, overdue = std::move(overdue)] { watch(seconds, overdue); });
  } catch (const std::system_error&) {  // without threads there is no watch
  }
}

LawWatchdog::~LawWatchdog() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard guard(mutex_);
    ended_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

LawWatchdog::Overdue end_program(double seconds, const std::string& option) {
  return [=](const Material& material, const quoin_batch& batch) {
    notices_wanted = true;
    notice(
        fmt::format("quoin: the law '{}' of {} has not returned from a batch of {} points within {:g} s; tell its "
                    "author{}",
                    material.api().id, material.law().library->path(), batch.count, seconds,
                    option.empty() ? "" : fmt::format(", or give it more time with {}", option)));
    _exit(static_cast<int>(Exit::numerical));
  };
}

void LawWatchdog::watch(double seconds, const Overdue& overdue) {
  using Clock = std::chrono::steady_clock;
  struct Seen {
    unsigned long calls = 0;
    Clock::time_point since = Clock::now();
  };
  std::array<Seen, kLawCallSlots> seen;
  const auto period = std::chrono::duration<double>(std::min(seconds / 4.0, 1.0));
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, period, [&] { return ended_; })) {
    const auto now = Clock::now();
    for (std::size_t i = 0; i < law_call_slots.size(); ++i) {
      const LawCallSlot& slot = law_call_slots[i];
      const Material* const material = slot.material.load(std::memory_order_acquire);
      const unsigned long calls = slot.calls.load(std::memory_order_relaxed);
      if (!material || calls != seen[i].calls) {
        seen[i] = {calls, now};
      } else if (std::chrono::duration<double>(now - seen[i].since).count() >= seconds) {
        overdue(*material, *slot.batch.load(std::memory_order_relaxed));
        seen[i].since = now;
      }
    }
  }
}

}  // namespace quoin
