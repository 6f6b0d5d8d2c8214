// What may fail while others wait for us: they are served to the end, and the first fault is thrown after that.
#pragma once

#include <exception>

namespace quoin {

class Attempt {
 public:
  // Nothing is done any more once something has failed.
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
