// A material that is evaluated in a process of its own, through shared memory: its law's crash ends that process.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "quoin.hpp"

namespace quoin {

// What that costs: the whole time of calls, and what of it the law had.
struct LawProcessTimes {
  long batches = 0;
  double seconds = 0.0, in_law = 0.0;
};

class LawProcess {
 public:
  // threads: largest number of calls at once. seconds: for one batch, then the process is ended (0: any time). Throws
  // Error(numerical) when the system starts no process.
  LawProcess(const quoin_law& law, const quoin_material* material, std::string path, int threads, double seconds);
  ~LawProcess();
  LawProcess(const LawProcess&) = delete;
  LawProcess& operator=(const LawProcess&) = delete;

  // As the law's own function; QUOIN_ERROR_INTERNAL once the process has ended, and fault() says how. A process that
  // was forked from ours starts a process of the law for itself here.
  quoin_status evaluate(quoin_batch* batch);
  std::string fault() const;  // empty: the law is well
  LawProcessTimes times() const;

 private:
  struct Impl;
  Impl& ours();
  // The last is that of this process, those before it of the processes that it was forked from.
  std::vector<std::unique_ptr<Impl>> started_;
  std::atomic<Impl*> current_;
  std::mutex starting_;
};

}  // namespace quoin
