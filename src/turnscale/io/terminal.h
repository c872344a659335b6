// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <exception>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace turnscale {

/// Prints a line on standard error. Control characters, which the names and contents of bad files may hold, are escaped
/// (base/escaped_text.h). A terminal that is gone is no reason to stop: nothing is thrown.
void PrintMessage(std::string_view line);

/// Prints lines for people on standard output, control characters other than line ends escaped. Throws OutputError
/// where the system refuses.
void PrintText(std::string_view lines);

/// Writes to standard output as it is, to the end. Throws OutputError where the system refuses.
void WriteStandardOutput(std::string_view text);

/// What an exception means to whoever started the program.
struct Failure {
  int exit_code = 1;    ///< 2 where the input cannot be used; 1 where the machine or we failed
  std::string message;  ///< one line: what, where, what to do
};

Failure FailureOf(const std::exception_ptr& thrown);

/// Prints "turnscale: " and the message, and returns the exit code.
int Report(const Failure& failure);

/// How far a run or a simulation is, on standard error: one line that renews itself on a terminal, else a plain line
/// now and then. What it shows depends on the clock; nothing else does.
class Progress {
 public:
  /// `frames` is how many are expected, 0 where that is not known; with more, it is no longer shown. Quiet leaves only
  /// warnings. `unit` is what is counted.
  Progress(int frames, bool quiet, std::string unit = "frame");
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Finishes: what is said of a run that failed gets a line of its own.
  ~Progress() { Finish(); }

  /// `more` is said after the rate.
  void Update(int frames_done, const std::string& more = "");
  /// What goes on after the frames, which may take a while; empty: it is over. On a terminal it is shown meanwhile,
  /// else as a line, unless the frames were a matter of seconds.
  void Say(const std::string& what);
  /// A line of its own, shown even when quiet.
  void Warn(const std::string& message);
  /// From now on each warning is given to `observer`, if there is one, and printed only where `printed` says so.
  void OnWarning(std::function<void(const std::string&)> observer, bool printed = true) {
    observer_ = std::move(observer);
    prints_warnings_ = printed;
  }
  /// Ends the line that renews itself.
  void Finish();

 private:
  using Clock = std::chrono::steady_clock;

  int frames_;
  bool quiet_;
  std::string unit_;
  bool on_terminal_;
  bool line_open_ = false;
  std::function<void(const std::string&)> observer_;
  bool prints_warnings_ = true;
  Clock::time_point start_ = Clock::now();
  Clock::time_point shown_ = start_;
  int shown_tenths_ = 0;
};

}  // namespace turnscale
