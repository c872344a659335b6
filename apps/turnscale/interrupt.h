// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// The exit code of a run that was interrupted, as shells have it for Ctrl-C.
constexpr int kInterruptedExitCode = 130;

/// From now on the first SIGINT or SIGTERM only asks the run to stop after the current frame; a second one ends the
/// process.
void CatchInterrupts();
bool Interrupted();

}  // namespace turnscale
