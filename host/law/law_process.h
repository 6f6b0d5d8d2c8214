// Evaluation of a material in a separate process through shared memory: a crash of its law ends only that process.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "quoin.hpp"

namespace quoin {

// Cost of separate processes: total time of calls, and the law's part of it.
struct LawProcessTimes {
  long batches = 0;
  double seconds = 0.0, in_law = 0.0;
};

class LawProcess {
 public:
  // threads: largest number of calls at once. seconds: time limit of a batch, after which the process is killed (0:
  // none). Throws Error(numerical) where the system cannot start a process.
  LawProcess(const quoin_law& law, const quoin_material* material, std::string path, int threads, double seconds);
  ~LawProcess();
  LawProcess(const LawProcess&) = delete;
  LawProcess& operator=(const LawProcess&) = delete;

  // Calls the law's function in the process. Returns QUOIN_ERROR_INTERNAL after the process has ended; fault() then has
  // the reason. In a fork of our process, this starts another process of the law.
  quoin_status evaluate(quoin_batch* batch);
  std::string fault() const;  // empty: the process runs
  LawProcessTimes times() const;

 private:
  struct Impl;
  Impl& ours();
  // One per process that this one was forked from, then its own.
  std::vector<std::unique_ptr<Impl>> started_;
  std::atomic<Impl*> current_;
  std::mutex starting_;
};

}  // namespace quoin
