// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "turnscale/io/terminal.h"

namespace turnscale {

/// The exit code of a command that was interrupted, as shells have it for Ctrl-C.
constexpr int kInterruptedExitCode = 130;

/// What the caller of a command that takes long is asked and told.
struct CommandHooks {
  /// Asked before every frame: whether to stop. Once it has said so, it has to go on saying so.
  std::function<bool()> interrupted = [] { return false; };
  /// Called before the images are read: from here on an interrupted command keeps its results so far, if it has any.
  std::function<void()> begun = [] {};
  /// Receives each warning, one line.
  std::function<void(const std::string&)> warn = {};
  /// Warnings go to standard error, too.
  bool print_warnings = true;
};

/// Thrown where a command is interrupted before it has results: while the camera is estimated.
struct Interruption {
  static constexpr const char* kMessage = "interrupted while the camera was estimated; nothing is written";
};

inline void Warn(const CommandHooks& hooks, const std::string& warning) {
  if (hooks.print_warnings) PrintMessage("warning: " + warning);
  if (hooks.warn) hooks.warn(warning);
}

/// The progress's warnings go where the hooks want them.
inline void SendWarnings(Progress& progress, const CommandHooks& hooks) {
  progress.OnWarning(hooks.warn, hooks.print_warnings);
}

}  // namespace turnscale
