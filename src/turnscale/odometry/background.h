// SPDX-License-Identifier: MIT
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <system_error>
#include <type_traits>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "turnscale/base/error.h"

namespace turnscale {

/// Calls `work` on a thread of its own if OpenCV may use more than one and one can be started, else when its result is
/// asked for.
template <typename Work>
std::future<std::invoke_result_t<Work&>> InBackground(Work work) {
  // Shared: where no thread can be started, it is needed again.
  const auto shared = std::make_shared<Work>(std::move(work));
  const auto call = [shared] { return (*shared)(); };
  if (cv::getNumThreads() > 1) {
    try {
      return std::async(std::launch::async, call);
    } catch (const std::system_error&) {
      // No thread can be started.
    }
  }
  return std::async(std::launch::deferred, call);
}

/// A result that is computed in the background and taken at a keyframe that is fixed when the work starts, so that what
/// follows from it depends neither on how long the work takes nor on the number of threads.
template <typename Result>
class DueResult {
 public:
  /// Starts work whose result is due once there are `keyframes` keyframes. None may be pending.
  template <typename Work>
  void Start(int keyframes, Work work) {
    Ensure(!pending(), "the result of earlier work has not been taken");
    due_ = keyframes;
    result_ = InBackground([work = std::move(work)]() mutable { return std::make_shared<Result>(work()); });
  }

  /// Work was started, and its result has not been taken yet.
  bool pending() const { return result_.valid(); }

  /// Pending work is due now.
  void Hurry() { due_ = 0; }

  /// The result if one is pending and due; waits for it. Throws what the work threw.
  std::optional<Result> TakeIfDue(int keyframes) {
    if (!pending() || keyframes < due_) return std::nullopt;
    return std::move(*std::exchange(result_, {}).get());
  }

  /// The result of pending work, which stays to be taken; waits for it. Null if none is pending or the work threw,
  /// which TakeIfDue then does.
  const Result* Await() const {
    if (!pending()) return nullptr;
    try {
      return result_.get().get();
    } catch (...) {
      return nullptr;
    }
  }

 private:
  int due_ = 0;
  std::shared_future<std::shared_ptr<Result>> result_;
};

}  // namespace turnscale
