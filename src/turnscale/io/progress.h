// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <string>

#include "turnscale/odometry/results.h"

namespace turnscale {

/// How far a run or a simulation is, on standard error: one line that renews itself on a terminal, else a plain line
/// now and then. What it shows depends on the clock; nothing else does.
class Progress {
 public:
  /// `frames` is how many are expected, 0 where that is not known. Quiet leaves only warnings. `unit` is what is
  /// counted.
  Progress(int frames, bool quiet, std::string unit = "frame");
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Finishes: what is said of a run that failed gets a line of its own.
  ~Progress() { Finish(); }

  /// `more` is said after the rate.
  void Update(int frames_done, const std::string& more = "");
  /// A line of its own, shown even when quiet.
  void Warn(const std::string& message);
  /// Ends the line that renews itself.
  void Finish();

 private:
  using Clock = std::chrono::steady_clock;

  int frames_;
  bool quiet_;
  std::string unit_;
  bool on_terminal_;
  bool line_open_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point shown_ = start_;
  int shown_tenths_ = 0;
};

/// "pending", "observed" or "held".
const char* ScaleStateName(ScaleState state);

/// "initializing", "tracked", "repeated", "bridged" or "unreadable".
const char* TrackingStateName(TrackingState state);

}  // namespace turnscale
