// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/parallel_runs.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace turnscale {
namespace {

/// What the workers share.
class Queue {
 public:
  Queue(int runs, const RunProgress& progress) : runs_(runs), progress_(progress) {}

  /// The next run to do; -1 where there is none.
  int Next() {
    const std::scoped_lock lock(mutex_);
    return stopped_ || next_ == runs_ ? -1 : next_++;
  }

  void Done() {
    const std::scoped_lock lock(mutex_);
    if (progress_ && !progress_(++done_, runs_)) stopped_ = true;
  }

  void Failed(std::exception_ptr error) {
    const std::scoped_lock lock(mutex_);
    if (!error_) error_ = std::move(error);
    stopped_ = true;
  }

  bool Finish() const {
    if (error_) std::rethrow_exception(error_);
    return !stopped_;
  }

 private:
  std::mutex mutex_;
  int runs_;
  const RunProgress& progress_;
  int next_ = 0;
  int done_ = 0;
  bool stopped_ = false;
  std::exception_ptr error_;
};

}  // namespace

bool ParallelRuns(int runs, int jobs, const std::function<void(int)>& run, const RunProgress& progress) {
  Queue queue(runs, progress);
  const auto work = [&] {
    for (int i = queue.Next(); i >= 0; i = queue.Next()) {
      try {
        run(i);
        queue.Done();
      } catch (...) {
        queue.Failed(std::current_exception());
      }
    }
  };
  std::vector<std::jthread> workers;
  for (int i = 1; i < std::min(jobs, runs); ++i) workers.emplace_back(work);
  work();
  workers.clear();
  return queue.Finish();
}

}  // namespace turnscale
