// SPDX-License-Identifier: MIT
#pragma once

#include <exception>
#include <vector>

namespace turnscale {

/// Does one thing after another whatever becomes of each, and keeps what they threw.
class Attempts {
 public:
  /// Returns whether `work` came to its end.
  template <class Work>
  bool Try(const Work& work) {
    try {
      work();
      return true;
    } catch (...) {
      failures_.push_back(std::current_exception());
      return false;
    }
  }

  /// In the order of time.
  const std::vector<std::exception_ptr>& failures() const { return failures_; }

  /// Throws the first failure, if there was one.
  void RethrowFirst() const {
    if (!failures_.empty()) std::rethrow_exception(failures_.front());
  }

 private:
  std::vector<std::exception_ptr> failures_;
};

}  // namespace turnscale
