// Calls that may fail while other ranks wait for this one: later calls are skipped, and the first error is thrown at
// the end.
#pragma once

#include <exception>

namespace quoin {

class Attempt {
 public:
  // Calls what(), unless an earlier call has failed.
  template <class Do>
  void operator()(const Do& what) {
    if (fault_) return;
    try {
      what();
    } catch (...) {
      fault_ = std::current_exception();
    }
  }
  bool failed() const { return fault_ != nullptr; }
  void rethrow() const {
    if (fault_) std::rethrow_exception(fault_);
  }

 private:
  std::exception_ptr fault_;
};

}  // namespace quoin
