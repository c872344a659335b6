// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// From now on SIGINT, SIGTERM or SIGHUP ends the process at once, with a message that nothing is written and the exit
/// code of an interrupted command. For the time before CatchInterrupts, while inputs are opened.
void EndOnInterrupts();
/// From now on the first SIGINT, SIGTERM or SIGHUP only asks the run to stop after the current frame; a second one ends
/// the process. SIGPIPE and SIGXFSZ end nothing: the write that causes them fails.
void CatchInterrupts();
bool Interrupted();

}  // namespace turnscale
