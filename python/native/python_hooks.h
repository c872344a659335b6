// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include <pybind11/pybind11.h>

#include "turnscale/commands/command_hooks.h"

namespace turnscale {

/// Lets Python take part in a command that runs without its lock: signals, such as Ctrl-C, stop it, and warnings become
/// Python's. What either raises is kept until the command has ended.
class PythonHooks {
 public:
  /// Puts itself into the hooks, which must not outlive it.
  void Join(CommandHooks& hooks);
  /// Raises what was kept. With Python's lock.
  void Raise();

 private:
  bool Interrupted();
  void Warn(const std::string& warning);

  std::optional<pybind11::error_already_set> raised_;
};

/// A command that has failed with results: the program's exit code says whose fault it is.
struct FailedCommand {
  Failure failure;
};

/// From here on, what the library throws becomes ValueError where the input cannot be used, else RuntimeError, with the
/// line that the program prints.
void TranslateErrors();

/// OpenCV prints its own errors beside ours unless it is silenced. It may be that of the user's program: only as long
/// as one of these is there.
class QuietLibraries {
 public:
  QuietLibraries();
  ~QuietLibraries();
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;
};

}  // namespace turnscale
